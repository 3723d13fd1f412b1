"""The words of a knowledge base's clouds, remembered in the user's cache folder: k-means takes seconds."""

import hashlib
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from geometry.files.remembered import ROOT, arrays_of, cache_folder, source_digest, sources
from kb.clouds.learned import LearnedCloud
from kb.clouds.words import WIDTHS, Words, worded

DECIDES = "kb/clouds/words.py"
"""What makes words, with all that it imports."""
KEPT = 32
"""So many vocabularies are kept, of some megabytes each."""


def words_of(clouds: Mapping[str, LearnedCloud], seed: int) -> tuple[Words, dict[str, LearnedCloud]]:
    """As ``worded``, of at least one cloud by name."""
    folder = cache_folder("words")
    if folder is None:
        return worded(clouds, seed)
    names = sorted(clouds)

    def made() -> dict[str, np.ndarray]:
        words, named = worded(clouds, seed)
        each = [named[name] for name in names]
        return {
            "centroids": words.centroids,
            "word": np.concatenate([cloud.word for cloud in each]),
            "lobe_word": np.concatenate([cloud.lobe_word for cloud in each]),
        }

    arrays = arrays_of(
        folder / _key([clouds[name] for name in names], seed), ("centroids", "word", "lobe_word"), made, KEPT
    )
    word, lobe_word = (
        np.split(arrays[kind], np.cumsum([len(getattr(clouds[name], rows)) for name in names])[:-1])
        for kind, rows in (("word", "at"), ("lobe_word", "feature"))
    )
    centroids = np.array(arrays["centroids"])
    return Words(WIDTHS[centroids.shape[1]], centroids), {
        name: replace(clouds[name], word=word[i], lobe_word=lobe_word[i]) for i, name in enumerate(names)
    }


def _key(clouds: list[LearnedCloud], seed: int) -> str:
    """SHA-256 over all that decides words: what looks how, and how often, the source, OpenCV."""
    import cv2

    total = hashlib.sha256(repr((seed, cv2.__version__, np.__version__)).encode())
    total.update(source_digest(ROOT, sources(ROOT, DECIDES)))
    for cloud in clouds:
        for array in (cloud.descriptor, cloud.feature, cloud.hit, np.array(len(cloud.at))):
            total.update(repr((array.shape, array.dtype.str)).encode() + np.ascontiguousarray(array).tobytes())
    return total.hexdigest()
