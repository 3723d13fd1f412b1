"""Many mistakes as one text: as many of them as somebody reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

MOST = 100
"""Mistakes that are told one by one."""


def told(mistakes: Sequence[object], between: str = "\n") -> str:
    """The first ``MOST`` of them, ``between`` one and the next, and how many more there are.

    >>> told(["a is wrong", "b is missing"], "; ")
    'a is wrong; b is missing'
    """
    more = len(mistakes) - MOST
    return between.join([*map(str, mistakes[:MOST]), *([f"and {more} more"] if more > 0 else [])])
