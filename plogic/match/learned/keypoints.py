"""Which keypoints of Γ look like which appearances of learned types, by descriptors alone, and a pair's pose.

Appearances are kept by visual word: of a keypoint only those of its nearest words are looked at, for all types at once.
The lobe of a pair gives the direction of view, the angle the roll, the size the distance.

* ``Lexicon``: the L appearances of all types; ``alike(name, data)`` says which of one type look like which keypoint
* ``Pairs``: P of them, ``datum`` (P,), ``lobe`` (P,), ``weight`` (P,)
* ``single_poses(index, pairs, data)``: their poses
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.match.gamma.data import Columns, Data, centre_of
from sensing.detectors.keypoint_detector import fairly

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.learned import LearnedCloud
    from plogic.match.learned.learned_models import LearnedIndex


FARTHEST, FARTHEST_BITS = 270.0, 7.65
"""Farthest descriptors that look alike: of SIFT, with or without colours, and of ORB's bits (58 of them)."""
WORDS = 8
"""Words of a keypoint whose appearances are looked at, the nearest."""
NTH = 8
"""Keypoints of a word that an appearance is compared with any further, the most alike."""
_BLOCK = 2048


class Alike(NamedTuple):
    """N pairs that look alike: ``datum`` (N,), ``lobe`` (N,), ``apart`` (N,) in SIFT's distance of descriptors.

    They are in the order of their appearances, of one appearance the most alike first.
    """

    datum: Indices
    lobe: Indices
    apart: Floats


