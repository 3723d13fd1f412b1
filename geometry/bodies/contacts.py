"""Where bodies touch, or nearly: the closest places of two posed bodies, by a client of pybullet that the caller opens.

A body is its convex parts where it can be cut into them exactly. What cannot (a scan, a surface that is not closed) is
its hull where it is asked what it stands on, and its own facets where it is asked what stands on it; of more than
``MOST_FACETS``, its hull there too.

* ``Shape(parts=((8, 3) m,))``: a box, its corners in the common frame
* ``Touch(gap=0.002, normal=(0, 0, 1), at=(0.1, 0, 0.4))``: it is 2 mm above, there
"""

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from geometry.arrays import Floats, Ints

MOST_FACETS = 50_000
"""Facets of a body beyond which its hull stands in for it: more do not fit what pybullet takes."""
UNITS = 100.0
"""Of pybullet, in one length that matters: the margin of a thousandth that it puts around bodies is 0.00001 of that."""


class Shape(NamedTuple):
    """``parts``: corners (V, 3) m of convex bodies that fill it; where it is ``rough``, of its hull, and ``facets``, (V, 3) m and (T, 3), if few."""

    parts: tuple[Floats, ...]
    facets: tuple[Floats, Ints] | None = None
    rough: bool = False

    @property
    def heights(self) -> tuple[float, float]:
        """Its lowest and its highest place, m along z."""
        heights = np.concatenate([part[:, 2] for part in self.parts])
        return float(heights.min()), float(heights.max())


class Touch(NamedTuple):
    """``gap`` m, negative where bodies reach into each other; ``normal`` (3,), unit, towards the upper; ``at`` (3,) m, on the lower."""

    gap: float
    normal: Floats
    at: Floats


def shape_of(parts: Iterable[Floats], vertices: Floats, triangles: Ints, *, exact: bool) -> Shape:
    """Of a body whose convex ``parts`` fill it where ``exact``; else its hull and facets."""
    if exact:
        return Shape(tuple(parts))
    return Shape(
        (hull_corners(vertices),), (vertices, triangles) if len(triangles) <= MOST_FACETS else None, rough=True
    )


def hull_corners(vertices: Floats) -> Floats:
    """Those of the vertices (V, 3) that their hull needs; all of them where they lie in a plane."""
    try:
        return np.asarray(vertices[np.sort(ConvexHull(vertices).vertices)])
    except QhullError:
        return vertices


class Bodies:
    """Shapes in a client of pybullet, each loaded when it is first asked for; ``length`` m is what gaps are to be exact against."""

    def __init__(self, bullet: Any, number: int, shapes: dict[str, Shape], length: float) -> None:  # noqa: ANN401 - pybullet is untyped
        self.bullet, self.number, self.shapes = bullet, number, shapes
        self.scale = UNITS / length
        corners = [part for shape in shapes.values() for part in shape.parts]
        self.middle = np.concatenate(corners).mean(axis=0) if corners else np.zeros(3)
        self.loaded: dict[tuple[str, int], int] = {}

    def touches(self, upper: str, lower: str, reach: float) -> Iterator[Touch]:
        """Where the two are at most ``reach`` m apart; of facets, one a facet."""
        above, below = self.shapes[upper], self.shapes[lower]
        for i, part in enumerate(above.parts):
            if below.facets is not None:
                if _near(part, below.facets[0], reach):
                    yield from self._between(self._convex(upper, i, part), self._facets(lower, below.facets), reach)
                continue
            for j, other in enumerate(below.parts):
                if _near(part, other, reach):
                    yield from self._between(self._convex(upper, i, part), self._convex(lower, j, other), reach)

    def _between(self, one: int, other: int, reach: float) -> Iterator[Touch]:
        for row in self.bullet.getClosestPoints(one, other, reach * self.scale, physicsClientId=self.number):
            yield Touch(float(row[8]) / self.scale, np.array(row[7]), np.array(row[6]) / self.scale + self.middle)

    def _convex(self, name: str, i: int, corners: Floats) -> int:
        return self._load((name, i), corners, {})

    def _facets(self, name: str, facets: tuple[Floats, Ints]) -> int:
        flags = {"indices": facets[1].ravel().tolist(), "flags": self.bullet.GEOM_FORCE_CONCAVE_TRIMESH}
        return self._load((name, -1), facets[0], flags)

    def _load(self, key: tuple[str, int], corners: Floats, more: dict[str, Any]) -> int:
        if key not in self.loaded:
            placed = ((corners - self.middle) * self.scale).tolist()
            shape = self.bullet.createCollisionShape(
                self.bullet.GEOM_MESH, vertices=placed, physicsClientId=self.number, **more
            )
            self.loaded[key] = int(self.bullet.createMultiBody(0, shape, physicsClientId=self.number))
        return self.loaded[key]


def _near(one: Floats, other: Floats, reach: float) -> bool:
    """Whether the boxes around both, along the axes, are at most ``reach`` apart along each."""
    apart = np.maximum(one.min(axis=0) - other.max(axis=0), other.min(axis=0) - one.max(axis=0))
    return bool((apart <= reach).all())
