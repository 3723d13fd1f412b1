"""The words of a knowledge base: learnt from all of its clouds together, then given to each."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kb.words import Words, learn_words

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kb.learnt import LearntCloud


def worded(clouds: Mapping[str, LearntCloud], seed: int = 0) -> tuple[Words, dict[str, LearntCloud]]:
    """The words of at least one cloud by name, all of one detector, and the clouds with their words: the same clouds give the same words."""
    names = sorted(clouds)
    width = min(clouds[name].descriptor.shape[1] for name in names)  # one learnt from a grey photo: no colours for any
    words = learn_words(np.concatenate([clouds[name].descriptor[:, :width] for name in names]), seed)
    return words, {name: _named(clouds[name], words) for name in names}


def _named(cloud: LearntCloud, words: Words) -> LearntCloud:
    lobe_word = words.nearest(cloud.descriptor)
    return replace(cloud, lobe_word=lobe_word, word=_dominant(cloud.feature, lobe_word, cloud.hit, len(cloud.at)))


def _dominant(feature: NDArray[np.int64], word: NDArray[np.int64], hit: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """(F,) the word that most of a feature's lobes report, by their hit rates; of equals the least."""
    pairs, which = np.unique(np.column_stack([feature, word]), axis=0, return_inverse=True)
    weight = np.bincount(which.ravel(), weights=hit, minlength=len(pairs))
    order = np.lexsort((pairs[:, 1], -weight, pairs[:, 0]))
    owners, first = np.unique(pairs[order, 0], return_index=True)
    result = np.zeros(count, np.int64)
    result[owners] = pairs[order[first], 1]
    return result
