"""Probabilities and explanatory values as people read them, to as many places as were asked for (``--digits``)."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

NONE = "–"
PLACES = 3
"""Places of a probability where nobody asks for more or fewer; an explanatory value has one less."""
MOST = 15
"""More would show noise of the arithmetic."""
_ASKED: ContextVar[int | None] = ContextVar("places asked for", default=None)


@contextmanager
def places(number: int | None) -> Iterator[None]:
    """Show probabilities to ``number`` places within it; None for the usual ones."""
    token = _ASKED.set(number)
    try:
        yield
    finally:
        _ASKED.reset(token)


def chance(p: float | None) -> str:
    """Return a probability to three places, or as many as were asked for.

    What is exactly 0 or 1 is shown as that, and what only rounds to it says so.
    """
    if p is None:
        return NONE
    if p in (0.0, 1.0):
        return f"{p:.0f}"
    number = _ASKED.get() or PLACES
    least = 10.0**-number
    if 0 < p < least / 2:
        return f"<{least:.{number}f}"
    if 1 - least / 2 <= p < 1:
        return f">{1 - least:.{number}f}"
    return f"{float(f'{p:.12g}'):.{number}f}"  # so that noise in the last digits decides no tie


def signed(value: float | None) -> str:
    """Return an explanatory value to two places, or one less than were asked for; a dash where it is undefined."""
    return NONE if value is None else f"{value:+.{max(1, (_ASKED.get() or PLACES) - 1)}f}"


def interval(low: float, high: float) -> str:
    """Return one probability, or both bounds where they print differently."""
    return chance(low) if chance(low) == chance(high) else f"{chance(low)}..{chance(high)}"


def precise(p: float, usual: int) -> str:
    """Return a number to as many significant digits as were asked for, else ``usual`` ones."""
    return f"{p:.{_ASKED.get() or usual}g}"
