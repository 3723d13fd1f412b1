"""Operations of a process on the files in a folder: counted, and what lies there before each is kept.

CPython itself tells each file that is opened to be written, renamed or removed (``sys.addaudithook``); what is written
and synced is counted by stand-ins of ``open``, ``os.write`` and ``os.fsync``.

* ``Hook(folder, told, blobs)``: before each operation a line of JSON, ``{"what": ..., "held": ...}``, goes to ``told``
* ``Hook(folder, told, last=7)``: kills the process, by SIGKILL, before the seventh; of a write, half is done first
* ``held(folder, blobs)``: what lies in a folder, by its path: a folder, where a link leads, or the digest of contents
  that are kept in ``blobs``; ``laid(found, folder, blobs)`` puts it there again
"""

from __future__ import annotations

import builtins
import fcntl
import io
import json
import os
import re
import shutil
import signal
import sys
from hashlib import sha256
from pathlib import Path
from typing import Any

from kb.files.changes import LOCK

AUDITED = {
    "open": 0, "os.rename": 1, "os.remove": 0, "os.rmdir": 0, "os.mkdir": 0, "os.truncate": 0, "os.chmod": 0,
    "os.link": 1, "os.symlink": 1,
}  # fmt: skip
"""Operations that CPython tells, and which of what it tells is the place."""
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
FOLDER, LINK, FILE = "folder", "link", "file"
RANDOM = re.compile(r"(?<=plogic-begun-)[a-z0-9_]{8}")
"""In names of what is begun."""
BEGUN = re.compile(r"((?:.*/)?\.[^/]*\.plogic-begun-)(?:/.*)?", re.DOTALL)
"""What is begun, and what is in it."""

Held = dict[str, tuple[str, str]]
"""What is at each path, by its kind: where a link leads, or a file's digest."""


