"""Changes of a knowledge base: of its files a reader sees the old or the new ones, whenever their writer is killed.

All that is new is written into a folder beside, each file by its path in the knowledge base. Renamed to ``CHANGE``,
this folder is in force: that is the one step in which everything changes. Then each file is moved to its place, and
the folder goes. A writer that is killed in between has changed everything: whoever reads or writes next moves what is
left, and who may not write reads it where it lies (``kb.files.folder.Folder``).

* ``with writing(root) as writer: writer.change({root / "kb.yaml": data})``: nobody else changes it meanwhile
* ``settle(root)``: what a killed writer left is moved
* ``holder(root)``: the process that is changing it
"""

import errno
import fcntl
import os
import shutil
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

from geometry.digits import whole
from geometry.files.begun import folder_beside, is_at, sweep, sync, synced, told_of
from geometry.files.plain_files import IS_FOLDER, fault_of
from kb.errors import BusyError, KBError

CHANGE, LOCK = ".plogic-change", ".plogic-lock"
"""In a knowledge base's folder: what is in force and not moved yet; a file whose text is the process that has its
lock."""
AT_ONCE = 0.5
"""Seconds of patience with who is about to end, as a reader that settles is."""
SETTLING = 2.0
"""Seconds that a reader waits for a writer that is alive to move its files: it takes milliseconds."""
STEP = 0.02
"""Seconds between two looks."""
MOST_PID = 2**31
NO_LOCK = "is no lock that plogic made, but a link, a folder or the like"
"""What is wrong with whatever else stands in its place."""


class Writer:
    """Who may change the knowledge base in the folder ``root``."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def change(self, files: Mapping[Path, bytes]) -> None:
        """Write files of the knowledge base, old and new ones, all or none; what is written outlives a loss of power.

        Raises:
            KBError: One of them cannot be written, or lies elsewhere.
        """
        inside = {self._inside(path): data for path, data in files.items()}
        with told_of(self.root, KBError):
            with folder_beside(self.root / CHANGE) as begun:
                for name, data in inside.items():
                    (begun / name).parent.mkdir(parents=True, exist_ok=True)
                    (begun / name).write_bytes(data)
                synced(begun)
                begun.rename(self.root / CHANGE)
            with suppress(OSError):
                sync(self.root)
            _move(self.root)

    def _inside(self, path: Path) -> Path:
        """The path in the knowledge base."""
        try:
            return (Path(os.path.realpath(path.parent)) / path.name).relative_to(os.path.realpath(self.root))
        except ValueError:
            raise KBError(f"{path}: leads out of the knowledge base's folder") from None


@contextmanager
def writing(root: Path, patience: float = AT_ONCE) -> Iterator[Writer]:
    """Have the knowledge base to oneself for changing it; what a killed writer left is moved, or removed, first.

    Raises:
        BusyError: Another process is changing it, and has not ended after ``patience`` seconds.
        KBError: Nobody may write there.
    """
    with told_of(root, KBError):
        handle = _had(root, monotonic() + patience)
    try:
        with told_of(root, KBError):
            os.truncate(handle, 0)
            os.write(handle, str(os.getpid()).encode())
            sweep(root)
            _move(root)
        yield Writer(root)
    finally:
        (root / LOCK).unlink(missing_ok=True)
        os.close(handle)


def _had(root: Path, end: float) -> int:
    """The descriptor that holds the lock; raises BusyError where there is none to be had before the ``end``."""
    while (handle := _locked(root / LOCK)) is None:
        if monotonic() >= end:
            who = holder(root)
            raise BusyError(
                f"{root}: {f'process {who}' if who else 'another process'} is changing it: wait until it has ended"
            )
        sleep(STEP)
    return handle


def _locked(lock: Path) -> int | None:
    """The descriptor that holds the lock; None where another process does.

    Where the file system has no locks, nobody is kept out.
    """
    while True:
        try:
            handle = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o644)
        except OSError as error:
            if error.errno in (errno.EISDIR, errno.ELOOP, errno.ENXIO):
                raise KBError(f"{lock}: {NO_LOCK}: remove it") from None
            raise
        if not _is_own(handle):
            os.close(handle)
            raise KBError(f"{lock}: {NO_LOCK}: remove it")
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            return None
        except OSError:
            return handle
        if is_at(handle, lock):
            return handle
        os.close(handle)  # who had it has just removed it


def _is_own(handle: int) -> bool:
    """Whether it is a plain file with no other name, so that nothing but a lock is written over."""
    found = os.fstat(handle)
    return stat.S_ISREG(found.st_mode) and found.st_nlink <= 1


def has_no_lock(root: Path) -> bool:
    """Whether something stands in the place of the lock that is none: a folder, a link, a file of another name."""
    try:
        found = (root / LOCK).lstat()
    except OSError:
        return False
    return not stat.S_ISREG(found.st_mode) or found.st_nlink > 1


def holder(root: Path) -> int | None:
    """The number of the process that is changing a knowledge base, as it says itself, 0 where it does not.

    None where no process is.
    """
    try:
        handle = os.open(root / LOCK, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return whole(os.read(handle, 20).decode("ascii", "replace"), MOST_PID) or 0
    finally:
        os.close(handle)
    return None


def is_left(root: Path) -> bool:
    """Whether there is a lock of a writer that was killed."""
    return fault_of(root / LOCK) is None and not has_no_lock(root) and holder(root) is None


def is_changing(root: Path) -> bool:
    """Whether a change is in force whose files are not all at their places."""
    return fault_of(root / CHANGE) == IS_FOLDER and not (root / CHANGE).is_symlink()


def settle(root: Path) -> None:
    """Move, or remove, what a killed writer left, if this process may; wait for one that is alive to move its files.

    Raises nothing.
    """
    end = monotonic() + SETTLING
    while (is_changing(root) or is_left(root)) and monotonic() < end:
        try:
            with writing(root):
                return
        except BusyError:
            sleep(STEP)
        except (KBError, OSError):
            return


def _move(root: Path) -> None:
    """Move the files of a change in force to their places, none of them out of the folder, whatever it holds."""
    change, real = root / CHANGE, Path(os.path.realpath(root))
    if not is_changing(root):
        return
    folders = {root}
    for place, _, names in os.walk(change):
        target = root / Path(place).relative_to(change)
        if not Path(os.path.realpath(target)).is_relative_to(real):
            continue
        for name in names:
            with suppress(IsADirectoryError, NotADirectoryError, FileExistsError):  # no writer of ours left that
                target.mkdir(parents=True, exist_ok=True)
                (Path(place) / name).replace(target / name)
                folders |= {target, target.parent}
    for folder in folders:
        with suppress(OSError):
            sync(folder)
    shutil.rmtree(change, ignore_errors=True)
