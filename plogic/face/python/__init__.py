"""The face for Python: what ``from plogic import ...`` gives.

Objects whose methods are the verbs of the command line.
"""
