"""A run over frames: who works is asked for lines, and they are written as they come, or in the order of the frames."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from plogic.run.batch.pool import Answer
from plogic.run.batch.waiting import Waiting
from plogic.run.batch.worker_process import Job

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from plogic.run.batch.frames import Frame

AHEAD = 256
"""Frames beyond the first that is still to be written that may be at work, or done and held back: what bounds
memory."""


class Engine(Protocol):
    """Who works: the processes of this machine, or a cluster."""

    def start(self, number: int) -> None:
        """Get ready for so many frames."""

    def kb(self) -> dict[str, str]:
        """Name and digest of the KB that is used."""

    def answers(self, take: Callable[[], Job | None]) -> Iterator[Answer]:
        """The line of every frame that ``take`` gives."""

    def close(self) -> None:
        """End whatever works."""


def run(
    frames: Sequence[Frame],
    engine: Engine,
    write: Callable[[Frame, str, bytes], None],
    waiting: Waiting | None = None,
    *,
    in_order: bool,
) -> None:
    """Have every frame perceived, and ``write`` its status and line once.

    In order, those that are done too early are ``waiting`` meanwhile.

    Frames that waited already when an earlier run was killed are written and not perceived again.
    """
    waiting = waiting or Waiting()
    held = {number: Answer(number, *found) for number, found in waiting.found(frames).items()}
    known = frozenset(held)
    given = written = 0

    def take() -> Job | None:
        nonlocal given
        while given in known:
            given += 1
        if given == len(frames) or (in_order and given - written >= AHEAD):
            return None
        given += 1
        return Job(given - 1, frames[given - 1])

    def write_due() -> None:
        nonlocal written
        while held and (not in_order or written in held):
            due = held.pop(written if in_order else next(iter(held)))
            write(frames[due.number], due.status, due.line)
            written += 1
        if not held:
            waiting.clear()

    write_due()
    for answer in engine.answers(take):
        held[answer.number] = answer
        if in_order and answer.number != written:
            waiting.keep(answer.line, [other.line for other in held.values()])
        write_due()
