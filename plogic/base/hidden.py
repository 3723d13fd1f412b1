"""Modules of a user's own that hide ours.

A ``geometry.py`` beside a script comes before the package ``geometry`` that plogic brings.

Nothing of ours but the standard library is imported here: it may be hidden.
"""

import os
import sys
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("geometry", "kb", "sensing")
"""The packages that plogic brings beside itself."""
COMMAND = "cli"
"""The module of the command line."""
ROOT = Path(__file__).parents[2]
"""The folder that all of them lie in."""


def hidden(names: Iterable[str] = PACKAGES) -> str | None:
    """Return one sentence that names the file which hides one of ours; None where nothing is hidden."""
    for name in names:
        place = _place(name)
        if place is not None and not _is_ours(place, name):
            kind = "module" if name == COMMAND else "package"
            return f"{place}: hides the {kind} {name!r} that plogic brings; rename it, or move it out of sys.path"
    return None


def _place(name: str) -> str | None:
    """The file, or the folder, that ``import name`` finds; None where it finds nothing."""
    module = sys.modules.get(name)
    if module is not None:
        return getattr(module, "__file__", None) or next(iter(getattr(module, "__path__", [])), None)
    spec = find_spec(name)
    if spec is None:
        return None
    return spec.origin or next(iter(spec.submodule_search_locations or ()), None)


def _is_ours(place: str, name: str) -> bool:
    ours = (ROOT / name / "__init__.py", ROOT / f"{name}.py")
    return any(os.path.realpath(place) == os.path.realpath(file) for file in ours)
