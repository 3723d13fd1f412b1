"""A session about a scene or a program: the verbs of the shell, what they answer, and the prompt."""
