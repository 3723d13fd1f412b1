"""Child processes: all of them are started here.

A child ends when the process that started it ends, by SIGKILL too. Its memory is watched (``memory``). It can be
waited for among others, and is killed with all that it started. The folder that it writes in is removed, if need be by
the next process that makes one (``geometry.files.begun``).

* ``with Child(python("plogic.logic.served.program_child"), told=request) as child: child.rest(seconds=5.0)``
* ``heard([one, other], 1.0)``: those that say something within a second; the others may be ended
* ``Copy(work, argument)``: a copy of this process, which calls ``work``
"""

import contextlib
import ctypes
import os
import select
import signal
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from threading import Thread
from time import monotonic, sleep
from typing import Any, Self

from geometry.files.begun import scratch
from plogic.base.memory import Watched, keep_to

LARGEST_READ = 1 << 20
"""Bytes that are read at a time."""
PR_SET_PDEATHSIG = 1
"""Linux's number of the request for a signal when the parent ends."""
LONG = 1e6
"""Seconds from which on a wait has no limit: the system counts no longer ones."""
LOOK = 0.5
"""Seconds between two looks for the parent, where the system sends no such signal."""
CHILD = "PLOGIC_CHILD"
"""The variable by which a child of Python learns the number of its parent."""


def python(module: str, *arguments: str) -> list[str]:
    """Return the command that runs a module of ours; it calls ``begin`` first."""
    return [sys.executable, "-P", "-W", "ignore", "-m", module, *arguments]


class Child:
    """A command that runs in a session and a scratch folder of its own, whose standard output is read here.

    ``told``: all that it will find on standard input; left out, ``tell`` writes there. ``memory``: bytes that it
    may use, and its children with it, if the command's limit is not lower. ``folder``: where it runs, if not in its
    scratch folder; ``variables`` are added to the environment. ``files`` are written into its scratch folder before it
    starts.
    """

    def __init__(
        self,
        command: Sequence[str],
        *,
        told: bytes | None = None,
        memory: int = 0,
        folder: str | None = None,
        variables: Mapping[str, str] | None = None,
        files: Mapping[str, bytes] | None = None,
    ) -> None:
        made = contextlib.ExitStack()
        try:
            self.folder, parent = made.enter_context(scratch()), os.getpid()
            for name, data in {**(files or {}), **({} if told is None else {".told": told})}.items():
                (self.folder / name).write_bytes(data)
            environment = _environment(self.folder) | dict(variables or {}) | {CHILD: str(parent)}
            with contextlib.ExitStack() as opened:
                asked = subprocess.PIPE if told is None else opened.enter_context((self.folder / ".told").open("rb"))
                said = opened.enter_context((self.folder / ".said").open("wb"))
                self._process = subprocess.Popen(  # noqa: S603 - no shell
                    command,
                    stdin=asked,
                    stdout=subprocess.PIPE,
                    stderr=said,
                    cwd=folder or self.folder,
                    env=environment,
                    start_new_session=True,
                    preexec_fn=_bound(parent, memory),  # noqa: PLW1509 - of one thread, or without locks
                )
        except BaseException:
            made.close()
            raise
        self._watched = Watched(self._process.pid, memory, partial(_kill, self._process))
        self._end = weakref.finalize(self, _ended, self._process, made, self._watched)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    @property
    def pid(self) -> int:
        """Its number."""
        return self._process.pid

    def alive(self) -> bool:
        """Whether it has not ended."""
        return self._process.poll() is None

    def fileno(self) -> int:
        """Readable when it has said something, or has ended."""
        assert self._process.stdout is not None  # noqa: S101 - a pipe
        return self._process.stdout.fileno()

    def tell(self, data: bytes) -> None:
        """Write to its standard input. Raises BrokenPipeError where it has ended."""
        assert self._process.stdin is not None  # noqa: S101 - a pipe
        self._process.stdin.write(data)
        self._process.stdin.flush()

    def read(self) -> bytes:
        """Return some of what it has said, as soon as there is something; nothing once it has ended."""
        return os.read(self.fileno(), LARGEST_READ)

    def rest(self, seconds: float) -> tuple[bytes, bool]:
        """Return all that it says until it ends, and whether it was killed, for want of time, before it did."""
        end, pieces = monotonic() + seconds, [b""]
        while heard([self], None if seconds > LONG else max(0.0, end - monotonic())):
            pieces.append(self.read())
            if not pieces[-1]:
                return b"".join(pieces), False
        _kill(self._process)
        while piece := self.read():
            pieces.append(piece)
        return b"".join(pieces), True

    def wait(self) -> int:
        """Return its exit status, negative for a signal, once it has ended."""
        return self._process.wait()

    def last_words(self) -> str:
        """Return what it wrote to standard error."""
        return (self.folder / ".said").read_text(encoding="utf-8", errors="replace")

    def end(self) -> str:
        """Kill it, unless it has ended, and all that it started; sweep.

        Return how it ended: ``signal 9``, ``exit status 1``, ``more than 6144 MB of memory``.
        """
        self._end()
        status = self._process.returncode
        if self._watched.over:
            return f"more than {self._watched.over >> 20} MB of memory"
        return f"signal {-status}" if status < 0 else f"exit status {status}"


