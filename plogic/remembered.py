"""What was computed before, on disk, by all that decides it: its input, our own source, the libraries.

Nobody has to remember to change a version: what other code made is not found, and made anew.

* ``arrays_of(place, make)``: arrays that are mapped from files, or made and put there
"""

from __future__ import annotations

import ast
import hashlib
import os
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from numpy.typing import NDArray

ROOT = Path(__file__).parents[1]
"""The folder that our packages lie in."""


def cache_folder(what: str) -> Path | None:
    """Where such things are kept; None where nobody knows the user's home."""
    home = os.environ.get("XDG_CACHE_HOME")
    try:
        return (Path(home) if home else Path.home() / ".cache") / "plogic" / what
    except RuntimeError:
        return None


def arrays_of(place: Path, names: Iterable[str], make: Callable[[], Mapping[str, NDArray[Any]]]) -> dict[str, NDArray[Any]]:
    """The arrays ``names`` in the folder ``place``, mapped and read-only; else those that ``make`` gives, which are put there if that can be done.

    A folder is written whole or not at all; one that cannot be read is made anew.
    """
    try:
        return {name: np.load(place / f"{name}.npy", mmap_mode="r", allow_pickle=False) for name in names}
    except (OSError, ValueError, EOFError):
        made = dict(make())
        _write(place, made)
        return made


def _write(place: Path, made: Mapping[str, NDArray[Any]]) -> None:
    """Beside its place first; where that fails, nothing is remembered, and nothing is left."""
    beside = ""
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        beside = tempfile.mkdtemp(prefix=f".{place.name}-", dir=place.parent)
        for name, array in made.items():
            np.save(Path(beside) / f"{name}.npy", array, allow_pickle=False)
        shutil.rmtree(place, ignore_errors=True)
        Path(beside).rename(place)
    except OSError:
        if beside:
            shutil.rmtree(beside, ignore_errors=True)


def source_digest(root: Path, files: Iterable[str]) -> bytes:
    """SHA-256 over the names and the bytes of files below ``root``, in whatever order they come."""
    total = hashlib.sha256()
    for name in sorted(files):
        total.update(name.encode() + b"\0" + hashlib.sha256((root / name).read_bytes()).digest())
    return total.digest()


def sources(root: Path, first: str) -> set[str]:
    """A source file below ``root`` and all others there that it imports, at its top or in a function, directly or by way of others.

    What is imported for the type checker alone decides nothing and is left out.
    """
    found, left = {first}, [first]
    while left:
        tree = ast.parse((root / left.pop()).read_bytes())
        names = (name.replace(".", "/") for node in _run(tree) for name in _imported(node))
        new = {file for name in names for file in (f"{name}.py", f"{name}/__init__.py") if (root / file).is_file()} - found
        found |= new
        left += new
    return found


def _run(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes below one but those of ``if TYPE_CHECKING:``."""
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield child
            yield from _run(child)


def _imported(node: ast.AST) -> list[str]:
    """The modules that an import may name: of ``from kb import words`` both ``kb`` and ``kb.words``."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.module is not None:
        return [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return []
