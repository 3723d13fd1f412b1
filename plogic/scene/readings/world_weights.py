"""The weights of worlds in the two readings, in many worlds at once (§5.5, §8).

Score: P(present(H) | the others). Posterior: the prior of a world's hypotheses times what Γ, and what is missing in Γ,
says of it. Worlds are columns: ``present["h2"]`` is a boolean array (M,) that says in which of M worlds h2 is present.
Vocabulary:

* ``Cells``: for one feature in every world, whether it is expected and detected, two arrays (M,)
"""

import math
from collections.abc import Iterable, Mapping
from functools import reduce
from typing import NamedTuple, TypeAlias

import numpy as np

from geometry.arrays import Floats, Mask
from plogic.base.bounds import LEAST, alternative, bounded
from plogic.base.walk import by_key
from plogic.facts import hypothesis as d7
from plogic.facts.dependence import Scene
from plogic.facts.hypothesis import FeatureFact, Hypothesis

Present: TypeAlias = Mapping[str, Mask]
"""In which of M worlds each hypothesis is present, (M,) each."""


class Cells(NamedTuple):
    """One feature's Expected and Detected, (M,) each."""

    expected: Mask
    detected: Mask


def hidden(scene: Scene, h: Hypothesis, f: FeatureFact, present: Present) -> Mask:
    """Where some present opaque hypothesis, no rival, lies before the feature (D4)."""
    result = np.zeros_like(next(iter(present.values())))
    for g in scene.hiders(h, f):
        result |= present[g]
    return result


def expected(scene: Scene, h: Hypothesis, f: FeatureFact, present: Present) -> Mask:
    """D7 in every world, given that ``h`` is in it."""
    return d7.expected(f, h.opaque, hidden(scene, h, f, present))


def cells(scene: Scene, h: Hypothesis, f: FeatureFact, present: Present) -> Cells:
    """D7 and D8.

    In mode `reassign` an unexpected feature loses an appearance that another object's expected feature claims.
    """
    awaited = expected(scene, h, f, present)
    found = np.full_like(awaited, f.match is not None and f.in_image)
    if scene.situation.reconsider == "reassign":
        for g, e in scene.robbers(h, f):
            found &= awaited | ~(present[g.id] & expected(scene, g, e, present))
    return Cells(awaited, found)


class Four(NamedTuple):
    """The four cases of §4 of one feature, (M,) each, in the order of Table 1: in which worlds it counts in each."""

    a: Mask
    c: Mask
    b: Mask
    d: Mask


def four(scene: Scene, h: Hypothesis, f: FeatureFact, present: Present) -> Four:
    """The case of a feature in every world (§5.5).

    In mode `drop` that of the hypothesis alone, and of a C cell that a present occluder explains none.
    """
    if scene.situation.reconsider != "drop":
        awaited, found = cells(scene, h, f, present)
        return Four(awaited & found, awaited & ~found, ~awaited & ~found, ~awaited & found)
    awaited, found = (np.full_like(present[h.id], flag) for flag in (h.expects(f), f.match is not None))
    unexplained = awaited & ~found & ~hidden(scene, h, f, present)
    return Four(awaited & found, unexplained, ~awaited & ~found, ~awaited & found)


def supported(scene: Scene, h: Hypothesis, present: Present) -> Mask:
    """Where at least one feature of ``h`` is detected (trap b: a fully hidden phantom would have ev = +1)."""
    result = np.zeros_like(next(iter(present.values())))
    for f in h.features:
        result |= cells(scene, h, f, present).detected
    return result


def p_ev(scene: Scene, h: Hypothesis, present: Present) -> Floats:
    """P(ev) of ``h`` after reconsideration in every world, (M,); NaN where it is 0/0."""
    if scene.situation.reconsider == "drop":
        return _dropped(scene, h, present)
    seen = [f for f in h.features if f.in_image]
    shares = alternative([f.dv for f in seen])
    total = np.zeros(len(next(iter(present.values()))))
    for f, share in zip(seen, shares, strict=False):
        cell = cells(scene, h, f, present)
        total += share * (cell.expected == cell.detected)
    return snapped(total) if shares else np.full_like(total, np.nan)


def snapped(total: Floats) -> Floats:
    """A sum of shares that is 0 or 1 but for rounding is 0 or 1: the certain stays certain."""
    return np.where(total > 1.0 - 1e-12, 1.0, np.where(total < 1e-12, 0.0, total))


def _dropped(scene: Scene, h: Hypothesis, present: Present) -> Floats:
    """The cells of the hypothesis alone, without the C cells that a present occluder explains."""
    good = np.zeros(len(next(iter(present.values()))))
    bad = np.zeros_like(good)
    for f in (f for f in h.features if f.in_image):
        case = four(scene, h, f, present)
        good += f.dv * (case.a | case.b)
        bad += f.dv * (case.c | case.d)
    total = good + bad
    return np.divide(good, total, out=np.full_like(good, np.nan), where=total > 0)


