"""Deadlines without a clock: inference stops at its n-th look at the time, and small tables go the way of wide ones."""

from __future__ import annotations

import math
from contextlib import contextmanager

import pytest

from plogic.base.clock import Clock, OutOfTimeError
from plogic.inference import marginals

LONG = 3600.0
"""Seconds: a limit that a test does not reach, so that only ``stopped`` ends what it limits."""


class _Countdown(Clock):
    """Out of time from the n-th check on; pieces draw on the same count."""

    def __init__(self, checks):
        super().__init__(None)
        self.end = math.inf
        self.checks = checks

    def check(self):
        self.checks -= 1
        if self.checks < 0:
            raise OutOfTimeError

    def share(self, count):  # noqa: ARG002 - as a clock has it
        return self

    def some(self, share):  # noqa: ARG002 - likewise
        return self


@contextmanager
def stopped(checks, width):
    """Within, beliefs that have a deadline stop at that check; beliefs without one are exact.

    Past ``width`` bits both go case by case.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(marginals, "Clock", lambda seconds: Clock(None) if seconds is None else _Countdown(checks))
        for beliefs in (marginals.beliefs, marginals.Remembered.beliefs):
            patch.setitem(beliefs.__kwdefaults__, "width", width)
        yield
