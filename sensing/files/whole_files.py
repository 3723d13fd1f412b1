"""Files that are written whole or not at all."""

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from io import FileIO
from pathlib import Path

from geometry.files.begun import file_beside, folder_beside, synced, told_of
from geometry.files.plain_files import IS_FOLDER, IS_MISSING, NO_PLAIN_FILE, TOO_LONG, fault_of, is_there
from sensing.errors import SensingError


def write_whole(path: Path, data: bytes) -> None:
    """Write ``data`` beside ``path`` and rename it into place; on any failure nothing is left.

    Where it is a link, that is done where it leads; where a device or a pipe stands, ``data`` goes into it.

    Raises:
        SensingError: The place cannot be written; the message names it.
    """
    write_files({path: data})


def write_files(files: Mapping[Path, bytes]) -> None:
    """As ``write_whole``, for many: every file is written beside its place before any is renamed into it.

    A process that is killed between two renames has written some of them; each is whole.

    Raises:
        SensingError: One of the places cannot be written; then none is.
    """
    check_places(files)
    with ExitStack() as stack:
        begun = {}
        for path, data in files.items():
            if not _is_stream(path):
                with told_of(path, SensingError):
                    place = Path(os.path.realpath(path))
                    begun[place] = path, stack.enter_context(file_beside(place, data))
        for path in files:
            if _is_stream(path):
                _into(path, files[path])
        for place, (path, temporary) in begun.items():
            with told_of(path, SensingError):
                temporary.replace(place)


def check_places(places: Iterable[Path], read: Iterable[str | Path | None] = ()) -> None:
    """Raise SensingError for the first place where no file can be written, before the work is done.

    Nor may one be that is ``read``, or lies in a folder that is: it would be lost.
    """
    given = [os.path.realpath(name) for name in read if name is not None and fault_of(Path(name)) in (None, IS_FOLDER)]
    for path in places:
        if is_there(path) and any(Path(os.path.realpath(path)).is_relative_to(one) for one in given):
            raise SensingError(f"{path}: is read, too: name another place for what is written")
        if _is_stream(path):
            if not os.access(path, os.W_OK):
                raise SensingError(f"{path}: cannot be written: Permission denied")
            continue
        folder = path.parent
        here, above = fault_of(path), fault_of(folder)
        wrong = "Is a directory" if here == IS_FOLDER else "No such directory" if above == IS_MISSING else None
        wrong = "Not a directory" if above not in (IS_FOLDER, IS_MISSING) else wrong
        wrong = "File name too long" if TOO_LONG in (here, above) else wrong
        wrong = "Permission denied" if wrong is None and not os.access(folder, os.W_OK) else wrong
        if wrong is not None:
            raise SensingError(f"{path}: cannot be written: {wrong}")


def check_new_folder(folder: Path) -> None:
    """Raise SensingError where no new folder can be made, before the work that it should hold is done."""
    fault = fault_of(folder)
    if fault == TOO_LONG:
        raise SensingError(f"{folder}: cannot be written: File name too long")
    if is_there(folder) and (fault != IS_FOLDER or any(folder.iterdir())):
        raise SensingError(f"{folder}: exists already and is not an empty folder")
    for above in folder.parents:
        if above.exists() and not above.is_dir():
            raise SensingError(f"{folder}: cannot be written: {above} is no folder")


_OPENED = re.compile(r"/dev/(?:fd/(?P<number>\d{1,6})|std(?P<name>out|err))")
"""Names of what this process has open already, and its caller may have written to: a pipe, or a file."""


def _is_stream(path: Path) -> bool:
    """Whether a device or a pipe stands there, or what is open already, whose place no file may take."""
    return _opened(path) is not None or fault_of(path) == NO_PLAIN_FILE


def _opened(path: Path) -> int | None:
    """The number of the stream that a name means, which may lead to a file: its place is no place for another."""
    name = re.sub(r"^/proc/(?:self|thread-self)/fd/", "/dev/fd/", str(path))
    match = _OPENED.fullmatch(name)
    return None if match is None else int(match["number"] or {"out": 1, "err": 2}[match["name"]])


def _into(path: Path, data: bytes) -> None:
    number = _opened(path)
    with told_of(path, SensingError), FileIO(path if number is None else os.dup(number), "wb") as stream:
        left = memoryview(data)
        while left:
            left = left[stream.write(left) :]


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """A folder to write into that becomes ``folder`` at the end, and is removed where anything goes wrong.

    Where ``folder`` is there and cannot be another, as the one that somebody works in, its content is moved in at the
    end, name by name.

    Raises:
        SensingError: ``folder`` exists and is not empty, or cannot be written.
    """
    check_new_folder(folder)
    with told_of(folder, SensingError):
        place = Path(os.path.realpath(folder))
        place.parent.mkdir(parents=True, exist_ok=True)
        stays = place.exists() and (place.is_mount() or place == Path(os.path.realpath(os.curdir)))
        with folder_beside(place / "all" if stays else place) as begun:
            yield begun
            synced(begun)
            if stays:
                for path in sorted(begun.iterdir()):
                    path.replace(place / path.name)
            else:
                begun.replace(place)


def write_folder(folder: Path, files: Mapping[str, bytes], empty: Iterable[str] = ()) -> None:
    """Write a new folder with ``files`` (relative path → bytes) and ``empty`` folders, whole or not at all.

    Raises SensingError as ``new_folder`` does.
    """
    with new_folder(folder) as made:
        for name in empty:
            (made / name).mkdir()
        for name, data in files.items():
            (made / name).parent.mkdir(parents=True, exist_ok=True)
            (made / name).write_bytes(data)
