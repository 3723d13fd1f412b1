"""Files and folders that are only begun: beside their place, and locked as long as their writer lives.

What a killed writer left is removed by the next that begins anything in the same folder. Whatever is locked has a
writer that is alive, on this machine or, where the file system carries locks, on another; nothing of any other name,
and no other user's, is touched. Where a file system has no locks, nothing is removed.

* ``with file_beside(place, data) as begun: begun.replace(place)``: written, and on the disk, before it is renamed
* ``with folder_beside(place) as begun``: so with a folder; what is not renamed is gone at the end
* ``with scratch() as folder``: one that nobody else reads, where the system has temporary files
* ``sweep(folder)``, ``left_in(folder)``: what killed writers left is removed, or told
* ``with told_of(place, SensingError)``: an OSError says of the place that it cannot be written
"""

import errno
import fcntl
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import lru_cache
from pathlib import Path

MARK = "plogic-begun-"
"""In the names of what is begun: nobody else's files are called so."""
SHARED, PRIVATE = 0o777, 0o700
"""Of a folder: whoever the user's mask lets read what is in it, or the user alone."""
_BEGUN = re.compile(rf"\..*\.{MARK}[a-z0-9_]{{8}}", re.DOTALL)
_LONG = 40
"""Characters of the place's name that are kept, so that one as long as a name may be can be begun."""


@contextmanager
def file_beside(place: Path, data: bytes) -> Iterator[Path]:
    """A new file with its data on the disk. Raises OSError."""
    handle, begun = _locked(place, lambda folder, prefix: Path(_closed(*tempfile.mkstemp(dir=folder, prefix=prefix))))
    try:
        with os.fdopen(os.dup(handle), "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(handle)
        begun.chmod(_mode_of(place))
        yield begun
    finally:
        begun.unlink(missing_ok=True)
        os.close(handle)


@contextmanager
def folder_beside(place: Path, mode: int = SHARED) -> Iterator[Path]:
    """A new folder. Raises OSError."""
    handle, begun = _locked(place, lambda folder, prefix: Path(tempfile.mkdtemp(dir=folder, prefix=prefix)))
    try:
        begun.chmod(mode & ~_mask())
        yield begun
    finally:
        shutil.rmtree(begun, ignore_errors=True)
        os.close(handle)


def _mode_of(place: Path) -> int:
    """The permissions of the file that stands there, or those of a new one."""
    try:
        return stat.S_IMODE(place.stat().st_mode) & 0o777
    except OSError:
        return 0o666 & ~_mask()


def _mask() -> int:
    """The permissions that the user takes from new files: it can only be read by setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


def scratch() -> AbstractContextManager[Path]:
    """A new folder for files that go at the end, or with the next process that makes one. Raises OSError."""
    return folder_beside(temporary() / "scratch", PRIVATE)


def temporary() -> Path:
    """The folder where the system has temporary files. Raises OSError where there is none, or no room in any."""
    try:
        return Path(tempfile.gettempdir())
    except FileNotFoundError:
        raise OSError(errno.ENOSPC, "no folder for temporary files can be written to (TMPDIR)") from None


def _closed(handle: int, name: str) -> str:
    os.close(handle)
    return name


def _locked(place: Path, make: Callable[[Path, str], Path]) -> tuple[int, Path]:
    """What ``make`` makes beside a place, and the descriptor that locks it."""
    swept_once(place.parent)
    while True:
        begun = make(place.parent, f".{place.name.lstrip('.')[:_LONG]}.{MARK}")
        with suppress(FileNotFoundError):  # somebody took it for left over before it was locked
            handle = os.open(begun, (os.O_RDONLY if begun.is_dir() else os.O_RDWR) | os.O_CLOEXEC)
            with suppress(OSError):
                fcntl.flock(handle, fcntl.LOCK_EX)
            if is_at(handle, begun):
                return handle, begun
            os.close(handle)


def is_at(handle: int, place: Path) -> bool:
    """Whether an open file still stands at a place."""
    try:
        return os.path.samestat(os.fstat(handle), place.lstat())
    except FileNotFoundError:
        return False


@lru_cache(maxsize=256)
def swept_once(folder: Path) -> None:
    """``sweep`` a folder, the first time that this process writes into it."""
    sweep(folder)


def sweep(folder: Path) -> None:
    """Remove what killed writers began in a folder."""
    for begun in _begun_in(folder):
        with suppress(OSError), _unlocked(begun) as own:
            if own and begun.is_dir():
                shutil.rmtree(begun)
            elif own:
                begun.unlink()


def left_in(folder: Path) -> list[Path]:
    """What killed writers began in a folder, in order; nothing that somebody is writing. Raises nothing."""
    left = []
    for begun in _begun_in(folder):
        with suppress(OSError), _unlocked(begun) as own:
            left += [begun] * own
    return left


def _begun_in(folder: Path) -> list[Path]:
    try:
        return sorted(path for path in folder.iterdir() if _BEGUN.fullmatch(path.name))
    except OSError:
        return []


@contextmanager
def _unlocked(begun: Path) -> Iterator[bool]:
    """Lock what nobody else has locked; whether it is this user's. Raises OSError where it is locked, or gone."""
    handle = os.open(begun, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield os.fstat(handle).st_uid == os.geteuid()
    finally:
        os.close(handle)


def synced(place: Path) -> None:
    """Have a file, or a folder with all that is in it, on the disk. Raises OSError."""
    for path in [place, *place.rglob("*")] if place.is_dir() else [place]:
        sync(path)


def sync(path: Path) -> None:
    """Have a file, or the names in a folder, on the disk. Raises OSError."""
    handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def told_of(place: Path, error: Callable[[str], Exception]) -> Iterator[None]:
    """Say of an OSError, as another error, which place cannot be written."""
    try:
        yield
    except OSError as fault:
        raise error(f"{place}: cannot be written: {fault.strerror}") from None
