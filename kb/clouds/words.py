"""Visual words: the vocabulary of a KB over keypoints' descriptors, so that dv means something.

Rare words are distinctive (§5.1).

* ``Words("sift", centroids)``: W words, ``sift_w0000``, ...; a descriptor's word is the nearest centroid
"""

import hashlib
import io
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kb.clouds.learned import LearnedCloud, read_arrays
from kb.errors import CloudError

MOST, PER_WORD = 1024, 20
"""Words at most, and descriptors that a word stands for at least, on average."""
SAMPLE = 40
"""Descriptors a word, evenly chosen, that k-means goes by at most: of 21 scanned types in a ninth of the time that
all take, and what is seen is 3 % farther from its word."""
ROUNDS = 8
"""Steps of k-means after its start, which goes by every second descriptor: both, and the steps as products of matrices,
take a third of the time of OpenCV's twelve, and what is seen is 0.3 % farther from its word."""
MAX_BYTES = 10_000_000
"""Largest ``words.npz``."""
WIDTHS = {128: "sift", 138: "sift", 32: "orb"}
"""Whose descriptors have so many bytes; those of SIFT in an image with colours have ten more."""
POINT, SIDE = 128, 5
"""Bytes of a descriptor of SIFT before its colours, and of the looks of the side of an edge, which has those and 0
before them."""
COLOURS = 4
"""Those of these bytes that are the side's own, whatever is beyond the edge; the other is its brightness against
that."""
_BLOCK = 4096


