"""Computed arrays kept on disk, found again by all that decides them: their input, our own source, the libraries.

Nobody has to remember to change a version: what other code made is not found, and made anew. Folders are named by a
key, ``<64 hex digits>``, side by side in a cache folder; the time of modification says which was used last. Whoever has
mapped a file of a deleted folder keeps it.

* ``arrays_of(place, names, make)``: arrays that are mapped from files, or made and put there
* ``source_digest(root, files)``: what code it is, of all of some folders (``sources_in``), or of what one file imports
  (``sources``)
* ``forget_beside(place)``: of the folder's siblings those stay that were used last
* ``forget_files_beside(place)``: so of files ``<64 hex digits>.npz``
* ``kept_in(folder)``, ``damage(place)``: what is kept in a cache folder, and what is wrong with one of the kept
"""

import ast
import hashlib
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from geometry.files.begun import PRIVATE, folder_beside
from geometry.files.plain_files import fault_of

FOLDERS, BYTES = 8, 2 << 30
"""So many folders are kept at most, of so many bytes together; one always is."""
FILES = 1024
"""So many files are kept at most, of ``BYTES`` together; one always is."""
_NAME = "[0-9a-f]{64}"


def forget_beside(place: Path, folders: int = FOLDERS, most: int = BYTES) -> None:
    """Delete a folder's siblings that were used least lately, beyond the kept ones.

    Nothing else is touched: no file, and no folder of another name.
    """
    _forget(place, Path.is_dir, _NAME, folders, most)


def forget_files_beside(place: Path, files: int = FILES, most: int = BYTES) -> None:
    """As ``forget_beside``, of files; no folder and no file of another name is touched."""
    _forget(place, Path.is_file, rf"{_NAME}\.npz", files, most)


def bytes_of(place: Path) -> int:
    """The bytes of a kept folder, or of a file; 0 where it is gone."""
    try:
        return sum(file.stat().st_size for file in (place.iterdir() if place.is_dir() else [place]))
    except OSError:
        return 0


def _forget(place: Path, is_one: Callable[[Path], bool], name: str, count: int, most: int) -> None:
    try:
        beside = {path: path.stat() for path in place.parent.iterdir() if is_one(path) and not path.is_symlink()}
    except OSError:  # another process forgets at the same time
        return
    total = 0
    named = (path for path in beside if re.fullmatch(name, path.name))
    for rank, path in enumerate(sorted(named, key=lambda path: (path != place, -beside[path].st_mtime))):
        total += bytes_of(path)
        if rank and (rank >= count or total > most):
            discard(path)


def discard(place: Path) -> None:
    """Delete what is at a place, if anything and if that can be done.

    A folder is moved away first, so that nobody finds half of it, and nobody's new one is hit.
    """
    with suppress(OSError):  # another process was first, or nobody may
        if not place.is_dir():
            place.unlink()
            return
        with folder_beside(place, PRIVATE) as aside:
            place.rename(aside / place.name)


def kept_in(folder: Path) -> list[Path]:
    """The folders and files of a cache folder that are kept, the one used last first; none where it cannot be read."""
    found = []
    with suppress(OSError):  # another process forgets at the same time
        named = (path for path in sorted(folder.iterdir()) if re.fullmatch(rf"{_NAME}(\.npz)?", path.name))
        found = sorted(((-path.lstat().st_mtime, path) for path in named), key=lambda one: one[0])
    return [path for _, path in found]


def damage(place: Path, *, measured: bool) -> str | None:
    """What is wrong with a kept folder of arrays, or a kept ``.npz``; None for one as it was written.

    ``measured``: held to its checksums, 0.4 s a gigabyte, and not to its sizes alone.
    """
    try:
        if place.is_dir():
            said = json.loads(_plain(place / MANIFEST).read_bytes())
            files = {
                _file(place, name): {"bytes": row["bytes"], "crc32": row["crc32"]}
                for name, row in said["arrays"].items()
            }
            whole = said["key"] == place.name and all(
                (_measured(_plain(file)) == row) if measured else file.stat().st_size == row["bytes"]
                for file, row in files.items()
            )
            return None if whole else "is not what was written"
        with ZipFile(_plain(place)) as file:
            return None if not measured or file.testzip() is None else "is not what was written"
    except (OSError, ValueError, LookupError, TypeError, AttributeError, BadZipFile, RecursionError) as error:
        return f"cannot be read: {' '.join(str(error).split())[:100]}"


ROOT = Path(__file__).parents[2]
"""The folder that our packages lie in."""
OURS = "geometry", "kb", "sensing", "plogic", "cli"
"""The packages in it that are ours.

An installed plogic lies among everybody's, an environment may lie in a checkout.
"""
MANIFEST = "manifest.json"
"""The file beside kept arrays that says what they are."""


def cache_folder(what: str) -> Path | None:
    """Where such things are kept; None where nobody knows the home. A variable that is no whole path says nothing."""
    home = os.environ.get("XDG_CACHE_HOME", "")
    try:
        return (Path(home) if Path(home).is_absolute() else Path.home() / ".cache") / "plogic" / what
    except RuntimeError:
        return None


