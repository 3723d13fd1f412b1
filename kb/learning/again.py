"""Which keypoints of one picture come again in others of the same view.

* ``keypoints_again``: how often each does, and what it is on average
* ``same``: pairs of two pictures' keypoints, each with the most alike of those that may be it
"""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
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
    def descriptors(self) -> NDArray[np.uint8]:
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
    """Indices of the keypoints of ``one`` that ``other`` has as well, and of which they are: the most alike of those that may be."""
    from scipy.spatial import cKDTree

    nothing = np.zeros(0, np.intp)
    if not len(one.uv) or not len(other.uv):
        return nothing, nothing
    mine, its = flat(cKDTree(other.uv).query_ball_point(one.uv, NEAR + 0.08 * one.scale, return_sorted=True))
    turned = np.abs((other.angle[its] - one.angle[mine] + np.pi) % (2 * np.pi) - np.pi)
    right = (np.abs(np.log(other.scale[its] / one.scale[mine])) < SIMILAR) & (turned < TURNED)
    mine, its = mine[right], its[right]
    apart = differences(one.descriptors[mine], other.descriptors[its])
    alike = apart < ALIKE[one.descriptors.shape[1]]
    mine, its, apart = mine[alike], its[alike], apart[alike]
    order = np.lexsort((its, apart, mine))
    firsts = np.unique(mine[order], return_index=True)[1]
    return mine[order][firsts], its[order][firsts]


def flat(found: Sequence[Sequence[int]]) -> tuple[Indices, Indices]:
    """Lists of indices as pairs: the list's number, and the index."""
    return np.repeat(np.arange(len(found)), [len(some) for some in found]), np.fromiter(
        chain.from_iterable(found), np.intp
    )


def differences(some: NDArray[np.uint8], others: NDArray[np.uint8]) -> Floats:
    """(N,) distances of descriptors (N, D) to their partners: Euclid's of SIFT's, Hamming's of ORB's (32 bytes)."""
    if some.shape[1] == 32:
        return np.asarray(np.unpackbits(some ^ others, axis=1).sum(axis=1), np.float64)
    return np.asarray(np.linalg.norm(some.astype(np.float32) - others.astype(np.float32), axis=1), np.float64)
