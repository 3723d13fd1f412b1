"""Learned clouds of no object, for tests of what holds of all."""

from __future__ import annotations

import numpy as np

from kb.clouds.learned import LearnedCloud
from kb.clouds.words import Words


def random_words(seed=0, count=7, width=128):
    centroids = np.random.default_rng(seed).integers(0, 256, (count, width), np.uint8)
    return Words("orb" if width == 32 else "sift", centroids)


def random_cloud(seed=0, features=6, lobes=11, words=7, width=128, **changed):
    """``lobes`` ≥ ``features``; each feature has at least one."""
    rng = np.random.default_rng(seed)
    axis, normal = unit(rng.normal(size=(lobes, 3))), unit(rng.normal(size=(features, 3)))
    feature = np.sort(np.concatenate([np.arange(features), rng.integers(0, max(features, 1), lobes - features)]))
    parts = {
        "at": rng.uniform(-0.1, 0.1, (features, 3)),
        "sigma": rng.uniform(1e-4, 1e-3, features),
        "normal": normal,
        "word": rng.integers(0, words, features),
        "feature": feature.astype(np.int64),
        "lobe_word": rng.integers(0, words, lobes),
        "descriptor": rng.integers(0, 256, (lobes, width), np.uint8),
        "axis": axis,
        "half_angle": rng.uniform(0.2, 0.6, lobes),
        "r_min": rng.uniform(0.1, 0.5, lobes),
        "r_max": rng.uniform(1.0, 3.0, lobes),
        "hit": rng.uniform(0.3, 0.9, lobes),
        "up": unit(np.cross(axis, rng.normal(size=(lobes, 3)))),
        "size": rng.uniform(0.005, 0.02, lobes),
    }
    return LearnedCloud(**(parts | changed))


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