def acceptance(scene: Scene, h: Hypothesis, present: Present, influences: tuple[str, ...]) -> Floats:
    """P(present(h) | the others) in every world, (M,): P(ev), smoothed; 0 where ev is undefined or nothing is detected.

    Only the presence of ``influences`` is looked at; ``h`` itself is taken as present.
    """
    nobody = np.zeros_like(present[h.id])
    seen = {g: present[g] if g in influences else nobody for g in scene.by_id} | {h.id: ~nobody}
    p = p_ev(scene, h, seen)
    epsilon = lifted_smoothing(scene)
    accepted = epsilon + (1.0 - 2.0 * epsilon) * p
    if scene.situation.reconsider == "drop":
        accepted = np.where((p > 0) & (p < 1) | (epsilon > 0), np.clip(accepted, LEAST, 1.0 - LEAST), accepted)
    return np.where(np.isnan(p) | ~supported(scene, h, seen), 0.0, accepted)


def lifted_smoothing(scene: Scene) -> float:
    """ε as programs can carry it: 0, or at least ``LEAST``."""
    epsilon = scene.situation.smoothing
    return max(epsilon, LEAST) if epsilon > 0 else 0.0


DEFAULT_PRIOR = 0.5
"""Prior of a type for which the knowledge base states none."""


class Shares(NamedTuple):
    """The alternative of one appearance.

    Each claimant's share, the share of noise, and the density that a share of 1 stands for.
    """

    claimants: list[float]
    noise: float
    scale: float


def shares_of(densities: list[float], clutter: float) -> Shares:
    """N_i / Z for each claimant, f / Z for noise, Z = ΣN + f; where all are 0 nothing can cause the appearance."""
    shares = alternative([*densities, clutter])
    if not shares:
        return Shares([0.0] * len(densities), 0.0, 1.0)
    return Shares(shares[:-1], shares[-1], sum(densities) + clutter)


def group_shares(scene: Scene) -> dict[str, list[tuple[str, float]]]:
    """Group → (hypothesis, its share of the prior): rivals for one instance share prior(Type) evenly."""
    priors = scene.situation.priors
    return {
        name: [(h.id, bounded(priors.get(h.type, DEFAULT_PRIOR) / len(members))) for h in members]
        for name, members in by_key((h.group, h) for h in scene.situation.hypotheses).items()
    }


def causes_of(scene: Scene, appearance: str) -> Shares:
    """The shares of an appearance's claimants, in their order."""
    clutter = next(a.clutter for a in scene.situation.appearances if a.id == appearance)
    return shares_of([f.density for _, f in scene.claimants.get(appearance, [])], clutter)


def log_scale(scene: Scene) -> float:
    """Ln of what the program text weighs less than densities do (posterior).

    Alternatives of causes are normalised, and pixels and stances are told over the greatest that they could say.
    """
    if scene.situation.reading == "score":
        return 0.0
    most = [max(0.0, *h.pixel_table.odds) for h in scene.situation.hypotheses if h.pixel_table is not None]
    support = scene.situation.support
    told = [] if support is None else [(s.hypothesis, s.log_ratio) for s in support.stances]
    told += [] if support is None else [(name, ratio) for name, _, ratio in support.level]
    ratios = by_key(told)
    most += [max(0.0, *mine) for mine in ratios.values()]
    return math.fsum([*most, *(math.log(causes_of(scene, appearance).scale) for appearance in scene.claimants)])


def appearance_weight(scene: Scene, appearance: str, present: Present) -> Floats:
    """Σ_i N_i h_i Π_{j≠i}(1−h_j) + f Π_j(1−h_j) over the present, expected claimants, in every world, (M,)."""
    causes = causes_of(scene, appearance)
    hits = [_hit(scene, h, f, present) for h, f in scene.claimants.get(appearance, [])]
    misses = [1.0 - hit for hit in hits]
    weight = causes.noise * _product(misses, present)
    for i, (share, hit) in enumerate(zip(causes.claimants, hits, strict=True)):
        weight += share * hit * _product(misses[:i] + misses[i + 1 :], present)
    return weight * causes.scale


def miss_weight(scene: Scene, h: Hypothesis, f: FeatureFact, present: Present) -> Floats:
    """1 − h_F where the feature is expected, (M,); it has no appearance."""
    return 1.0 - _hit(scene, h, f, present)


def pixel_odds(h: Hypothesis, present: Present) -> Floats:
    """What the photo's pixels say of ``h``, log-odds, in every world, (M,): 0 where it is absent (§9.10)."""
    table = h.pixel_table
    return np.zeros(len(present[h.id])) if table is None else np.where(present[h.id], table.told(present), 0.0)


def unmatched(h: Hypothesis) -> Iterable[FeatureFact]:
    """The candidate features that no appearance was found for."""
    return (f for f in h.features if f.match is None and h.expects(f))


def _hit(scene: Scene, h: Hypothesis, f: FeatureFact, present: Present) -> Floats:
    live: Mask = present[h.id] & expected(scene, h, f, present)
    return bounded(f.hit_rate) * live.astype(np.float64)


def _product(factors: list[Floats], present: Present) -> Floats:
    return reduce(np.multiply, factors, np.ones(len(next(iter(present.values())))))
