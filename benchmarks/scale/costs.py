"""What so many types and frames need, by formula from what was measured of one type and one frame."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

from plogic.match.oriented.pair_index import MOST, TYPES

GB = 1e9
FREE = 0.8
"""Share of a machine's memory that types may fill."""
HOUR = 3600.0
"""Seconds."""


@dataclass(frozen=True)
class Need:
    """``index`` types an index; ``indices``; ``machines`` that hold them; ``seconds`` of a core a frame.

    ``cores`` that keep up with the frames.
    """

    terabytes: float
    index: int
    indices: int
    machines: int
    seconds: float
    cores: int


def need(
    types: int, frames: float, of_type: float, growth: tuple[float, float], memory: float, most: float = TYPES
) -> Need:
    """The need of ``frames`` an hour that are searched for so many types, ``of_type`` bytes each.

    Indices hold ``most`` types, on machines of ``memory`` GB.

    ``growth``: seconds that a frame takes in an index without types, and for each type of it. A machine holds one index
    or several.
    """
    index = max(1, min(TYPES, int(most), int(FREE * memory * GB / of_type)))
    indices = ceil(types / index)
    seconds = indices * max(0.0, growth[0]) + types * max(0.0, growth[1])
    machines = ceil(types * of_type / (FREE * memory * GB))
    return Need(types * of_type / 1e12, index, indices, machines, seconds, ceil(seconds * frames / HOUR))


def types_under_limit(entries: float, most: int = MOST) -> float:
    """Types at which a frame begins to ask for more entries than are looked at.

    ``entries``: that it asks for, a type.
    """
    return most / entries


def looks_needed(types: int, looks: int, entries: float, most: int = MOST) -> int:
    """Appearance types at which so many types ask for no more than ``most``.

    A pair of looks is as rare as the square of their number says.
    """
    return ceil(looks * sqrt(types * entries / most))