def arrays_of(
    place: Path, names: Iterable[str], make: Callable[[], Mapping[str, NDArray[Any]]], folders: int = FOLDERS
) -> dict[str, NDArray[Any]]:
    """The arrays ``names`` in the folder ``place``, mapped and read-only.

    Else those that ``make`` gives, which are put there if that can be done.

    A folder is written whole or not at all; one that is not, to the byte, what its manifest says was written is made
    anew. Of its siblings those used last are kept, ``folders`` with it (``geometry.files.remembered``).
    """
    with suppress(Exception):  # whatever is wrong with what is kept, it can be made anew
        return _kept(place, tuple(names))
    made = dict(make())
    _write(place, made, folders)
    return made


def _kept(place: Path, names: tuple[str, ...]) -> dict[str, NDArray[Any]]:
    """What is kept; raises where anything is missing, or is not as it was written."""
    files = {name: _plain(_file(place, name)) for name in names}
    arrays: dict[str, NDArray[Any]] = {name: np.lib.format.open_memmap(file, mode="r") for name, file in files.items()}
    if _plain(place / MANIFEST).read_bytes() != _manifest(place, place.name, arrays):
        raise ValueError(f"{place}: is not what was written")
    with suppress(OSError):  # who may only read it uses it all the same
        os.utime(place)
    return arrays


def _plain(file: Path) -> Path:
    """A file that ends. Raises OSError for a pipe, a device or nothing."""
    fault = fault_of(file)
    if fault is not None:
        raise OSError(f"{file.name} {fault}")
    return file


def _file(place: Path, name: str) -> Path:
    return place / f"{name}.npy"


def _manifest(place: Path, key: str, arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """What the files in ``place`` are, as JSON: whose key, and of each its type, shape, length and checksum."""
    said = {
        name: {"dtype": a.dtype.str, "shape": a.shape, **_measured(_file(place, name))}
        for name, a in sorted(arrays.items())
    }
    return json.dumps({"key": key, "arrays": said}, indent=1).encode()


def _measured(file: Path) -> dict[str, int]:
    """Against damage, not malice: of the checksums at hand CRC-32 takes least, 0.4 s a gigabyte."""
    with file.open("rb") as opened, mmap(opened.fileno(), 0, access=ACCESS_READ) as content:
        return {"bytes": len(content), "crc32": crc32(content)}


def _write(place: Path, made: Mapping[str, NDArray[Any]], folders: int) -> None:
    """Beside its place first; where that fails, nothing is remembered, and nothing is left."""
    with suppress(OSError):
        place.parent.mkdir(parents=True, exist_ok=True)
        with folder_beside(place, PRIVATE) as begun:
            for name, array in made.items():
                np.save(_file(begun, name), array, allow_pickle=False)
            (begun / MANIFEST).write_bytes(_manifest(begun, place.name, made))
            discard(place)
            begun.rename(place)
        forget_beside(place, folders)


def sources_in(root: Path, places: Iterable[str]) -> set[str]:
    """All source files below ``root`` in some folders of it, and those that are named themselves."""
    found = {
        file for place in places for file in ([root / place] if place.endswith(".py") else (root / place).rglob("*.py"))
    }
    return {file.relative_to(root).as_posix() for file in found}


def source_digest(root: Path, files: Iterable[str]) -> bytes:
    """SHA-256 over the names and the bytes of files below ``root``, in whatever order they come."""
    total = hashlib.sha256()
    for name in sorted(files):
        total.update(name.encode() + b"\0" + hashlib.sha256((root / name).read_bytes()).digest())
    return total.digest()


def sources(root: Path, first: str, packages: Iterable[str] = OURS) -> set[str]:
    """Return a source file and all others of ``packages`` that it imports, in functions too, directly or not.

    Names are relative to ``root``. What is imported for the type checker alone is left out. So is the code of objects
    that are made elsewhere and
    handed in: for those all sources count (``sources_in``), or what they hold is hashed.
    """
    found, left, ours = {first}, [first], set(packages)
    while left:
        tree = ast.parse((root / left.pop()).read_bytes())
        imported = (name for node in _run(tree) for name in _imported(node))
        names = (name.replace(".", "/") for name in imported if name.split(".")[0] in ours)
        new = {
            file for name in names for file in (f"{name}.py", f"{name}/__init__.py") if (root / file).is_file()
        } - found
        found |= new
        left += new
    return found


def _run(node: ast.AST) -> Iterator[ast.AST]:
    """All statements below a node but those of ``if TYPE_CHECKING:``."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
            continue
        if isinstance(child, ast.stmt | ast.excepthandler | ast.match_case):
            yield child
            yield from _run(child)


def _imported(node: ast.AST) -> list[str]:
    """The modules that an import may name: of ``from kb import words`` both ``kb`` and ``kb.words``."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.module is not None:
        return [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return []