def spread(descriptors: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(N, D) as vectors whose distance is Euclid's (SIFT) or the root of Hamming's (ORB)."""
    return (
        np.unpackbits(descriptors, axis=1).astype(np.float32)
        if descriptors.shape[1] == 32
        else descriptors.astype(np.float32)
    )


def farthest(vectors: NDArray[np.float32]) -> float:
    """The farthest that such vectors (N, D) may be apart and look alike."""
    return FARTHEST_BITS if vectors.shape[1] == 256 else FARTHEST


@dataclass(eq=False)
class Lexicon:
    """Appearances in the order of their words.

    Each is in one word, and so all the keypoints that it may look like are found together.

    Attributes:
        names: (T,) the types.
        words: (W, D) float32, the words as vectors; one word holds all where there is no vocabulary.
        starts: (W + 1,) where each word's appearances begin among the L.
        descriptors: (L, D) uint8.
        owner: (L,) index of the type, in 16 bits, which sort fast.
        lobe: (L,) index among the type's own appearances.
    """

    names: tuple[str, ...]
    words: NDArray[np.float32]
    starts: Indices
    descriptors: NDArray[np.uint8]
    owner: NDArray[np.uint16]
    lobe: Indices

    _last: tuple[Data, dict[str, Alike]] | None = field(default=None, init=False)

    def alike(self, name: str, data: Data) -> Alike:
        """The pairs of one type that look alike.

        Those of all types and all of Γ are found at the first question about it.
        """
        found = self.ask(data)[name]
        place = np.full(len(data.whole.ids), -1, np.intp)
        place[data.rows] = np.arange(len(data.ids))
        here = place[found.datum] >= 0
        return Alike(place[found.datum[here]], found.lobe[here], found.apart[here])

    def as_right(self, name: str, data: Data, lobe: Indices, datum: Indices, apart: Floats, aside: float) -> Floats:
        """(N,) of a type's appearances, how many other keypoints of Γ look as right, as a share of ``NTH``.

        ``NTH`` is the most that are known.

        ``datum`` (N,) are those that are theirs; others are ``aside`` pixels away from them at least. ``apart`` (N,) is
        a share of ``FARTHEST``.
        """
        found, rows = self.ask(data)[name], data.rows[datum]
        first, last = np.searchsorted(found.lobe, lobe, "left"), np.searchsorted(found.lobe, lobe, "right")
        owner = np.repeat(np.arange(len(lobe)), last - first)
        pair = np.arange(len(owner)) + np.repeat(first - np.cumsum(last - first) + (last - first), last - first)
        off = np.linalg.norm(data.whole.uv[found.datum[pair]] - data.whole.uv[rows[owner]], axis=1)
        other = (off >= aside) & (found.apart[pair] <= FARTHEST * apart[owner])
        return np.bincount(owner[other], minlength=len(lobe)) / NTH

    def ask(self, data: Data) -> dict[str, Alike]:
        """By type, the pairs that look alike, of all types and all of Γ.

        Those of the last one that was asked about are kept.
        """
        last = self._last
        if last is None or last[0] is not data.whole:
            last = self._last = (data.whole, self._all(data.whole))
        return last[1]  # not what another thread asks about meanwhile

    def _all(self, data: Data) -> dict[str, Alike]:
        described = np.flatnonzero(data.described)
        vectors = spread(data.descriptors[described])
        row, at, apart = (
            self._within(vectors)
            if len(described) and len(self.lobe)
            else (np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0))
        )
        order = np.lexsort((apart, self.lobe[at], self.owner[at]))
        row, at, apart = row[order], at[order], apart[order]
        ends = np.searchsorted(self.owner[at], np.arange(len(self.names) + 1))
        return {
            name: Alike(described[row[a:b]], self.lobe[at[a:b]], apart[a:b])
            for name, a, b in zip(self.names, ends[:-1], ends[1:], strict=True)
        }

    def _within(self, vectors: NDArray[np.float32]) -> tuple[Indices, Indices, Floats]:
        """Rows of ``vectors`` (N, D), places in the lexicon, and distances, of all alike pairs that share a word."""
        word, row = self._sorted_by_word(vectors)
        ends = np.searchsorted(word, np.arange(len(self.words) + 1))
        own = (vectors**2).sum(axis=1)
        limit = farthest(vectors)
        rows, places, squares = [np.zeros(0, np.intp)], [np.zeros(0, np.intp)], [np.zeros(0)]
        for w in np.flatnonzero((np.diff(ends) > 0) & (np.diff(self.starts) > 0)):
            first, last = self.starts[w], self.starts[w + 1]
            mine = spread(self.descriptors[first:last])[:, : vectors.shape[1]]
            square = (mine**2).sum(axis=1)
            for start in range(ends[w], ends[w + 1], _BLOCK):
                some = row[start : min(start + _BLOCK, ends[w + 1])]
                apart = square[:, None] - 2.0 * (mine @ vectors[some].T) + own[some]
                most = np.partition(apart, NTH - 1, axis=1)[:, NTH - 1 : NTH] if len(some) > NTH else limit**2
                place, near = np.nonzero((apart <= most) & (apart < limit**2))
                rows.append(some[near])
                places.append(place + first)
                squares.append(apart[place, near])
        return (
            np.concatenate(rows),
            np.concatenate(places),
            np.sqrt(np.maximum(np.concatenate(squares), 0.0)) * (FARTHEST / limit),
        )

    def _sorted_by_word(self, vectors: NDArray[np.float32]) -> tuple[Indices, Indices]:
        """Words and rows of (N, D) vectors, each with its ``WORDS`` nearest words and ties with the last."""
        count = min(WORDS, len(self.words))
        words = self.words[:, : vectors.shape[1]]  # an image without colours is compared without them
        squares = (words**2).sum(axis=1)
        near = []
        for start in range(0, len(vectors), _BLOCK):
            apart = squares - 2.0 * (vectors[start : start + _BLOCK] @ words.T)
            row, word = np.nonzero(apart <= np.partition(apart, count - 1, axis=1)[:, count - 1 : count])
            near.append((word, row + start))
        word, row = (np.concatenate(columns) for columns in zip(*near, strict=True))
        order = np.argsort(word, kind="stable")
        return word[order], row[order]


def lexicon_of(clouds: Mapping[str, LearnedCloud], words: NDArray[np.uint8] | None = None) -> Lexicon:
    """Of the keypoints of types' clouds, at least one.

    ``words`` (W, D) bytes are the vocabulary's, which the clouds' words are indices of.
    """
    points = [np.flatnonzero(~cloud.sided) for cloud in clouds.values()]
    sizes = [len(some) for some in points]
    width = min(cloud.descriptor.shape[1] for cloud in clouds.values())
    descriptors = np.concatenate(
        [cloud.descriptor[some, :width] for cloud, some in zip(clouds.values(), points, strict=True)]
    )
    named = [cloud.lobe_word[some] for cloud, some in zip(clouds.values(), points, strict=True)]
    word = np.concatenate(named) if words is not None else np.zeros(sum(sizes), np.int64)
    order = np.argsort(word, kind="stable")
    centres = spread(np.zeros((1, width), np.uint8) if words is None else words[:, :width])
    owner, lobe = np.repeat(np.arange(len(sizes), dtype=np.uint16), sizes), np.concatenate(points)
    starts = np.searchsorted(word[order], np.arange(len(centres) + 1))
    return Lexicon(tuple(clouds), centres, starts, descriptors[order], owner[order], lobe[order])


EACH = 3
"""Features that a keypoint is paired with, the most alike."""
CLOSE, OFF = 120.0, 100.0
"""Descriptors no farther apart are as good as equal; of those farther apart fewer are right, by a bell of this
width."""
MOST, SEEDS = 2500, 400
"""Pairs in all; those of them that poses are made of."""
CELL = 64.0
"""Pixels: half of the pairs are taken in turns from cells of the image this wide, so that no textured floor drowns an
object."""


@dataclass(frozen=True)
class Pairs(Columns):
    """P keypoints and appearances that look alike.

    Half of them the weightiest, half of them the weightiest of each part of the image.

    ``weight`` (P,) in (0, 1], about as the odds that a pair is right: 1 for the keypoint of the image that looks most
    like the appearance, a third for the second, and so on. What looks like much else in the image says little: a corner
    of a letter is anywhere in print.
    """

    datum: Indices
    lobe: Indices
    weight: Floats

    def __len__(self) -> int:
        return len(self.datum)


def pairs_of(index: LearnedIndex, data: Data) -> Pairs:
    """At most ``EACH`` features a keypoint, by their most similar appearance, and ``MOST`` pairs."""
    datum, lobe, apart = index.lexicon.alike(index.object_type.name, data)
    place = np.arange(len(lobe)) - np.searchsorted(lobe, lobe)
    near = place < NTH
    datum, lobe, apart, place = datum[near], lobe[near], apart[near], place[near]
    weight = np.exp(-0.5 * (np.maximum(apart - CLOSE, 0.0) / OFF) ** 2) / (1.0 + place) ** 1.5
    feature = index.cloud.feature[lobe]
    keep = np.lexsort((datum, -weight))  # of one datum by appearance, for so they come
    keep = _leading(keep, datum * len(index.points) + feature, 1)
    keep = _leading(keep, datum, EACH)
    best = keep[fairly(data.uv[datum[keep]], CELL)[:MOST]]
    return Pairs(datum[best], lobe[best], weight[best])


def _leading(order: Indices, owner: Indices, most: int) -> Indices:
    """Of pairs in some order the first few of each owner, in that order."""
    owners = owner[order]
    by_owner = np.argsort(owners, kind="stable")
    place = np.arange(len(order)) - np.searchsorted(owners[by_owner], owners[by_owner])
    return order[np.sort(by_owner[place < most])]


NEAREST_MIDDLE, FARTHEST_MIDDLE = 0.6, 40.0
"""Distances of the object's middle, in its diameters, that are believed."""


def single_poses(index: LearnedIndex, pairs: Pairs, data: Data) -> Floats:
    """(N, 4, 4) camera_from_object of those of the P pairs that place the object before the camera, N ≤ P."""
    at = sights(pairs, data) * depths(index, pairs, data)[:, None]
    poses = np.tile(np.eye(4), (len(at), 1, 1))
    poses[:, :3, :3] = turns(index, pairs, data)
    poses[:, :3, 3] = at - np.einsum("nij,nj->ni", poses[:, :3, :3], index.places[pairs.lobe])
    return poses[plausible(index, poses)]


def sights(pairs: Pairs, data: Data) -> Floats:
    """(P, 3) the lines of sight to the pairs' keypoints, camera frame, of depth 1."""
    return np.column_stack([(data.ideal[pairs.datum] - centre_of(data.camera)) / data.camera.f, np.ones(len(pairs))])


def depths(index: LearnedIndex, pairs: Pairs, data: Data) -> Floats:
    """(P,) metres at which the lobes' sizes are those of the keypoints."""
    return np.asarray(index.cloud.size[pairs.lobe] * data.camera.f / data.scale[pairs.datum])


def turns(index: LearnedIndex, pairs: Pairs, data: Data) -> Floats:
    """(P, 3, 3) the rotations at which each lobe is seen from its middle, its appearance turned as the keypoint is."""
    cloud, angle, at = index.cloud, data.angle[pairs.datum], sights(pairs, data) * depths(index, pairs, data)[:, None]
    back = -at / np.linalg.norm(at, axis=1, keepdims=True)
    screen = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))])
    up = screen - (screen * back).sum(axis=1, keepdims=True) * back
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    camera = np.stack([back, up, np.cross(back, up)], axis=2)
    axis, own_up = cloud.axis[pairs.lobe], cloud.up[pairs.lobe]
    return np.asarray(camera @ np.swapaxes(np.stack([axis, own_up, np.cross(axis, own_up)], axis=2), 1, 2))


def plausible(index: LearnedIndex, poses: Floats) -> Mask:
    """(N,) finite, and the middle neither behind the camera, nor too near, nor absurdly far."""
    depth = poses[:, 2, :3] @ index.centre + poses[:, 2, 3]
    return np.asarray(
        np.isfinite(poses).all(axis=(1, 2))
        & (depth > NEAREST_MIDDLE * index.diameter)
        & (depth < FARTHEST_MIDDLE * index.diameter)
    )
