"""Deadlines of the perceptual cycle without a clock: it stops at its n-th look at the time."""

from __future__ import annotations

from contextlib import contextmanager

import pytest

from plogic.base import clock as deadline

LATE = 1e9
"""A moment of a clock that only a test ends."""


class Looks:
    """A clock that stands still for so many looks, and then is past every deadline; ``count`` looks were taken."""

    def __init__(self, before):
        self.before, self.count = before, 0

    def __call__(self):
        """As ``time.monotonic``."""
        self.count += 1
        return 0.0 if self.count <= self.before else 2.0 * LATE


@contextmanager
def stopped_after(looks):
    """Within, a cycle that ends at ``LATE`` stops at the look after so many."""
    clock = Looks(looks)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(deadline, "monotonic", clock)
        yield clock
