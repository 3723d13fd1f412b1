"""How far something long has come, on standard error: a line written over on a terminal, else a line now and then.

* ``Progress()``: ``progress.at("cup: 20 of 120 views")``, and ``progress.end()`` where it is done
* ``with Work(500.0, say) as work``: one bar over all of it, told by the clock; ``work.at("cup: 20 of 120 views")`` and
  ``work.step(20.0)``
* ``with beating(lambda: "search")``: what nothing is counted of
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Event, RLock, Thread
from time import monotonic
from typing import Self

from plogic.base.alarm import TICK, alarmed
from plogic.face.shown.printed import over, say

SELDOM = 10.0
"""Seconds between two lines where there is no terminal; what is done sooner tells nothing."""


Say = Callable[[str], None]


class Progress:
    """Where one thing stands; ``at`` may be called as often as one likes."""

    def __init__(self) -> None:
        """The clock runs from now on."""
        self.terminal = sys.stderr.isatty()
        self._told = monotonic()
        self._held = False

    def at(self, text: str) -> None:
        """Tell it, on a terminal at once, else if the last line is long ago."""
        if self._held:
            return
        if self.terminal:
            over(text)
        elif monotonic() - self._told >= SELDOM:
            self._told = monotonic()
            say(text)

    def end(self) -> None:
        """Take the line away; lines without a terminal stay."""
        if self.terminal:
            over("")

    def above(self, say: Say) -> Say:
        """What writes lines that stay above it, made of what writes lines: no alarm puts it back between the two."""

        def told(line: str) -> None:
            self._held = True
            try:
                self.end()
                say(line)
            finally:
                self._held = False

        return told


LEAST = 0.5
"""Seconds: what is told as 0 s left, and still goes on, takes longer than expected."""


class Work:
    """Long work of ``total`` units, whatever a unit is: what it is at, how much is done, and how long it will take.

    A thread tells it, so that no stage is silent however long it takes.
    """

    def __init__(self, total: float, say: Callable[[str], None]) -> None:
        """The clock runs from now on; ``say`` takes lines that stay."""
        self._total, self._say, self._done, self._text = total, say, 0.0, ""
        self._progress, self._start = Progress(), monotonic()
        self._stepped = self._start
        self._lock, self._over = RLock(), Event()
        self._teller = Thread(target=self._tell, daemon=True)

    def __enter__(self) -> Self:
        """Begin to tell."""
        self._teller.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Take the bar away."""
        self._over.set()
        self._teller.join()
        self._progress.end()

    def at(self, text: str) -> None:
        """What is being done now."""
        with self._lock:
            self._text = text

    def step(self, units: float) -> None:
        """So many units more are done."""
        with self._lock:
            self._done = min(self._done + units, self._total)
            self._stepped = monotonic()

    def skip(self, units: float) -> None:
        """So many need not be done, which says nothing about the speed."""
        with self._lock:
            self._total = max(self._total - units, self._done, 1.0)

    def say(self, line: str) -> None:
        """A line that stays, above the bar."""
        with self._lock:
            self._progress.end()
            self._say(line)

    def text(self, now: float) -> str:
        """``cup: 20 of 120 views; 12 % of all, about 3 min left``; of what comes after all that is counted, that."""
        if self._done >= self._total:
            return f"{self._text}; the last phase, whose time is not known"
        share = int(100.0 * self._done / self._total)
        if not self._done:
            return f"{self._text}; {share} % of all"
        left = (self._stepped - self._start) / self._done * (self._total - self._done) - (now - self._stepped)
        told = f"about {duration(left)} left" if left >= LEAST else "longer than expected"
        return f"{self._text}; {share} % of all, {told}"

    def _tell(self) -> None:
        while not self._over.wait(TICK):
            with self._lock:
                text = self.text(monotonic())
                self._progress.at(f"{bar(self._done, self._total)} {text}" if self._progress.terminal else text)


@contextmanager
def beating(what: Callable[[], str]) -> Iterator[Callable[[Say], Say]]:
    """While the block runs, tell ``what`` it is at, and for how long it has run: ``search; 20 s so far``.

    Gives what makes of a function that writes lines one that writes them above that. What is done within ten seconds
    tells nothing.
    """
    progress, start, told = Progress(), monotonic(), False

    def tell() -> None:
        nonlocal told
        told = True
        with suppress(RuntimeError):  # the line before is being written
            progress.at(so_far(what(), monotonic() - start))

    try:
        with alarmed(tell, SELDOM, TICK):
            yield progress.above
    finally:
        if told:
            progress.end()


def so_far(what: str, seconds: float) -> str:
    """``search, 3 of 8 types; 20 s so far``."""
    return f"{what}; {duration(seconds)} so far"


WIDTH = 30
"""Characters of a bar."""


def bar(done: float, total: float) -> str:
    """``[######........................]``."""
    full = int(WIDTH * done // total)
    return f"[{'#' * full}{'.' * (WIDTH - full)}]"


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
