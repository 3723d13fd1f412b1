"""Distinctiveness dv of feature types (§5.1).

Vocabulary: ``Counts``, the number of instances |S(F)| of each feature type F, for example ``{"apex": 1, "corner": 16,
"patch": 95}``.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from kb.clouds.cloud import ObjectType


def instance_counts(types: Iterable[ObjectType]) -> dict[str, int]:
    """Count S(F): the Feature nodes of each type over ``types``, instances and not appearances.

    Compounds and their parts alike (§2.2).

    The same type given twice counts twice: that is what dv over Δ wants (§5.1, variant of §9).
    """
    counts: Counter[str] = Counter()
    for object_type in types:
        counts.update(feature.type for feature in object_type.all_features)
    return dict(sorted(counts.items()))


def probability_of_distinctiveness(counts: Mapping[str, int]) -> dict[str, float]:
    """P(dv(F)) = |S(F)| / |S|; it sums to 1 over the feature types, and is empty where S is."""
    total = sum(counts.values())
    return {name: number / total for name, number in counts.items() if total}


def distinctiveness(counts: Mapping[str, int]) -> dict[str, float]:
    """dv(F) = 1 − |S(F)| / |S| (§5.1). With one feature type in all of S every dv is 0."""
    return {name: 1.0 - share for name, share in probability_of_distinctiveness(counts).items()}


def distinctiveness_over_delta(accepted: Iterable[ObjectType], background: Iterable[ObjectType]) -> dict[str, float]:
    """Dv over the instances in Δ, falling back to Σo when Δ is empty (§5.1, the variant of the paper's §9).

    A feature type of Σo without an instance in Δ is as distinctive as can be: its dv is 1.
    """
    over_background = instance_counts(background)
    over_delta = instance_counts(accepted)
    if not over_delta:
        return distinctiveness(over_background)
    return distinctiveness({name: over_delta.get(name, 0) for name in over_background})
