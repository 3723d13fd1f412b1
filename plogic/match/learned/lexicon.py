"""All learned types' appearances by visual word: of a keypoint only those of its nearest words are looked at, for all types at once.

* ``Lexicon``: the L appearances of all types; ``alike(name, data)`` says which of one type look like which keypoint
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from geometry.arrays import Floats, Indices
    from kb.clouds.learned import LearnedCloud
    from plogic.match.gamma.data import Data


FARTHEST, FARTHEST_BITS = 270.0, 7.65
"""Farthest descriptors that look alike: of SIFT, with or without colours, and of ORB's bits (58 of them)."""
WORDS = 8
"""Words of a keypoint whose appearances are looked at, the nearest."""
NTH = 8
"""Keypoints of a word that an appearance is compared with any further, the most alike."""
_BLOCK = 2048


class Alike(NamedTuple):
    """N pairs that look alike: ``datum`` (N,), ``lobe`` (N,), ``apart`` (N,) the distance of the descriptors in SIFT's measure.

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

    def __post_init__(self) -> None:
        self._last: tuple[Data, dict[str, Alike]] | None = None

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
        """(N,) of appearances of a type, how many other keypoints of all of Γ look as right, as a share of ``NTH``, the most that are known.

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
        """By type, the pairs that look alike, of all types and all of Γ: those of the last one that was asked about are kept."""
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
        """Rows of ``vectors`` (N, D), places in the lexicon, and distances, of all pairs that look alike and share a word."""
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
        """Words and rows of (N, D) vectors, each row with its ``WORDS`` nearest words, and those as near as the last of them, by word."""
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
