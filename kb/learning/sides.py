"""What is seen of an object's edges from one direction: their sides that come again in worse pictures, carried back to its surface.

Where along an edge a side is reported is arbitrary; so it is the same if it lies on the same line, and it belongs to
all of a stretch of it.

* ``sides_again``: which come again; ``observations`` carries them back, as ``Observations`` of size 0: a side has a
  place, a direction and looks
* ``side_places`` puts those of one stretch of an edge together
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from kb.clouds.words import COLOURS, POINT, SIDE

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from kb.learning.observations import Observations

    Floats = NDArray[np.float64]
    Look = Callable[[NDArray[np.uint8], int], "SeenSides"]
    """Of a picture; the number is how many pixels lie between points along an edge."""

ACROSS, ALONG, TURNED, TINTED = 2.5, 4.5, 0.35, 40.0
"""The same side: so near across its edge and along it (pixels), turned by less (radians), its colours less apart
(bytes)."""
INSIDE = (1.5, 3.0, 5.0)
"""Pixels from the edge at which the object must be, on the side that is its (the first two), and at which the plane
that the edge is in is seen."""
STRETCH, WIDE = 0.045, 0.012
"""Of the object's diameter: what is one stretch along an edge, and across it."""
PIXELS_WIDE = 1.5
"""Pixels across, where that is wider."""
SAME_WAY = 0.8
"""Least cosine between the directions of one stretch."""
LOOKS, VARIED = slice(POINT, POINT + SIDE), POINT + SIDE
"""Where a side's looks are in a descriptor, and, in that of an appearance, how much its brightness against what is
beyond varied (standard deviation): little within the object, much at its outline. All else in it is 0."""
BYTES = 138
"""Of such a descriptor: as long as a keypoint's with colours."""


class SeenSides(Protocol):
    """Sides of one picture, as ``sensing.detectors.edge_sides`` gives them."""

    @property
    def uv(self) -> Floats:
        """(N, 2) pixels."""

    @property
    def angle(self) -> Floats:
        """(N,) radians, towards the side."""

    @property
    def looks(self) -> NDArray[np.uint8]:
        """(N, 5) bytes, the last its brightness against what is beyond the edge."""


def sides_again(first: SeenSides, others: Sequence[SeenSides], which: NDArray[np.intp] | None = None) -> Floats:
    """(N,) share of the other pictures in which each side of the first comes again.

    With ``which`` (M,), 0 of all that it does not name.
    """
    hits = np.zeros(len(first.uv))
    which = np.arange(len(hits)) if which is None else which
    for other in others:
        hits[_same(first, which, other)] += 1.0
    return hits / max(len(others), 1)


def _same(one: SeenSides, which: NDArray[np.intp], other: SeenSides) -> NDArray[np.intp]:
    """Those of the sides ``which`` of ``one`` that ``other`` has as well."""
    from scipy.spatial import cKDTree

    if not len(which) or not len(other.uv):
        return np.zeros(0, np.intp)
    pairs = cKDTree(one.uv[which]).sparse_distance_matrix(
        cKDTree(other.uv), float(np.hypot(ACROSS, ALONG)), output_type="ndarray"
    )
    mine, its = which[pairs["i"]], pairs["j"]
    apart, angle = other.uv[its] - one.uv[mine], one.angle[mine]
    across = apart[:, 0] * np.cos(angle) + apart[:, 1] * np.sin(angle)
    along = apart[:, 1] * np.cos(angle) - apart[:, 0] * np.sin(angle)
    turned = np.abs((other.angle[its] - angle + np.pi) % (2.0 * np.pi) - np.pi)
    tinted = np.linalg.norm(other.looks[its, :COLOURS].astype(np.float32) - one.looks[mine, :COLOURS], axis=1)
    same = (np.abs(across) < ACROSS) & (np.abs(along) < ALONG) & (turned < TURNED) & (tinted < TINTED)
    return np.unique(mine[same])


def descriptors(looks: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(N, 138) of sides' looks (N, 5)."""
    result = np.zeros((len(looks), BYTES), np.float32)
    result[:, LOOKS] = looks
    return result


def side_places(seen: Observations, which: NDArray[np.intp], diameter: float) -> list[NDArray[np.intp]]:
    """Those of the observations ``which`` are sides in groups, each of one stretch of an edge, as far as colours go any; the surest first."""
    from scipy.spatial import cKDTree

    if not len(which):
        return []
    at, up, pixel = seen.at[which], seen.up[which], seen.pixel[which]
    tree, free, groups = cKDTree(at), np.ones(len(which), bool), []
    for i in np.lexsort((np.arange(len(which)), pixel, -seen.hit[which])):
        if not free[i]:
            continue
        near = np.array(tree.query_ball_point(at[i], STRETCH * diameter, return_sorted=True), np.intp)
        near = near[free[near]]
        across = np.abs((at[near] - at[i]) @ up[i])
        one = (across < np.maximum(WIDE * diameter, PIXELS_WIDE * pixel[near])) & (up[near] @ up[i] > SAME_WAY)
        one |= near == i
        free[near[one]] = False
        groups.append(which[near[one]])
    return groups
