"""How far a run is and how long it will take: over and over on one line of a terminal, and now and then in a file."""

import sys
from time import monotonic

EVERY = 0.2
"""Seconds between two pictures of the bar."""
SELDOM = 60.0
"""Seconds between two lines where there is no terminal."""
WIDTH = 30
"""Characters of the bar."""


class Progress:
    """Of ``left`` frames of ``total``, on standard error; what stood there before is not counted in the speed."""

    def __init__(self, total: int, left: int) -> None:
        self._total, self._left, self._done, self._bad = total, left, 0, 0
        self._start = self._told = monotonic()
        self._bar = sys.stderr.isatty()

    def step(self, *, bad: bool) -> None:
        """One frame more is done."""
        self._done += 1
        self._bad += bad
        now = monotonic()
        if now - self._told >= (EVERY if self._bar else SELDOM):
            self._told = now
            sys.stderr.write(f"\r{self._drawn()}{self.text(now)}\033[K" if self._bar else self.text(now) + "\n")
            sys.stderr.flush()

    def say(self, line: str) -> None:
        """A line that stays, above the bar."""
        self.end()
        sys.stderr.write(line + "\n")

    def end(self) -> None:
        """Take the bar away."""
        if self._bar:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()

    def text(self, now: float) -> str:
        """``120 of 1000 frames, 1 bad, about 2 min left``."""
        seconds = (now - self._start) / self._done * (self._left - self._done)
        bad = f", {self._bad} bad" if self._bad else ""
        return f"{self._total - self._left + self._done} of {self._total} frames{bad}, about {duration(seconds)} left"

    def _drawn(self) -> str:
        full = WIDTH * (self._total - self._left + self._done) // self._total
        return f"[{'#' * full}{'.' * (WIDTH - full)}] "


def duration(seconds: float) -> str:
    """In words, to the unit that matters: ``40 s``, ``12 min``, ``3 h 20 min``, ``2 d 5 h``."""
    whole = round(seconds)
    if whole < 100:
        return f"{whole} s"
    minutes = round(seconds / 60)
    if minutes < 100:
        return f"{minutes} min"
    hours, rest = divmod(minutes, 60)
    return f"{hours} h {rest} min" if hours < 48 else f"{hours // 24} d {hours % 24} h"
