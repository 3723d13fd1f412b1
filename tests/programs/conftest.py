"""ProbLog ships an old pyparsing: imported once, quietly."""

from plogic.program.author import load_problog

load_problog()
