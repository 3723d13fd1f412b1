"""The time that an answer may take, and the moment at which a search stops: both are asked between steps.

Without a limit no clock is read, so that the answer depends on nothing but the question.
``Stopwatch`` has the times of the stages of one run, in seconds of wall clock; they never enter a result.
"""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import monotonic, perf_counter


class OutOfTimeError(Exception):
    """The time is over; never leaves who set it: what was found by then is an interval, or the best answer so far."""


def unhurried() -> None:
    """The check of who has time for ever."""


def unasked(_: str) -> None:
    """What is told of the way of a search that nobody asks."""


class Clock:
    """Counts from its making; ``seconds`` None is for ever."""

    def __init__(self, seconds: float | None) -> None:
        self.end = None if seconds is None else time.monotonic() + seconds

    def left(self) -> float:
        """Seconds; inf without a limit."""
        return math.inf if self.end is None else self.end - time.monotonic()

    def check(self) -> None:
        """Raises OutOfTimeError when the time is over."""
        if self.end is not None and time.monotonic() >= self.end:
            raise OutOfTimeError

    def some(self, share: float) -> "Clock":
        """A clock for a job that is to take at most this share of what is left."""
        return self if self.end is None else Clock(share * self.left())

    def share(self, count: int) -> "Clock":
        """A clock for the first of ``count`` jobs that are to share what is left."""
        return Clock(None if self.end is None else self.left() / count)


class Deadline:
    """``end``: a moment of ``time.monotonic``, or None for never; ``passed``: whether somebody has asked since."""

    def __init__(self, end: float | None) -> None:
        self.end, self.passed = end, False

    def check(self) -> None:
        """Raises OutOfTimeError when the time is over."""
        self.passed = self.passed or (self.end is not None and monotonic() >= self.end)
        if self.passed:
            raise OutOfTimeError


@dataclass
class Stopwatch:
    """Seconds by stage, in the order in which the stages first ran; a stage that runs again adds up.

    ``now``: the stage that runs, '' between two; ``part``: how far it has come, where that is counted; ``inner``: of
    what is one of several, its own stages.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    now: str = ""
    part: str = ""
    inner: "Stopwatch | None" = None

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time of the block to a stage."""
        start, before = perf_counter(), (self.now, self.part)
        self.now, self.part = name, ""
        try:
            yield
        finally:
            self.now, self.part = before
            self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - start

    def at(self, part: str) -> None:
        """How far the stage that runs has come."""
        self.part = part

    @property
    def here(self) -> str:
        """The stage that runs and how far it has come: ``search, 3 of 8 types``, ``view 2 of 5, search``."""
        return ", ".join(filter(None, (self.now, self.part, self.inner.here if self.inner is not None else "")))

    @property
    def total(self) -> float:
        """Seconds of all stages."""
        return sum(self.seconds.values())
