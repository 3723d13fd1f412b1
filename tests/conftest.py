"""ProbLog brings an old pyparsing: it is imported once, its deprecation warnings aside."""

from plogic.logic.safety.author import load_problog

load_problog()
