"""How far something long has come, on standard error: a line written over on a terminal, else a line now and then.

* ``Progress()``: ``progress.at("cup: 20 of 120 views")``, and ``progress.end()`` where it is done
"""

import sys
from time import monotonic

SELDOM = 10.0
"""Seconds between two lines where there is no terminal; what is done sooner tells nothing."""


class Progress:
    """Where one thing stands; ``at`` may be called as often as one likes."""

    def __init__(self) -> None:
        """The clock runs from now on."""
        self.terminal = sys.stderr.isatty()
        self._told = monotonic()

    def at(self, text: str) -> None:
        """Tell it, on a terminal at once, else if the last line is long ago."""
        if self.terminal:
            sys.stderr.write(f"\r{text}\033[K")
            sys.stderr.flush()
        elif monotonic() - self._told >= SELDOM:
            self._told = monotonic()
            sys.stderr.write(f"{text}\n")
            sys.stderr.flush()

    def end(self) -> None:
        """Take the line away; lines without a terminal stay."""
        if self.terminal:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()
