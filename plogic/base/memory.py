"""One limit of memory for a command and all processes that it starts.

The system holds each of them to it (``RLIMIT_DATA``). A thread looks at what they take together, while there are any,
and kills the one with most where that is too much; a child may have a limit of its own, for itself and its children.
What is read from files, as a library or a memory-mapped index, is no part of it, and what a copy shares with its maker
counts once. Where the system does not tell (no ``/proc``), nothing is watched.
"""

import os
import resource
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from geometry.room import look_before_loading
from plogic.base.errors import InputError

VARIABLE = "PLOGIC_MEMORY"
"""The environment variable with a command's limit in MB; 0: none."""
LEAST, EACH, OF_ALL = 4 << 30, 1 << 30, 0.75
"""The limit without it: so much, and so much for each processor, but not more than this share of what there is.

``plogic perceive examples/first_gamma.json --kb kb/first`` takes 0.26 GB.
"""
CGROUP = Path("/sys/fs/cgroup/memory.max")
LOOK = 0.1
"""Seconds between two looks. ``b"x" * (2 << 30)`` took six on the machine that this was written on: 35 MB a look."""
PROC = Path("/proc")
_PAGE = resource.getpagesize()


def whole() -> int:
    """Bytes of memory that the machine has, or the container."""
    there = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    with suppress(OSError, ValueError):  # no container, or one without a limit
        there = min(there, int(CGROUP.read_text(encoding="ascii")))
    return there


def limit(environment: Mapping[str, str]) -> int:
    """Bytes that a command and its children may take together; 0: any number. Raises InputError."""
    said = environment.get(VARIABLE, "")
    if not said:
        return min(LEAST + EACH * (os.cpu_count() or 1), int(OF_ALL * whole()))
    if not (said.isascii() and said.isdecimal() and len(said) <= 9):
        raise InputError(f"{VARIABLE}={said[:40]!r} should be a number of MB, as 8192, or 0 for no limit")
    return int(said) << 20


def hold(most: int) -> None:
    """Keep this process, and with those that it starts, to so many bytes, or to fewer where it is kept to fewer."""
    for each in (resource.RLIMIT_AS, resource.RLIMIT_DATA):
        soft = resource.getrlimit(each)[0]
        most = most if soft == resource.RLIM_INFINITY else min(soft, most or soft)
    keep_to(most)
    _WATCH.most = most
    look_before_loading()


def held() -> int:
    """Bytes that this process is held to with those that it starts; 0: any number."""
    return _WATCH.most


def keep_to(memory: int) -> None:
    """Limit what this process alone takes of memory; 0: as it is. It writes no core."""
    if memory:
        soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
        most = min(at for at in (memory, soft, hard) if at != resource.RLIM_INFINITY)
        with suppress(ValueError, OSError):  # a system that limits address space alone
            resource.setrlimit(resource.RLIMIT_DATA, (most, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


class Watched:
    """A child whose memory is watched until ``end``.

    ``kill`` ends it; ``over``: the bytes that were too few, once it was killed for that.
    """

    def __init__(self, pid: int, most: int, kill: Callable[[], None]) -> None:
        self.pid, self.most, self.kill, self.over = pid, most, kill, 0
        _WATCH.add(self)

    def end(self) -> None:
        """It is about to be waited for: its number may be another's soon."""
        _WATCH.remove(self)

    def look(self) -> None:
        """Kill it where it and its children take more than it may."""
        if self.most and taken(self.pid, self.most) > self.most:
            self.stop(self.most)

    def stop(self, most: int) -> None:
        """Kill it."""
        self.over = most
        self.kill()


class _Watch:
    """The children of this process, and the thread that looks at them as long as there are any with a limit."""

    def __init__(self) -> None:
        self.most = 0
        self._lock, self._children = threading.Lock(), list[Watched]()
        self._some = threading.Event()
        self._thread: threading.Thread | None = None

    def add(self, child: Watched) -> None:
        if not (self.most or child.most) or not PROC.is_dir():
            return
        with self._lock:
            self._children.append(child)
            self._some.set()
            if self._thread is None:
                self._thread = threading.Thread(target=self._look, daemon=True)
                self._thread.start()

    def remove(self, child: Watched) -> None:
        with self._lock:
            if child in self._children:
                self._children.remove(child)
            if not self._children:
                self._some.clear()

    def _look(self) -> None:
        pause = threading.Event()
        while self._some.wait():
            with self._lock:
                for child in self._children:
                    child.look()
                if self._children and self.most and taken(os.getpid(), self.most) > self.most:
                    max(self._children, key=lambda child: taken(child.pid, 0)).stop(self.most)
            pause.wait(LOOK)


_WATCH = _Watch()


def _afresh() -> None:
    """In a copy of this process, which has children of its own."""
    global _WATCH  # noqa: PLW0603 - one a process
    _WATCH = _Watch()


os.register_at_fork(after_in_child=_afresh)


def taken(pid: int, most: int) -> int:
    """Bytes of memory of a process and all below it, to be compared with ``most``: or what is more, where less."""
    family = list(_family(pid))
    bound = sum(map(_resident, family))
    return bound if bound <= most else sum(map(_own, family))


def _family(pid: int) -> Iterator[int]:
    """A process and all that it and they started."""
    todo = [pid]
    while todo:
        yield (at := todo.pop())
        with suppress(OSError):
            for task in (PROC / str(at) / "task").iterdir():
                todo += map(int, (task / "children").read_bytes().split())


def _resident(pid: int) -> int:
    with suppress(OSError):
        return int((PROC / str(pid) / "statm").read_bytes().split()[1]) * _PAGE
    return 0


def _own(pid: int) -> int:
    """Without what comes from files, and a share of what it shares with others."""
    with suppress(OSError, KeyError):
        rows = (PROC / str(pid) / "smaps_rollup").read_text(encoding="ascii").splitlines()[1:]
        sizes = {row.split(":")[0]: int(row.split()[1]) << 10 for row in rows}
        return sizes["Pss_Anon"] + sizes["Pss_Shmem"]
    return _resident(pid)
