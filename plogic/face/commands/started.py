"""The console script: the command line, or one sentence where a file of the user's own hides a part of it."""

import gc
import os
import sys
from importlib import import_module
from typing import NoReturn

from plogic.base.hidden import COMMAND, PACKAGES, hidden

OBJECTS = 10_000
"""New objects after which Python looks for unreachable circles, 700 by default.

``plogic worlds`` of a learned scene of 15,000 data took 0.37 s so, and 0.42 s by default (median of seven).
"""


def main() -> None:
    """Run ``plogic``; the module of the command line, which stands above all floors, is found by its name."""
    gc.set_threshold(OBJECTS)
    try:
        told = hidden((*PACKAGES, COMMAND)) or _nowhere()
        if told is not None:
            sys.exit(f"plogic: {told.encode('unicode_escape').decode()}")  # what prints else may be what is hidden
        command = import_module(COMMAND)
    except ImportError as error:
        _without(error)
    except KeyboardInterrupt:  # later ones are the command's
        sys.exit("Aborted!")
    else:
        command.main()


def _nowhere() -> str | None:
    """What is said where the working folder is gone."""
    try:
        os.getcwd()  # noqa: PTH109 - pathlib takes 10 ms to import
    except OSError as error:
        return f"the working folder cannot be used ({error.strerror}): go to another one"
    return None


def _without(error: ImportError) -> NoReturn:
    """What can be done where a package is missing, or cannot be loaded."""
    if os.environ.get("PLOGIC_TRACEBACK"):
        raise error
    if sys.argv[1:2] == ["doctor"]:
        from plogic.face.commands.doctor import doctor_alone

        sys.exit(doctor_alone(sys.argv[2:]))
    why = str(error).encode("unicode_escape").decode()
    sys.exit(f"plogic: the installation is not whole: {why}; plogic doctor tells more")
