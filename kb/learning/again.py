"""Which keypoints, and which sides of edges, of one picture come again in others of the same view.

Where along an edge a side is reported is arbitrary; so it is the same if it lies on the same line.

* ``keypoints_again``: how often each keypoint does, and what it is on average
* ``same``: pairs of two pictures' keypoints, each with the most alike of those that may be it
* ``sides_again``: how often each side does
"""

from collections.abc import Callable, Sequence
from itertools import chain
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geometry.arrays import Bytes, Floats, Mask
from kb.clouds.words import COLOURS, POINT, SIDE

Indices = NDArray[np.intp]


NEAR, SIMILAR, TURNED = 3.0, 0.3, 0.35
"""The same keypoint: within so many pixels (plus 8 % of its size), a logarithm of the ratio of sizes, radians."""
ALIKE = {128: 280.0, 138: 290.0, 32: 60.0}
"""... and with descriptors no farther apart, by their bytes: Euclid's distance of SIFT's, without and with colours,
Hamming's of ORB's."""


class Seen(Protocol):
    """Keypoints of one picture, as ``sensing.detectors.keypoints`` gives them."""

    @property
    def uv(self) -> Floats:
        """(N, 2) pixels."""

    @property
    def angle(self) -> Floats:
        """(N,) radians."""

    @property
    def scale(self) -> Floats:
        """(N,) pixels."""

    @property
    def descriptors(self) -> Bytes:
        """(N, D) bytes."""


def keypoints_again(first: Seen, others: Sequence[Seen]) -> tuple[Floats, Floats, NDArray[np.float32]]:
    """Share of the others in which each keypoint comes again, (N,); its mean place (N, 2) and descriptor (N, D)."""
    hits = np.zeros(len(first.uv))
    uv, descriptor = first.uv.copy(), first.descriptors.astype(np.float32)
    for other in others:
        mine, its = same(first, other)
        hits[mine] += 1.0
        uv[mine] += other.uv[its]
        descriptor[mine] += other.descriptors[its]
    return (
        hits / max(len(others), 1),
        uv / (1.0 + hits)[:, None],
        (descriptor / (1.0 + hits)[:, None]).astype(np.float32),
    )


def same(one: Seen, other: Seen) -> tuple[Indices, Indices]:
    """Indices of the keypoints of ``one`` that ``other`` has as well, and of which they are.

    The most alike of those that may be.
    """
    nothing = np.zeros(0, np.intp)
    if not len(one.uv) or not len(other.uv):
        return nothing, nothing
    mine, its = _near(one, other.uv, other.angle, other.scale)
    apart = differences(one.descriptors[mine], other.descriptors[its])
    alike = apart < ALIKE[one.descriptors.shape[1]]
    mine, its, apart = mine[alike], its[alike], apart[alike]
    order = np.lexsort((its, apart, mine))
    firsts = np.unique(mine[order], return_index=True)[1]
    return mine[order][firsts], its[order][firsts]


def _near(one: Seen, uv: Floats, angle: Floats, scale: Floats) -> tuple[Indices, Indices]:
    """Pairs that are the same as far as place, size and direction tell: of ``one``, and of (N,) others."""
    mine, its = flat(cKDTree(uv).query_ball_point(one.uv, reach_of(one), return_sorted=True))
    turned = np.abs((angle[its] - one.angle[mine] + np.pi) % (2 * np.pi) - np.pi)
    right = (np.abs(np.log(scale[its] / one.scale[mine])) < SIMILAR) & (turned < TURNED)
    return mine[right], its[right]


Like = Callable[[Floats, Floats, Floats], Mask]
"""(N,) which of N points may be the same, by places (N, 2), angles and sizes (N,)."""


def may_be(first: Seen) -> Like:
    """Whether some keypoint of the first picture may be each of those at places (N, 2), of angles and sizes (N,)."""

    def like(uv: Floats, angle: Floats, scale: Floats) -> Mask:
        found = np.zeros(len(uv), bool)
        if len(uv) and len(first.uv):
            found[_near(first, uv, angle, scale)[1]] = True
        return found

    return like


