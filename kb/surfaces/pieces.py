"""The connected pieces of a surface: what a mesh itself tells of an object's parts (§2).

Vocabulary: ``Piece``, one of them, ``Piece(name="part_1", at=(0, 0, 0.1), share=0.7, triangles=...)``, the largest
first.
"""

import json
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kb.surfaces.closing import pieces
from kb.surfaces.nearness import spread
from kb.surfaces.surface import Surface

MOST = 32
"""Parts that one type is given at most."""
TINY = 0.01
"""A piece of less than this share of the area belongs to the piece that is nearest to it."""
SPOTS = 40_000
"""Points over the larger pieces, through which the nearest is found."""


@dataclass(frozen=True, eq=False)
class Piece:
    """``at`` (3,): the middle of its box, m; ``share`` of the whole area.

    ``triangles`` (T,): which of the surface's are its.
    """

    name: str
    at: NDArray[np.float64]
    share: float
    triangles: NDArray[np.intp]

    def __str__(self) -> str:
        name = self.name if re.fullmatch(r"part_[0-9]+", self.name) else json.dumps(self.name)
        return f"{{part: {name}, at: [{', '.join(f'{round(float(x), 6) + 0.0:g}' for x in self.at)}]}}"


def pieces_of(surface: Surface) -> tuple[Piece, ...]:
    """The pieces of a surface, whose vertices at one place are one, by size; none where it hangs together."""
    label, areas = _connected(surface), _areas(surface)
    area = np.bincount(label, weights=areas)
    order = np.lexsort((np.arange(len(area)), -area))
    large = order[:MOST][area[order[:MOST]] >= TINY * area.sum()]
    large = large if len(large) else order[:1]
    if len(large) < 2:
        return ()
    label = _joined(surface, label, large)
    return tuple(
        _piece(surface, number, np.flatnonzero(label == own), areas) for number, own in enumerate(large.tolist(), 1)
    )


def _connected(surface: Surface) -> NDArray[np.intp]:
    """(T,) the number of each triangle's piece: what shares a vertex hangs together."""
    a, b, c = surface.triangles.T
    number = pieces(len(surface.vertices), np.concatenate([a, b]), np.concatenate([b, c]))[a]
    return np.asarray(np.unique(number, return_inverse=True)[1], np.intp)


def _areas(surface: Surface) -> NDArray[np.float64]:
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0)


def _joined(surface: Surface, label: NDArray[np.intp], large: NDArray[np.intp]) -> NDArray[np.intp]:
    """The labels (T,) with every piece that is not ``large`` given to the one nearest to one of its corners."""
    from scipy.spatial import cKDTree

    small = np.flatnonzero(~np.isin(label, large))
    if not len(small):
        return label
    rest = np.flatnonzero(np.isin(label, large))
    spots, owner = spread(surface.vertices, surface.triangles[rest], SPOTS)
    far, near = cKDTree(spots).query(surface.vertices[surface.triangles[small]].reshape(-1, 3))
    own = np.repeat(label[small], 3)
    order = np.lexsort((far, own))
    some, first = np.unique(own[order], return_index=True)
    nearest = np.arange(label.max() + 1)
    nearest[some] = label[rest][owner[near[order][first]]]
    return nearest[label]


def _piece(surface: Surface, number: int, triangles: NDArray[np.intp], areas: NDArray[np.float64]) -> Piece:
    corners = surface.vertices[surface.triangles[triangles]].reshape(-1, 3)
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    return Piece(f"part_{number}", middle, float(areas[triangles].sum() / areas.sum()), triangles)
