"""Which pieces of evidence leave no world: one piece alone, or two that exclude each other."""

from collections.abc import Callable, Sequence
from itertools import combinations
from time import monotonic
from typing import TypeVar

_P = TypeVar("_P")

MOST_ALONE, MOST_PAIRED = 40, 12
"""Pieces that are tried alone, and in pairs."""


def excluding(
    pieces: Sequence[_P], impossible: Callable[[Sequence[_P]], bool], said: Callable[[_P], str], seconds: float
) -> str:
    """``wet alone is impossible``, or ``wet and dry exclude each other``; '' where neither says it.

    ``impossible``: of such pieces together; after so many seconds no further try begins.
    """
    end = monotonic() + seconds
    for size, most, told in ((1, MOST_ALONE, "alone is impossible"), (2, MOST_PAIRED, "exclude each other")):
        for some in combinations(pieces, size) if len(pieces) <= most else ():
            if monotonic() > end:
                return ""
            if impossible(some):
                return f"{' and '.join(map(said, some))} {told}"
    return ""
