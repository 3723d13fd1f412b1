"""What earlier runs left: what they keep to be quicker, and what killed ones could not take away."""

import os
import pickletools
import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from geometry.files.begun import left_in, temporary
from geometry.files.remembered import ROOT, bytes_of, cache_folder, damage, kept_in
from plogic.run.health.findings import REPAIRS, Finding, counted, size

CACHES, SCRATCH = "caches", "scratch"
MEASURED = 100_000_000
"""Bytes of each cache that are held to their checksums, of what was used last; of the rest sizes alone."""


def caches(*, fix: bool) -> Iterator[Finding]:
    """Each cache: how much it keeps, what of it is damaged, and what was begun and left."""
    top = cache_folder("")
    if top is None:
        yield Finding(CACHES, "folder", "note", "nobody knows your home: nothing is kept", "set HOME or XDG_CACHE_HOME")
        return
    inside = sorted(top.iterdir()) if top.is_dir() else []
    folders = [path for path in inside if path.is_dir() and not path.is_symlink()]
    if not folders:
        yield Finding(CACHES, str(top), "fine", "is empty")
    for folder in folders:
        yield from _cache(folder, fix=fix)
    yield from _compiled(fix=fix)


def _cache(folder: Path, *, fix: bool) -> Iterator[Finding]:
    kept, total, wrong = kept_in(folder), 0, list[tuple[Path, str]]()
    for place in kept:
        total += bytes_of(place)
        fault = damage(place, measured=total <= MEASURED)
        if fault is not None:
            wrong.append((place, fault))
    what = f"{counted(len(kept), 'entry', 'entries')}, {size(total)}, in {folder}"
    if not wrong:
        yield Finding(CACHES, folder.name, "fine", what)
    else:
        place, fault = wrong[0]
        told = f"{len(wrong)} damaged of {what}: {place.name[:12]}... {fault}"
        yield removed(Finding(CACHES, folder.name, "wrong", told, REPAIRS), [place for place, _ in wrong], fix=fix)
    begun = left_in(folder)
    if begun:
        told = f"{counted(len(begun), 'entry', 'entries')} begun in {folder} and left by a process that was killed"
        yield removed(Finding(CACHES, folder.name, "note", told, REPAIRS), begun, fix=fix)


def _compiled(*, fix: bool) -> Iterator[Finding]:
    """What numba keeps of our loops: an index (.nbi) a function, which is a pickle, and code (.nbc)."""
    places = [ROOT / "sensing" / room / "__pycache__" for room in ("detectors", "pixels", "views")]
    files = sorted(file for place in places if place.is_dir() for file in place.glob("*.nb[ic]"))
    top, own = cache_folder(""), os.environ.get("NUMBA_CACHE_DIR")
    places += [] if top is None else [top.parent / "numba"]
    places += [Path(own)] if own else []
    torn = [file for file in files if not _is_pickle(file)]
    what = f"{counted(len(files), 'file', 'files')} of compiled loops, {size(sum(map(bytes_of, files)))}"
    if torn:
        found = Finding(CACHES, "numba", "wrong", f"{len(torn)} damaged of {what}: {torn[0]}", REPAIRS)
        yield removed(found, torn, fix=fix)
    elif not any(map(_takes, places)):  # numba does not read where it may not write, either
        told = "no folder takes compiled loops: each run with photos compiles them"
        yield Finding(CACHES, "numba", "note", told, "set NUMBA_CACHE_DIR to a folder that can be written to")
    else:
        told = what if files else "no loops are compiled yet: the first photo takes longer"
        yield Finding(CACHES, "numba", "fine", told)


def _takes(place: Path) -> bool:
    """Whether files may be written there, or the folder made."""
    return os.access(next(path for path in (place, *place.absolute().parents) if path.exists()), os.W_OK)


def _is_pickle(file: Path) -> bool:
    """Whether a file is whole pickles up to its end; nothing of them is run."""
    whole = 0
    try:
        with file.open("rb") as opened:
            while opened.peek(1):
                whole += any(code.name == "STOP" for code, _, _ in pickletools.genops(opened))
    except (OSError, ValueError):
        return False
    return whole > 0


def scratch(*, fix: bool) -> Iterator[Finding]:
    """The folders of processes that were killed."""
    try:
        left = left_in(temporary())
    except OSError as error:
        yield Finding(SCRATCH, "folders", "note", f"{error.strerror}")
        return
    if not left:
        yield Finding(SCRATCH, "folders", "fine", "nothing is left behind")
        return
    told = f"{counted(len(left), 'folder', 'folders')} left by processes that were killed: {left[0]}"
    yield removed(Finding(SCRATCH, "folders", "note", told, REPAIRS), left, fix=fix)


def removed(found: Finding, places: list[Path], *, fix: bool) -> Finding:
    """Remove places, if that is to be, and say so; what cannot be removed stays as it was found."""
    if not fix:
        return found
    for place in places:
        if place.is_dir() and not place.is_symlink():
            shutil.rmtree(place, ignore_errors=True)
        with suppress(OSError):
            place.unlink()
    there = [place for place in places if place.exists() or place.is_symlink()]
    if there:
        return Finding(
            found.area, found.name, "wrong", f"{found.told}; {there[0]} cannot be removed", "remove it by hand"
        )
    return Finding(found.area, found.name, "repaired", f"{found.told}; removed")
