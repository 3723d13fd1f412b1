"""The moment at which a search stops: it is asked between steps."""

from __future__ import annotations

from time import monotonic

from plogic.base.clock import OutOfTimeError


class Deadline:
    """``end``: a moment of ``time.monotonic``, or None for never; ``passed``: whether somebody has asked since."""

    def __init__(self, end: float | None) -> None:
        self.end, self.passed = end, False

    def check(self) -> None:
        """Raises OutOfTimeError when the time is over."""
        self.passed = self.passed or (self.end is not None and monotonic() >= self.end)
        if self.passed:
            raise OutOfTimeError
