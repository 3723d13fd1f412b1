"""A process that stays: questions go to it one after another, each with its own limit of time.

What runs out of time or is interrupted ends with its process; the next question starts another, and ``restarts`` counts
them.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import weakref
from dataclasses import dataclass
from time import monotonic
from typing import TYPE_CHECKING, Any

from plogic.base.errors import LimitError
from plogic.logic.served.engine import environment, read_reply

if TYPE_CHECKING:
    from plogic.logic.served.engine import Limits

LARGEST_READ = 1 << 20
"""Bytes that are read at a time."""


@dataclass(frozen=True)
class _Running:
    """A child with the folder that it may write in."""

    child: subprocess.Popen[bytes]
    scratch: tempfile.TemporaryDirectory[str]

    def end(self) -> None:
        """Kill it and the compiler that it may have started; remove what it wrote."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.child.pid, signal.SIGKILL)
        self.child.wait()
        for pipe in (self.child.stdin, self.child.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):  # what was never read
                    pipe.close()
        self.scratch.cleanup()


class Process:
    """Starts at the first question; ``close`` ends it, as does the end of the program."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.started = 0
        self._end: weakref.finalize[..., Any] | None = None
        self._running: _Running | None = None

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """The reply, which may hold an ``error``; raises LimitError where it takes too long or dies without a word."""
        running = self._alive()
        try:
            line = self._talk(running, json.dumps(request).encode() + b"\n")
            reply = read_reply(line)
        except BaseException as error:  # an interruption, too, must leave no process behind that is at work
            self.close()
            if isinstance(error, (BrokenPipeError, json.JSONDecodeError)):
                raise LimitError(
                    f"the inference stopped without an answer (memory limit {self.limits.megabytes} MB)"
                ) from None
            raise
        if reply.get("error", {}).get("kind") == "LimitError":
            self.close()
        return reply

    def close(self) -> None:
        """End the process, if there is one."""
        if self._end is not None:
            self._end()
        self._end = self._running = None

    def _alive(self) -> _Running:
        if self._running is None or self._running.child.poll() is not None:
            self.close()
            self._running = _start(self.limits)
            self._end = weakref.finalize(self, _Running.end, self._running)
            self.started += 1
        return self._running

    def _talk(self, running: _Running, request: bytes) -> bytes:
        end = monotonic() + self.limits.seconds
        stdin, stdout = running.child.stdin, running.child.stdout
        if stdin is None or stdout is None:  # pragma: no cover - both are pipes
            raise BrokenPipeError
        stdin.write(request)
        stdin.flush()
        pieces: list[bytes] = []
        while not pieces or not pieces[-1].endswith(b"\n"):
            left = end - monotonic()
            if left <= 0 or not select.select([stdout], [], [], left)[0]:
                raise LimitError(f"the inference took longer than {self.limits.seconds:g} s")
            pieces.append(os.read(stdout.fileno(), LARGEST_READ))
            if not pieces[-1]:
                break
        return b"".join(pieces)


def _start(limits: Limits) -> _Running:
    scratch = tempfile.TemporaryDirectory(prefix="plogic-")
    command = [
        sys.executable,
        "-P",
        "-W",
        "ignore",
        "-m",
        "plogic.logic.served.session_child",
        str(limits.megabytes * 2**20),
    ]
    options: dict[str, Any] = {"env": environment(scratch.name), "cwd": scratch.name, "start_new_session": True}
    pipe = subprocess.PIPE
    return _Running(subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, **options), scratch)  # noqa: S603 - ours
