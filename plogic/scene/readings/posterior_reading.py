"""The weight of a world in the posterior reading (§8): prior of its hypotheses times what Γ, and what is missing in Γ, says of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.base.bounds import alternative, bounded
from plogic.scene.readings.score_reading import Present, expected

if TYPE_CHECKING:
    from collections.abc import Iterable

    from geometry.arrays import Floats, Mask
    from plogic.facts.dependence import Scene
    from plogic.facts.hypothesis import FeatureFact, Hypothesis

DEFAULT_PRIOR = 0.5
"""Prior of a type for which the knowledge base states none."""


class Causes(NamedTuple):
    """The alternative of one appearance: each claimant's share, the share of noise, and the density that a share of 1 stands for."""

    claimants: list[tuple[Hypothesis, FeatureFact]]
    shares: list[float]
    noise: float
    scale: float


def group_shares(scene: Scene) -> dict[str, list[tuple[str, float]]]:
    """Group → (hypothesis, its share of the prior): rivals for one instance share prior(Type) evenly."""
    groups: dict[str, list[Hypothesis]] = {}
    for h in scene.situation.hypotheses:
        groups.setdefault(h.group, []).append(h)
    priors = scene.situation.priors
    return {
        name: [(h.id, bounded(priors.get(h.type, DEFAULT_PRIOR) / len(members))) for h in members]
        for name, members in groups.items()
    }


def causes_of(scene: Scene, appearance: str) -> Causes:
    """N_i / Z for each claimant, f / Z for noise, Z = ΣN + f.

    Where all are 0 nothing can cause the appearance and the list is empty.
    """
    claimants = scene.claimants.get(appearance, [])
    clutter = next(a.clutter for a in scene.situation.appearances if a.id == appearance)
    densities = [f.density for _, f in claimants]
    shares = alternative([*densities, clutter])
    if not shares:
        return Causes(claimants, [0.0] * len(claimants), 0.0, 1.0)
    return Causes(claimants, shares[:-1], shares[-1], sum(densities) + clutter)


def appearance_weight(scene: Scene, appearance: str, present: Present) -> Floats:
    """Σ_i N_i h_i Π_{j≠i}(1−h_j) + f Π_j(1−h_j) over the present, expected claimants, in every world, (M,)."""
    causes = causes_of(scene, appearance)
    hits = [_hit(scene, h, f, present) for h, f in causes.claimants]
    misses = [1.0 - hit for hit in hits]
    weight = causes.noise * _product(misses, present)
    for i, (share, hit) in enumerate(zip(causes.shares, hits, strict=True)):
        weight += share * hit * _product(misses[:i] + misses[i + 1 :], present)
    return weight * causes.scale


def miss_weight(scene: Scene, h: Hypothesis, f: FeatureFact, present: Present) -> Floats:
    """1 − h_F where the feature is expected, (M,); it has no appearance."""
    return 1.0 - _hit(scene, h, f, present)


def unmatched(h: Hypothesis) -> Iterable[FeatureFact]:
    """The candidate features that no appearance was found for."""
    return (f for f in h.features if f.match is None and h.expects(f))


def _hit(scene: Scene, h: Hypothesis, f: FeatureFact, present: Present) -> Floats:
    live: Mask = present[h.id] & expected(scene, h, f, present)
    return bounded(f.hit_rate) * live.astype(np.float64)


def _product(factors: list[Floats], present: Present) -> Floats:
    result = np.ones(len(next(iter(present.values()))))
    for factor in factors:
        result = result * factor
    return result
