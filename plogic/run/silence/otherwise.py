"""What would be found were one thing otherwise: the ranges of lobes, their directions, the camera, and the like.

A type that is found only so is missing because of that one thing: the cause is shown by the search itself. Learned
types are not asked so: their lobes were measured.

* ``CHANGES``: one thing each, ``Change("range", kb=..., gamma=..., told=...)``
* ``found_if(change, kinds, ...)``: what is accepted then
* ``causes(kinds, ...)``: a sentence for each type that some change finds
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, pi
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.lobes import Feature, Lobe
from plogic.cycle.perception import attend, perceive
from plogic.cycle.state import Task
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import data_of
from plogic.match.kinds import models_of
from sensing.appearance import Appearance, Gamma

CONVINCING = (6, 0.7)
"""Detected features, and their share of those expected, from which on a change is told of: under many changes something
is found by chance."""
CONVINCING_LOOSE = (8, 0.8)
"""The same where the tolerance is wide, so that chance finds more."""
SURE, SURELY = 8, 0.9
"""Detected features, and their share of those expected, at which no other change is tried."""
MARGIN = 5.0
"""By how much, as a log-likelihood ratio, a later change must explain the data better than an earlier one."""
NOTHING = -inf, ""
LOOSER = 4.0
"""By how much the tolerance is widened, to see whether the data fit at all."""
SMALL = 1000
"""Data times features up to which it is looked with a wide tolerance, if not thoroughly."""
FOCAL = (0.33, 0.6, 1.7, 3.0)
"""Focal lengths that are tried, as multiples of the stated one."""


class Case(NamedTuple):
    """A hypothesis that was accepted under a change, and what was given: the type as it is, Γ as it was searched."""

    found: Hypothesis
    kind: ObjectType
    kb: KnowledgeBase
    gamma: Gamma


class Change(NamedTuple):
    """One thing otherwise; ``told`` says of what is found so what is amiss, '' where it is something else."""

    kb: Callable[[KnowledgeBase], KnowledgeBase]
    gamma: Callable[[Gamma], Gamma]
    told: Callable[[Case], str]


def causes(
    kinds: Sequence[ObjectType], kb: KnowledgeBase, gamma: Gamma, dv: Mapping[str, float], *, thorough: bool
) -> Iterator[tuple[ObjectType, str]]:
    """Each type that is found under some change, with what that tells: the one that explains the most data.

    ``thorough``: however long it takes to look with a wide tolerance.
    """
    left = [kind for kind in kinds if kind.learned is None]
    data = len(gamma.appearances)
    best: dict[str, tuple[float, str]] = {}
    for change in CHANGES:
        open_ones = [kind for kind in left if best.get(kind.name, NOTHING)[0] < inf]
        if change.kb is _looser and not thorough:
            open_ones = [kind for kind in open_ones if data * len(kind.seen_features) <= SMALL]
        if not open_ones:
            break
        seen = change.gamma(gamma)
        for found in found_if(change.kb(replace(kb, types=tuple(open_ones))), seen, dv):
            if not _convincing(found, change):
                continue
            kind = next(kind for kind in open_ones if kind.name == found.type)
            told = change.told(Case(found, kind, kb, seen))
            if told and found.worth > best.get(kind.name, NOTHING)[0] + MARGIN:
                best[kind.name] = (inf if _settles(found, change) else found.worth), told
    yield from ((kind, best[kind.name][1]) for kind in left if kind.name in best)


def _number(h: Hypothesis) -> int:
    """Expected features that are detected."""
    return int((h.expected(h.hidden) & h.detected).sum())


def _settles(h: Hypothesis, change: Change) -> bool:
    """Whether nothing else needs to be tried: so much of it is there, as near as it should be, that it is no chance."""
    return change.kb is not _looser and _number(h) >= max(SURE, SURELY * int(h.expected(h.hidden).sum()))


def found_if(kb: KnowledgeBase, gamma: Gamma, dv: Mapping[str, float]) -> list[Hypothesis]:
    """What is accepted of a changed Γ by a changed knowledge base, the heaviest first."""
    models = models_of(kb, dv)
    width = kb.words.centroids.shape[1] if kb.words is not None else 128
    data = data_of(gamma.in_order().appearances, gamma.camera, width)
    cycle = perceive(Task(data, kb, models, dv), attend(models.values(), data.types, kb))
    return sorted(cycle.accepted, key=lambda h: -h.worth)


def _convincing(h: Hypothesis, change: Change) -> bool:
    least, share = CONVINCING_LOOSE if change.kb is _looser else CONVINCING
    return _number(h) >= max(least, share * int(h.expected(h.hidden).sum()))


# -- the knowledge base otherwise --------------------------------------------------------------------------------------


def _lobes(change: Callable[[Lobe], Lobe]) -> Callable[[KnowledgeBase], KnowledgeBase]:
    """The knowledge base with every lobe of its types changed."""

    def feature(one: Feature) -> Feature:
        return replace(one, appearances=tuple(replace(a, lobe=change(a.lobe)) for a in one.appearances))

    def changed(kb: KnowledgeBase) -> KnowledgeBase:
        types = (
            replace(
                kind,
                features=tuple(map(feature, kind.features)),
                all_features=tuple(map(feature, kind.all_features)),
            )
            for kind in kb.types
        )
        return replace(kb, types=tuple(types))

    return changed


def _looser(kb: KnowledgeBase) -> KnowledgeBase:
    rates = kb.rates
    sigmas = {name: LOOSER * sigma for name, sigma in rates.sigmas.items()}
    tolerance = LOOSER * max(rates.match_tolerance, 3.0 * rates.sigma)
    wide = replace(rates, match_tolerance=tolerance, sigma=LOOSER * rates.sigma, sigmas=sigmas)
    return replace(kb, rates=wide)


def _without_angles(kb: KnowledgeBase) -> KnowledgeBase:
    return replace(kb, rates=replace(kb.rates, sigma_angle=None))


def _same_kb(kb: KnowledgeBase) -> KnowledgeBase:
    return kb


# -- Γ otherwise -------------------------------------------------------------------------------------------------------


def _same(gamma: Gamma) -> Gamma:
    return gamma


def _each(gamma: Gamma, change: Callable[[Appearance], Appearance]) -> Gamma:
    return replace(gamma, appearances=tuple(map(change, gamma.appearances)))


def _mirrored(gamma: Gamma) -> Gamma:
    """Left and right exchanged. Up and down, or u and v, exchanged are this and a turn."""
    camera, last = gamma.camera, gamma.camera.width - 1.0
    K = camera.K.copy()
    K[0, 2] = last - K[0, 2]
    turned = _each(
        gamma,
        lambda a: replace(a, uv=(last - a.uv[0], a.uv[1]), angle=None if a.angle is None else pi - a.angle, arms=()),
    )
    return replace(turned, camera=replace(camera, K=K))


def _longer(factor: float) -> Callable[[Gamma], Gamma]:
    def changed(gamma: Gamma) -> Gamma:
        K = gamma.camera.K.copy()
        K[0, 0], K[1, 1] = factor * K[0, 0], factor * K[1, 1]
        return replace(gamma, camera=replace(gamma.camera, K=K))

    return changed


# -- what is told ------------------------------------------------------------------------------------------------------


def _out_of_range(case: Case) -> str:
    """``12 of 14 corners are farther than their range: 2.6 m, range 2 m``."""
    h, table = case.found, case.kind.lobes
    granularity = case.gamma.camera.f / case.kb.f_ref
    away, matched = np.linalg.norm(h.at, axis=1), h.detected & h.in_lobe
    farthest, nearest = np.zeros(table.features), np.full(table.features, np.inf)
    np.maximum.at(farthest, table.feature, table.r_max * granularity)
    np.minimum.at(nearest, table.feature, table.r_min * granularity)
    far, near = matched & (away > farthest), matched & (away < nearest)
    out, word, bound = (far, "farther", farthest) if far.sum() >= near.sum() else (near, "nearer", nearest)
    if not out.any() or 2 * int(out.sum()) < int(matched.sum()):
        return ""
    sort, number = Counter(f.type for f, o in zip(case.kind.seen_features, out, strict=True) if o).most_common(1)[0]
    of_sort = np.array([f.type == sort for f in case.kind.seen_features])
    some = out & of_sort
    limit = f"range {'' if word == 'farther' else 'from '}{_metres(float(np.median(bound[some])))}"
    place = _metres(float(np.median(away[some])))
    lens = (
        ""
        if abs(granularity - 1.0) < 0.01
        else f" at this focal length ({case.gamma.camera.f:.0f} px, f_ref {case.kb.f_ref:g})"
    )
    what = f"{number} of {int((matched & of_sort).sum())} {plural(sort)} are {word} than their range: {place}, {limit}{lens}"
    return f"{what}; widen range in object.yaml, or is the type's unit wrong?"


def _off_axis(case: Case) -> str:
    """``4 of 5 stickers are seen from outside of their lobes``."""
    h, table = case.found, case.kind.lobes
    viewer = np.linalg.inv(h.camera_from_object)[:3, 3]
    sight = viewer - table.at
    cosine = np.einsum("li,li->l", sight, table.axis) / np.maximum(np.linalg.norm(sight, axis=1), 1e-12)
    off = np.arccos(np.clip(cosine, -1.0, 1.0)) - np.arccos(np.clip(table.cos_half, -1.0, 1.0))
    least = np.full(table.features, np.inf)
    np.minimum.at(least, table.feature, off)
    matched = h.detected & h.in_lobe
    out = matched & (least > 1e-6)
    if not out.any() or 2 * int(out.sum()) < int(matched.sum()):
        return ""
    sort, number = Counter(f.type for f, o in zip(case.kind.seen_features, out, strict=True) if o).most_common(1)[0]
    of_sort = np.array([f.type == sort for f in case.kind.seen_features])
    degrees = float(np.degrees(np.median(least[out & of_sort])))
    many = int((matched & of_sort).sum())
    what = f"{number} of {many} {plural(sort)} are seen from outside of their lobes, by {degrees:.0f} deg"
    return f"{what}; turn their axis towards such viewers, or widen half_angle"


def _beyond_tolerance(case: Case) -> str:
    residual = case.found.residual[case.found.detected & np.isfinite(case.found.residual)]
    worst, tolerance = float(np.quantile(residual, 0.9)), case.kb.rates.match_tolerance
    if worst <= tolerance:
        return ""
    what = f"its data fit within {worst:.1f} pixels only, and match_tolerance is {tolerance:g}"
    return f"{what}: are K and dist this camera's, and the type's measures right? Else raise match_tolerance and sigma in kb.yaml"


def _by_angles(case: Case) -> str:
    if case.kb.rates.sigma_angle is None:
        return ""  # they counted for nothing anyway
    return (
        "it is found where the angles of the data are left out: an angle is how the x axis of its feature's frame lies on the "
        "screen, in radians, clockwise from +x; without sigma_angle in kb.yaml angles say nothing"
    )


def _by_mirror(_: Case) -> str:
    return (
        "it is found in the mirror image of the data: is the picture mirrored, v counted from below, or u exchanged for v? "
        "Or are the type's places those of its mirror image?"
    )


def _by_focal(factor: float) -> Callable[[Case], str]:
    def told(case: Case) -> str:
        stated = case.gamma.camera.f / factor
        return (
            f"it is found with a focal length of about {case.gamma.camera.f:.0f} pixels, and the camera states {stated:.0f}: "
            "is K this picture's, at this size?"
        )

    return told


CHANGES = (
    Change(_lobes(lambda lobe: replace(lobe, r_min=0.0, r_max=1e6)), _same, _out_of_range),
    Change(_lobes(lambda lobe: replace(lobe, half_angle=pi)), _same, _off_axis),
    Change(_without_angles, _same, _by_angles),
    Change(_same_kb, _mirrored, _by_mirror),
    Change(_looser, _same, _beyond_tolerance),
    *(Change(_looser, _longer(factor), _by_focal(factor)) for factor in FOCAL),
)
"""In the order in which they are tried."""


def plural(word: str) -> str:
    """More than one of a feature type, by the usual rule of English."""
    return f"{word}es" if word.endswith(("s", "x", "z", "ch", "sh")) else f"{word}s"


def _metres(length: float) -> str:
    return f"{length:.2g} m" if length < 10.0 else f"{length:.0f} m"


def camera_doubt(camera: Camera) -> str:
    """What of a camera is no picture's, '' where nothing is."""
    (fx, _, cx), (_, fy, cy) = camera.K[0], camera.K[1]
    if not (0.0 <= cx < camera.width and 0.0 <= cy < camera.height):
        return f"the camera's principal point ({cx:g}, {cy:g}) is outside of its image of {camera.width}x{camera.height}: is K of another size?"
    if not 0.5 < fx / fy < 2.0:
        return f"the camera's focal lengths differ by more than a half: fx {fx:g}, fy {fy:g} pixels: is K written row by row?"
    if not 0.1 < camera.f / max(camera.width, camera.height) < 50.0:
        return f"the camera's focal length of {camera.f:g} pixels fits no lens before an image of {camera.width}x{camera.height}: is it in mm?"
    return ""
