"""Two new folders in one step: whenever their writer is killed, a reader finds both or none.

No system renames two folders at once. So the other is renamed into the one, and a link leads from its place to where
it will be then: nowhere as yet. The rename of the one is the step in which both are there. Then link and folder change
places, which Linux does in one step too.

* ``with two_new_folders(one, other) as (first, second)``: folders to be made and written, inside a folder that is begun
* ``finish(one, other)``: what a killed writer left of the last steps is done
"""

import ctypes
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from geometry.files.begun import folder_beside, swept_once, sync, synced, told_of
from sensing.errors import SensingError
from sensing.files.whole_files import check_new_folder

INSIDE = ".plogic-other"
"""In the one folder: the other, until it is at its place."""
AT_WORKING_FOLDER, EXCHANGE = -100, 2
"""Linux's numbers: a path that is relative is so to the working folder; two places exchange what they hold."""


@contextmanager
def two_new_folders(one: Path, other: Path) -> Iterator[tuple[Path, Path]]:
    """Two folders to make and to write into that become ``one`` and ``other``; none does where anything goes wrong.

    Neither lies in the other.

    Raises:
        SensingError: One of them exists and is not empty, or cannot be written.
    """
    for folder in (one, other):
        check_new_folder(folder)
    with told_of(one, SensingError):
        one.parent.mkdir(parents=True, exist_ok=True)
        with folder_beside(one) as begun:
            yield begun / "one", begun / "other"
            (begun / "other").rename(begun / "one" / INSIDE)
            synced(begun / "one")
            with _linked(one, other):
                (begun / "one").replace(one)
    finish(one, other)


@contextmanager
def _linked(one: Path, other: Path) -> Iterator[None]:
    """A link from ``other`` to where it will be, which goes where that comes to nothing."""
    with told_of(other, SensingError):
        other.parent.mkdir(parents=True, exist_ok=True)
        if other.is_dir():  # it is empty
            other.rmdir()
        other.symlink_to(_target(one, other))
    try:
        yield
    except BaseException:
        other.unlink()
        raise


def finish(one: Path, other: Path) -> None:
    """Put ``other`` where a link of a writer that was killed leads to it; remove a link that leads nowhere.

    Raises:
        SensingError: That cannot be done.
    """
    swept_once(one.parent)
    inside = one / INSIDE
    if inside.is_symlink():  # they changed places
        with told_of(one, SensingError):
            inside.unlink()
    if not other.is_symlink() or str(other.readlink()) != _target(one, other):
        return
    with told_of(other, SensingError):
        if not inside.is_dir():
            other.unlink()
        elif _exchanged(inside, other):
            inside.unlink()
        else:
            with folder_beside(other) as begun:
                shutil.move(inside, begun / "other")
                other.unlink()
                (begun / "other").rename(other)
        sync(other.parent)


def _target(one: Path, other: Path) -> str:
    return os.path.relpath(Path(os.path.realpath(one)) / INSIDE, os.path.realpath(other.parent))


def _exchanged(one: Path, other: Path) -> bool:
    """Whether two places exchanged what they hold, in one step: on Linux, within a file system that can."""
    rename = getattr(ctypes.CDLL(None), "renameat2", None)
    places = os.fsencode(one), os.fsencode(other)
    return rename is not None and not rename(AT_WORKING_FOLDER, places[0], AT_WORKING_FOLDER, places[1], EXCHANGE)
