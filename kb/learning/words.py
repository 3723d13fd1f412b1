"""The words of a knowledge base: learned from all of its clouds together, then given to each."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kb.clouds.words import Words, dominant, learn_words

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kb.clouds.learned import LearnedCloud


def worded(clouds: Mapping[str, LearnedCloud], seed: int = 0) -> tuple[Words, dict[str, LearnedCloud]]:
    """The words of at least one cloud by name, all of one detector, and the clouds with their words: the same clouds give the same words."""
    names = sorted(clouds)
    width = min(clouds[name].descriptor.shape[1] for name in names)  # one learned from a grey photo: no colours for any
    words = learn_words(np.concatenate([clouds[name].descriptor[:, :width] for name in names]), seed)
    return words, {name: _named(clouds[name], words) for name in names}


def _named(cloud: LearnedCloud, words: Words) -> LearnedCloud:
    lobe_word = words.nearest(cloud.descriptor)
    return replace(cloud, lobe_word=lobe_word, word=dominant(cloud.feature, lobe_word, cloud.hit, len(cloud.at)))
