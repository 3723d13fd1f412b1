"""The shell: the verbs of ``plogic.session`` at a prompt, or line by line from a file."""