@dataclass(frozen=True, eq=False)
class Words:
    """``centroids`` (W, D) uint8.

    128 or 138 bytes of ``sift``, compared by Euclid's distance, or 32 of ``orb``, by Hamming's.
    """

    detector: str
    centroids: NDArray[np.uint8]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The words as appearance types."""
        return tuple(f"{self.detector}_w{i:04d}" for i in range(len(self.centroids)))

    @cached_property
    def digest(self) -> NDArray[np.uint8]:
        """(32,) SHA-256 of the centroids: a cloud says by it which words it was learned with."""
        content = repr(self.centroids.shape).encode() + np.ascontiguousarray(self.centroids).tobytes()
        return np.frombuffer(hashlib.sha256(content).digest(), np.uint8)

    @cached_property
    def sided(self) -> NDArray[np.bool_]:
        """(W,) which are words of the sides of edges."""
        wide = self.centroids.shape[1] > POINT
        return np.asarray(~self.centroids[:, :POINT].any(axis=1)) if wide else np.zeros(len(self.centroids), bool)

    def nearest_side(self, looks: NDArray[np.uint8], /) -> NDArray[np.int64]:
        """(N,) index of the word nearest to the looks (N, 5) of sides of edges, among one word of sides or more."""
        some = np.flatnonzero(self.sided)
        words = self.centroids[some, POINT : POINT + SIDE].astype(np.float32)
        apart = (words**2).sum(axis=1) - 2.0 * (looks.astype(np.float32) @ words.T)
        return np.asarray(some[apart.argmin(axis=1)], np.int64)

    def nearest(self, descriptors: NDArray[np.uint8], /) -> NDArray[np.int64]:
        """(N,) index of the word nearest to (N, D) descriptors, the first of several.

        Colours count where both have them.
        """
        blocks = [self._nearest(descriptors[i : i + _BLOCK]) for i in range(0, len(descriptors), _BLOCK)]
        return np.concatenate([*blocks, np.zeros(0, np.int64)])

    def _nearest(self, descriptors: NDArray[np.uint8]) -> NDArray[np.int64]:
        width = min(descriptors.shape[1], self.centroids.shape[1])
        return _closest(_spread(descriptors[:, :width]), _spread(self.centroids[:, :width])).astype(np.int64)


def _spread(descriptors: NDArray[np.uint8]) -> NDArray[np.float32]:
    """As vectors whose squared distance is Euclid's squared (SIFT) or Hamming's (ORB's 256 bits)."""
    if descriptors.shape[1] == 32:
        return np.unpackbits(descriptors, axis=1).astype(np.float32)
    return descriptors.astype(np.float32)


def learn_words(descriptors: NDArray[np.uint8], seed: int = 0) -> Words:
    """k-means over descriptors (N, 128), (N, 138) or (N, 32), N ≥ 1.

    The same descriptors and seed give the same words.
    """
    import cv2

    count = max(1, min(MOST, len(descriptors) // PER_WORD))
    most = SAMPLE * count
    if len(descriptors) > most:
        descriptors = descriptors[np.linspace(0, len(descriptors) - 1, most).astype(np.intp)]
    spread = _spread(descriptors)
    some = spread[:: 2 if len(spread) >= 4 * count else 1]
    cv2.setRNGSeed(seed)
    criteria, labels = (cv2.TERM_CRITERIA_MAX_ITER, 1, 0.0), np.zeros((len(some), 1), np.int32)
    centres = some
    if len(some) > 1:
        centres = np.asarray(cv2.kmeans(some, count, labels, criteria, 1, cv2.KMEANS_PP_CENTERS)[2], np.float32)
    for _ in range(ROUNDS):
        centres = _moved(spread, centres)
    width = descriptors.shape[1]
    centroids = (
        np.packbits(centres > 0.5, axis=1) if width == 32 else np.clip(np.rint(centres), 0, 255).astype(np.uint8)
    )
    return Words(WIDTHS[width], centroids)


def _moved(spread: NDArray[np.float32], centres: NDArray[np.float32]) -> NDArray[np.float32]:
    """Each of the centres (W, D) in the mean of those (N, D) that it is nearest to; where there are none, as it was."""
    near = np.concatenate([_closest(spread[i : i + _BLOCK], centres) for i in range(0, len(spread), _BLOCK)])
    order, count = np.argsort(near, kind="stable"), np.bincount(near, minlength=len(centres))
    taken, result = np.flatnonzero(count), centres.copy()
    total = np.add.reduceat(spread[order], (np.cumsum(count) - count)[taken], axis=0)
    result[taken] = total / count[taken, None].astype(np.float32)
    return result


def _closest(some: NDArray[np.float32], centres: NDArray[np.float32]) -> NDArray[np.intp]:
    """(N,) which of the centres (W, D) is nearest to each (N, D), the first of several."""
    return np.asarray(((centres**2).sum(axis=1)[None] - 2.0 * (some @ centres.T)).argmin(axis=1))


def words_bytes(words: Words) -> bytes:
    """The contents of ``words.npz``: one array, never pickled."""
    memory = io.BytesIO()
    np.savez(memory, allow_pickle=False, centroids=words.centroids)
    return memory.getvalue()


def read_words(content: bytes) -> Words:
    """The words of a file. Raises CloudError where it is none."""
    try:
        centroids = np.asarray(read_arrays(content, ("centroids",), MAX_BYTES)["centroids"])
    except CloudError as error:
        raise CloudError(f"is no vocabulary of visual words: {error}") from None
    if (
        centroids.ndim != 2
        or centroids.shape[1] not in WIDTHS
        or centroids.dtype != np.uint8
        or not 0 < len(centroids) <= MOST
    ):
        raise CloudError(
            f"centroids: has shape {centroids.shape} of {centroids.dtype}, not (W, 128), (W, 138) or (W, 32) of uint8"
        )
    return Words(WIDTHS[centroids.shape[1]], centroids.astype(np.uint8))


def dominant(
    feature: NDArray[np.int64], word: NDArray[np.int64], hit: NDArray[np.float64], count: int
) -> NDArray[np.int64]:
    """(F,) the word that most of a feature's lobes (L,) report, by their hit rates; of equals the least."""
    pairs, which = np.unique(np.column_stack([feature, word]), axis=0, return_inverse=True)
    weight = np.bincount(which.ravel(), weights=hit, minlength=len(pairs))
    order = np.lexsort((pairs[:, 1], -weight, pairs[:, 0]))
    owners, first = np.unique(pairs[order, 0], return_index=True)
    result = np.zeros(count, np.int64)
    result[owners] = pairs[order[first], 1]
    return result


def worded(clouds: Mapping[str, LearnedCloud], seed: int = 0) -> tuple[Words, dict[str, LearnedCloud]]:
    """The words of at least one cloud by name, all of one detector, and the clouds with their words.

    The same clouds give the same words.
    """
    names = sorted(clouds)
    width = min(clouds[name].descriptor.shape[1] for name in names)  # one learned from a grey photo: no colours for any
    words = learn_words(np.concatenate([clouds[name].descriptor[:, :width] for name in names]), seed)
    return words, {name: _named(clouds[name], words) for name in names}


def _named(cloud: LearnedCloud, words: Words) -> LearnedCloud:
    lobe_word = words.nearest(cloud.descriptor)
    return replace(cloud, lobe_word=lobe_word, word=dominant(cloud.feature, lobe_word, cloud.hit, len(cloud.at)))
