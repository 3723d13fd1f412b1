"""ProbLog is loaded once, its own deprecation warnings aside."""

from plogic.program.author import load_problog

load_problog()