class Hook:
    """Counts a process's operations on files in ``folder``."""

    def __init__(self, folder: Path, told: int, blobs: Path | None = None, last: int | None = None) -> None:
        """``told``: a descriptor; ``last``: from 1."""
        self._folder, self._told, self._blobs, self._last = folder, told, blobs, last
        self._count, self._pid, self._known = 0, 0, dict[tuple[int, ...], str]()
        self._write, self._open, self._sync, self._cut = os.write, io.open, os.fsync, os.ftruncate

    def install(self) -> None:
        """From now on, for good, in this process alone."""
        self._pid = os.getpid()
        sys.addaudithook(self._audited)
        io.open = builtins.open = self._opened
        os.fsync, os.ftruncate = self._synced, self._shortened
        os.write = self._written  # type: ignore[assignment]

    def step(self, what: str, place: object, half: bytes = b"") -> None:
        """An operation is next: of a write, which ``half`` of it a kill may have let through."""
        if os.getpid() != self._pid or not self._concerns(place):
            return
        self._count += 1
        told: dict[str, Any] = {"what": f"{what} {self._place(place)}"}
        if self._blobs is not None:
            told["held"] = held(self._folder, self._blobs, self._known)
            if half and isinstance(place, int):
                self._halve(told["held"], place, half, self._blobs)
        self._write(self._told, json.dumps(told).encode() + b"\n")
        if self._count == self._last:
            if half and isinstance(place, int):
                self._write(place, half)
            os.kill(self._pid, signal.SIGKILL)

    def _halve(self, found: Held, fd: int, half: bytes, blobs: Path) -> None:
        """Have the half of a write in the file that it goes to, unless that has no name any more."""
        name = str(Path(self._place(fd) or "").relative_to(self._folder))
        if name in found:
            old = (blobs / found[name][1]).read_bytes()
            appends = fcntl.fcntl(fd, fcntl.F_GETFL) & os.O_APPEND
            at = len(old) if appends else os.lseek(fd, 0, os.SEEK_CUR)
            found[name] = FILE, kept(old[:at].ljust(at, b"\0") + half + old[at + len(half) :], blobs)

    def _concerns(self, place: object) -> bool:
        return (self._place(place) or "").startswith(f"{self._folder}{os.sep}")

    def _place(self, place: object) -> str | None:
        if isinstance(place, int):
            try:
                return str(Path(f"/proc/self/fd/{place}").readlink())
            except OSError:
                return None
        return str(Path.cwd() / os.fsdecode(place)) if isinstance(place, str | bytes | os.PathLike) else None

    def _audited(self, event: str, told: tuple[Any, ...]) -> None:
        which = AUDITED.get(event)
        if which is None or (event == "open" and not told[2] & WRITES):
            return
        place, folder = told[which], told[-1]
        if event in ("os.remove", "os.rmdir") and isinstance(folder, int) and folder >= 0:
            place = f"{self._place(folder)}/{os.fsdecode(place)}"
        self.step(event, place)

    def _synced(self, fd: Any) -> None:  # noqa: ANN401 - as os.fsync
        self.step("fsync", fd)
        self._sync(fd)

    def _shortened(self, fd: int, length: int) -> None:
        self.step("truncate", fd)
        self._cut(fd, length)

    def _written(self, file: int, data: bytes) -> int:
        self.step("write", file, bytes(data)[: len(data) // 2])
        return self._write(file, data)

    def _opened(self, file: Any, mode: str = "r", buffering: int = -1, *more: Any, **named: Any) -> Any:  # noqa: ANN401 - as open
        if not set(mode) & set("wax+") or not self._concerns(file):
            return self._open(file, mode, buffering, *more, **named)
        own = {key: named.pop(key) for key in ("closefd", "opener") if key in named}
        raw = _Raw(file, mode.replace("b", "").replace("t", ""), **own)
        raw.hook = self
        if buffering == 0:
            return raw
        buffered = io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)
        return buffered if "b" in mode else io.TextIOWrapper(buffered, *more, **named)


class _Raw(io.FileIO):
    """A file whose writes are counted."""

    hook: Hook

    def write(self, data: Any) -> int:  # noqa: ANN401 - any buffer
        """As ``io.FileIO`` does."""
        some = memoryview(data).cast("B")
        self.hook.step("write", self.fileno(), bytes(some[: len(some) // 2]))
        return super().write(some) or 0


def held(folder: Path, blobs: Path, known: dict[tuple[int, ...], str] | None = None) -> Held:
    """What lies in a folder. ``known``: digests of files that have not been changed since, which is added to."""
    known, found = {} if known is None else known, Held()
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(place) / name
            seen = path.lstat()
            key = seen.st_ino, seen.st_mtime_ns, seen.st_ctime_ns, seen.st_size
            if path.is_symlink():
                entry = LINK, str(path.readlink())
            elif path.is_dir():
                entry = FOLDER, ""
            else:
                known[key] = known.get(key) or kept(path.read_bytes(), blobs)
                entry = FILE, known[key]
            found[str(path.relative_to(folder))] = entry
    return found


def kept(data: bytes, blobs: Path) -> str:
    """Put contents into ``blobs``; their digest."""
    digest = sha256(data).hexdigest()
    if not (blobs / digest).exists():
        (blobs / digest).write_bytes(data)
    return digest


def laid(found: Held, folder: Path, blobs: Path) -> None:
    """Empty a folder, and put there what was found."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for name in sorted(found):
        kind, what = found[name]
        if kind == FOLDER:
            (folder / name).mkdir()
        elif kind == LINK:
            (folder / name).symlink_to(what)
        else:
            shutil.copyfile(blobs / what, folder / name)


def alike(found: Held, *, inside: bool = True) -> str:
    """A digest that two runs have in common that left the same: random names and numbers of processes aside.

    Without ``inside``, what is in a file or a folder that is only begun is left out, too: nobody reads that.
    """
    rows = {RANDOM.sub("", name): (kind, "" if name.endswith(LOCK) else what) for name, (kind, what) in found.items()}
    if not inside:
        cut = ((BEGUN.sub(r"\1", name), (kind, what)) for name, (kind, what) in rows.items())
        rows = {name: ("", "") if BEGUN.fullmatch(name) else what for name, what in cut}
    return sha256(json.dumps(sorted(rows.items())).encode()).hexdigest()
