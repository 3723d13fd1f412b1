"""ProbLog is loaded once, its own deprecation warnings aside."""

from plogic.logic.safety.author import load_problog

load_problog()
