"""The prior of clutter where a KB states none: λ·P(dv(F)) (§8, posterior; trap e).

What objects often show, noise often looks like: a common appearance is the likelier clutter, a distinctive one the
rarer.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kb.clouds.cloud import ObjectType

LAMBDA = 1.0
"""Clutter appearances an image, per appearance type of the vocabulary, on the average."""
KEYPOINTS = 4000.0
"""Keypoints of clutter an image, of all visual words together."""
LEAST = 0.01
"""Share of that average that an appearance type has at least, though no feature looks like it."""


def clutter_prior(types: Sequence[ObjectType], appearance_types: Sequence[str]) -> dict[str, float]:
    """Expected clutter appearances an image per appearance type: λ in all, shared out by P(dv(F)).

    P(dv(F)) = |S(F)|/|S| of a feature type F is divided evenly among the appearance types that F can look like.
    """
    instances: Counter[str] = Counter()
    looks: dict[str, set[str]] = {}
    for feature in (feature for kind in types if kind.learned is None for feature in kind.all_features):
        instances[feature.type] += 1
        looks.setdefault(feature.type, set()).update(appearance.type for appearance in feature.appearances)
    total, share = sum(instances.values()), dict.fromkeys(appearance_types, 0.0)
    for kind, number in instances.items():
        for name in looks[kind]:
            share[name] += number / total / len(looks[kind])
    whole = LAMBDA * len(appearance_types)
    return {name: round(max(whole * part, LEAST * LAMBDA), 6) for name, part in share.items()}


def word_clutter(types: Sequence[ObjectType], words: Sequence[str]) -> dict[str, float]:
    """Expected keypoints of clutter an image per visual word: ``KEYPOINTS`` in all, shared out by P(dv(F)), each word having one feature at least.

    Of the features that keypoints are matched to: a compound has no keypoint besides those of its parts.
    """
    seen = Counter(dict.fromkeys(words, 1))
    seen.update(feature.type for kind in types if kind.learned is not None for feature in kind.seen_features)
    total = sum(seen.values())
    return {name: KEYPOINTS * seen[name] / total for name in words}
