"""A run over frames: who works is asked for lines, and they are written as they come, or in the order of the frames."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from plogic.batch.process import Job

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from plogic.batch.frames import Frame
    from plogic.batch.pool import Answer

AHEAD = 256
"""Frames beyond the first that is still to be written that may be at work, or done and held back: what bounds memory."""


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


def run(frames: Sequence[Frame], engine: Engine, write: Callable[[Frame, str, bytes], None], *, in_order: bool) -> None:
    """Have every frame perceived, and ``write`` its status and line once."""
    given = written = 0

    def take() -> Job | None:
        nonlocal given
        if given == len(frames) or (in_order and given - written >= AHEAD):
            return None
        given += 1
        return Job(given - 1, frames[given - 1])

    held: dict[int, Answer] = {}
    for answer in engine.answers(take):
        held[written if not in_order else answer.number] = answer
        while written in held:
            due = held.pop(written)
            write(frames[due.number], due.status, due.line)
            written += 1
