"""The console script: the command line, or one sentence where a file of the user's own hides a part of it."""

import gc
import sys
from importlib import import_module

from plogic.base.hidden import COMMAND, PACKAGES, hidden

OBJECTS = 10_000
"""New objects after which Python looks for unreachable circles, 700 by default.

``plogic worlds`` of a learned scene of 15,000 data took 0.37 s so, and 0.42 s by default (median of seven).
"""


def main() -> None:
    """Run ``plogic``; the module of the command line, which stands above all floors, is found by its name."""
    gc.set_threshold(OBJECTS)
    told = hidden((*PACKAGES, COMMAND))
    if told is not None:
        sys.exit(f"plogic: {told.encode('unicode_escape').decode()}")  # what prints else may be what is hidden
    import_module(COMMAND).main()