def around(uv: Floats, reach: Floats, shape: tuple[int, ...]) -> Mask:
    """(h, w) of a picture of that shape: all pixels of what is within ``reach`` (N,) pixels of places (N, 2), and more.

    Squares, for the sake of speed.
    """
    mask = np.zeros(shape[:2], np.uint8)
    half = np.ceil(reach).astype(int) + 1  # either place is half a pixel off its pixel
    column, row = (np.clip(np.rint(uv[:, i]).astype(int), 0, shape[1 - i] - 1) for i in (0, 1))
    for one in np.unique(half).tolist():
        dots = np.zeros(shape[:2], np.uint8)
        dots[row[half == one], column[half == one]] = 1
        mask |= np.asarray(cv2.dilate(dots, np.ones((2 * one + 1, 2 * one + 1), np.uint8)), np.uint8)
    return mask > 0


def reach_of(seen: Seen) -> Floats:
    """(N,) pixels within which each keypoint may come again."""
    return np.asarray(NEAR + 0.08 * seen.scale)


def flat(found: Sequence[Sequence[int]]) -> tuple[Indices, Indices]:
    """Lists of indices as pairs: the list's number, and the index."""
    return np.repeat(np.arange(len(found)), [len(some) for some in found]), np.fromiter(
        chain.from_iterable(found), np.intp
    )


def differences(some: Bytes, others: Bytes) -> Floats:
    """(N,) distances of descriptors (N, D) to their partners: Euclid's of SIFT's, Hamming's of ORB's (32 bytes)."""
    if some.shape[1] == 32:
        return np.asarray(np.unpackbits(some ^ others, axis=1).sum(axis=1), np.float64)
    return np.asarray(np.linalg.norm(some.astype(np.float32) - others.astype(np.float32), axis=1), np.float64)


Look = Callable[[Bytes, int, Mask], "SeenSides"]
"""Of a picture, where a mask (h, w) holds; the number is how many pixels lie between points along an edge."""


ACROSS, ALONG, TINTED = 2.5, 4.5, 40.0
"""The same side: so near across its edge and along it (pixels), turned by less (radians), its colours less apart
(bytes)."""
SIDES_NEAR = float(np.hypot(ACROSS, ALONG))
"""Pixels within which a side may come again."""
INSIDE = (1.5, 3.0, 5.0)
"""Pixels from the edge at which the object must be, on the side that is its (the first two), and at which the plane
that the edge is in is seen."""
STRETCH, WIDE = 0.045, 0.012
"""Of the object's diameter: what is one stretch along an edge, and across it."""
LOOKS, VARIED = slice(POINT, POINT + SIDE), POINT + SIDE
"""Where a side's looks are in a descriptor, and, in that of an appearance, how much its brightness against what is
beyond varied (standard deviation): little within the object, much at its outline. All else in it is 0."""
BYTES = 138
"""Of such a descriptor: as long as a keypoint's with colours."""


class SeenSides(Protocol):
    """Sides of one picture, as ``sensing.detectors.keypoint_detector`` gives them."""

    @property
    def uv(self) -> Floats:
        """(N, 2) pixels."""

    @property
    def angle(self) -> Floats:
        """(N,) radians, towards the side."""

    @property
    def looks(self) -> Bytes:
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
    if not len(which) or not len(other.uv):
        return np.zeros(0, np.intp)
    pairs = cKDTree(one.uv[which]).sparse_distance_matrix(cKDTree(other.uv), SIDES_NEAR, output_type="ndarray")
    mine, its = which[pairs["i"]], pairs["j"]
    apart, angle = other.uv[its] - one.uv[mine], one.angle[mine]
    across = apart[:, 0] * np.cos(angle) + apart[:, 1] * np.sin(angle)
    along = apart[:, 1] * np.cos(angle) - apart[:, 0] * np.sin(angle)
    turned = np.abs((other.angle[its] - angle + np.pi) % (2.0 * np.pi) - np.pi)
    tinted = np.linalg.norm(other.looks[its, :COLOURS].astype(np.float32) - one.looks[mine, :COLOURS], axis=1)
    same = (np.abs(across) < ACROSS) & (np.abs(along) < ALONG) & (turned < TURNED) & (tinted < TINTED)
    return np.unique(mine[same])


def descriptors(looks: Bytes) -> NDArray[np.float32]:
    """(N, 138) of sides' looks (N, 5)."""
    result = np.zeros((len(looks), BYTES), np.float32)
    result[:, LOOKS] = looks
    return result
