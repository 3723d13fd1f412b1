"""A process that stays: questions go to it one after another, each with its own limit of time.

What runs out of time or is interrupted ends with its process; the next question starts another, and ``restarts`` counts
them.
"""

from __future__ import annotations

import json
from time import monotonic
from typing import TYPE_CHECKING, Any

from plogic.base.children import Child, heard, python
from plogic.base.errors import LimitError
from plogic.logic.served.engine import read_reply

if TYPE_CHECKING:
    from plogic.logic.served.engine import Limits


class Process:
    """Starts at the first question; ``close`` ends it, as does the end of the program."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.started = 0
        self._running: Child | None = None

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
        if self._running is not None:
            self._running.end()
        self._running = None

    def _alive(self) -> Child:
        if self._running is None or not self._running.alive():
            self.close()
            self._running = Child(python("plogic.logic.served.session_child"), memory=self.limits.megabytes * 2**20)
            self.started += 1
        return self._running

    def _talk(self, running: Child, request: bytes) -> bytes:
        end = monotonic() + self.limits.seconds
        running.tell(request)
        pieces: list[bytes] = []
        while not pieces or not pieces[-1].endswith(b"\n"):
            if not heard([running], max(0.0, end - monotonic())):
                raise LimitError(f"the inference took longer than {self.limits.seconds:g} s")
            pieces.append(running.read())
            if not pieces[-1]:
                break
        return b"".join(pieces)
