"""The console script: the command line, or one sentence where a file of the user's own hides a part of it."""

import sys
from importlib import import_module

from plogic.base.hidden import COMMAND, PACKAGES, hidden


def main() -> None:
    """Run ``plogic``; the module of the command line, which stands above all floors, is found by its name."""
    told = hidden((*PACKAGES, COMMAND))
    if told is not None:
        sys.stderr.write(f"plogic: {told}\n")
        sys.exit(1)
    import_module(COMMAND).main()
