"""ProbLog ships an old pyparsing: imported once, quietly."""

from plogic.logic.safety.author import load_problog

load_problog()