class Copy:
    """A copy of this process (``fork``), which knows all that it knows and calls ``work(*arguments)``.

    It shares with its maker what that uses now.
    """

    def __init__(self, work: Callable[..., object], *arguments: object) -> None:
        from multiprocessing import get_context

        copied = os.getpid(), work, arguments
        self._process = get_context("fork").Process(target=_copied, args=copied, daemon=True)
        self._process.start()
        self._watched = Watched(self.pid, 0, self._process.kill)

    @property
    def pid(self) -> int:
        """Its number."""
        return self._process.pid or 0

    def end(self) -> None:
        """Kill it, unless it has ended."""
        self._watched.end()
        self._process.kill()
        self._process.join()
        self._process.close()


def _copied(parent: int, work: Callable[..., object], arguments: tuple[Any, ...]) -> None:
    end_with(parent)
    work(*arguments)


def heard(children: Sequence[Child], seconds: float | None) -> list[Child]:
    """Return the children that have said something, or have ended, within so many seconds; None waits for ever."""
    return select.select(children, [], [], seconds)[0] if children else []


def _kill(process: subprocess.Popen[bytes]) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):  # the latter for what is dead already, on macOS
        os.killpg(process.pid, signal.SIGKILL)


def _ended(process: subprocess.Popen[bytes], made: contextlib.ExitStack, watched: Watched) -> None:
    watched.end()
    _kill(process)
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with contextlib.suppress(OSError):  # what was never read
                pipe.close()
    made.close()


def _environment(scratch: Path) -> dict[str, str]:
    """The child finds the same packages as we do, and writes its scratch files where we remove them."""
    root = str(Path(__file__).resolve().parents[2])
    path = os.pathsep.join([root, *(entry for entry in sys.path if entry)])
    own = {"PYTHONPATH": path, "TMPDIR": str(scratch), "PYTHONHASHSEED": "0", "PYTHONIOENCODING": "utf-8"}
    return {**os.environ, **own}


@contextlib.contextmanager
def ending_well() -> Iterator[None]:
    """Let SIGTERM and SIGHUP raise SystemExit within it, so that processes end and scratch files go first."""
    mine = threading.current_thread() is threading.main_thread()
    signals = [s for s in (signal.SIGTERM, signal.SIGHUP) if mine and signal.getsignal(s) is signal.SIG_DFL]
    for number in signals:
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    try:
        yield
    finally:
        for number in signals:
            signal.signal(number, signal.SIG_DFL)


def begin() -> None:
    """Do first in a module that ``Child`` runs: end with the parent, where the system does not see to that."""
    end_with(int(os.environ.pop(CHILD)))


def end_with(parent: int) -> None:
    """Let this process be killed when its parent ends, however that does.

    By the system (Linux), else by a thread that looks.
    """
    if not _asked_system():
        Thread(target=_watch, args=(parent,), daemon=True).start()
    if os.getppid() != parent:  # it ended meanwhile
        os.kill(os.getpid(), signal.SIGKILL)


def _asked_system() -> bool:
    """Whether the system will kill this process with its parent (prctl of Linux)."""
    prctl = getattr(ctypes.CDLL(None), "prctl", None)
    return prctl is not None and prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0) == 0


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        sleep(LOOK)
    os.kill(os.getpid(), signal.SIGKILL)


def _bound(parent: int, memory: int) -> Callable[[], None]:
    """What a child does before its program starts, as far as its system can: Python takes long until ``begin``."""
    prctl = getattr(ctypes.CDLL(None), "prctl", None)

    def begun() -> None:
        if prctl is not None:
            prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
            if os.getppid() != parent:
                os.kill(os.getpid(), signal.SIGKILL)
        keep_to(memory)

    return begun
