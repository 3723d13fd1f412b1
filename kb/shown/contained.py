"""Types whose cloud another contains: wherever the larger one stands, all the features of the smaller one are there too."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType

    Places = NDArray[np.float64]

CLOSE = 0.01
"""How far features may be from each other's places, as a share of the smaller cloud's diameter."""
MOST_TRIES = 5_000
"""Placements of the smaller cloud in the larger one that are tried; of more, nothing is said."""


def contained_in(small: ObjectType, large: ObjectType) -> bool:
    """Whether a rigid motion takes every feature of ``small`` to one of ``large`` of the same type."""
    if small is large or not small.features:
        return False
    mine, theirs = Counter(f.type for f in small.features), Counter(f.type for f in large.features)
    if any(theirs[name] < number for name, number in mine.items()):
        return False
    at, there = (np.array([f.at for f in kind.features]) for kind in (small, large))
    same = np.array([[f.type == g.type for g in large.features] for f in small.features])
    near = CLOSE * float(np.linalg.norm(np.ptp(at, axis=0))) + 1e-9
    for held, found in _placements(at, there, same, near):
        moved = _moved(at, at[held], there[found])
        distance = np.linalg.norm(moved[:, None] - there[None], axis=2)
        if ((distance <= 2 * near) & same).any(axis=1).all():
            return True
    return False


def _placements(
    at: Places, there: Places, same: NDArray[np.bool_], near: float
) -> Iterator[tuple[list[int], list[int]]]:
    """Up to three features of the one, rare and far apart, with where they may be in the other: types and distances agree."""
    held = _wide(at, same.sum(axis=1))
    ways: list[list[int]] = [[]]
    for index, feature in enumerate(held):
        longer = []
        for way in ways:
            fits = same[feature].copy()
            for other, place in zip(held[:index], way, strict=True):
                gap = np.linalg.norm(at[feature] - at[other])
                fits &= np.abs(np.linalg.norm(there - there[place], axis=1) - gap) <= 2 * near
            longer += [[*way, int(place)] for place in np.flatnonzero(fits) if place not in way]
        ways = longer[: 4 * MOST_TRIES]
    yield from ((held, way) for way in ways[:MOST_TRIES])


def _wide(at: Places, rare: NDArray[np.intp]) -> list[int]:
    """The rarest feature, the farthest from it, and the farthest from the line through both; fewer where no more are apart."""
    held = [int(np.argmin(rare))]
    distance = np.linalg.norm(at - at[held[0]], axis=1)
    if distance.max() <= 0:
        return held
    held.append(int(distance.argmax()))
    line = (at[held[1]] - at[held[0]]) / distance.max()
    off = np.linalg.norm(np.cross(at - at[held[0]], line), axis=1)
    return [*held, int(off.argmax())] if off.max() > CLOSE * distance.max() else held


def _moved(points: Places, here: Places, there: Places) -> Places:
    """``points`` (N, 3) by the rigid motion that best takes ``here`` to ``there`` (Kabsch)."""
    a, b = here.mean(axis=0), there.mean(axis=0)
    u, _, v = np.linalg.svd((here - a).T @ (there - b))
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v)) or 1.0])
    return (points - a) @ (u @ mirror @ v) + b
