"""Pairs of which one pose is withheld, for ``plogic bench occlusion``: what detections alone say of how they stand.

Two objects of ten types, five convex, the others concave or a rod, remembered where they truly stand but for 0.3
degrees and 0.2 % of their size (Δp), are looked at in one Γ with misses and clutter by the normal matching (D7, D8).
Then the pose of the first is withheld, and the distribution over ROC-20 (``plogic.sequence.unposed``) is compared with
the true relation. Poses are drawn as the prior has them, so that probabilities can be right.

* ``Withheld``: one pair, ``Withheld("partially_occludes", {"partially_occludes": 0.97, ...}, hidden=7, ...)``
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from benchmarks.calibration.reliability import expected_calibration_error, reliability
from benchmarks.clutter.scenes import CAMERA, random_pose, surface_of
from benchmarks.clutter.types import (
    HALF_ANGLE,
    Detector,
    body_frames,
    knowledge_base,
    made,
    random_types,
    scattered,
    type_names,
)
from benchmarks.many.placing import Placed, meet
from benchmarks.many.scenes import scene_of
from benchmarks.occlusion.bodies import concave_bodies, prism
from benchmarks.shared.claims import Claim
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw, transform_points
from geometry.visibility.occlusion import PosedSurface, occlusion
from geometry.visibility.roc import COARSE, coarse
from kb.surfaces.surface import Surface
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.cycle.state import Cycle, Trace
from plogic.match.gamma.data import data_of
from plogic.match.judged.evidence import judged
from plogic.match.judged.rivals import claims, hidden_among
from plogic.run.perceive import Perceiver
from plogic.sequence.unposed.reading import evidence

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from geometry.visibility.roc import CoarseRelation
    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.facts.document import Interpretation
    from plogic.facts.hypothesis import Hypothesis

    Floats = NDArray[np.float64]
    Objects = list[Placed]
    Maker = Callable[[KnowledgeBase, np.random.Generator], Objects]

WITHHELD, QUICK_WITHHELD = 300, 8
AIMED, QUICK_AIMED = 60, 4
DETECTOR = Detector("withheld", 0.9, 1.0, float(np.radians(3.0)))
"""One in ten features is missed."""
FEATURES, LOOKS, CLUTTER = 40, 20, 60
"""Features a type, appearance types in all, and data of clutter that the knowledge base is told an image has."""
SCALE = 0.15
"""Of the concave bodies, which are some 1.4 across: to 0.2 m."""
REMEMBERED = float(np.radians(0.3)), 0.002
"""Radians, and share of the diameter, by which a remembered pose is off, standard deviations an axis."""
CHANGED, BINS = 3, 10
"""Cells that hiding changes in pairs of which the relation should be told; bins of the first relations."""
NO_DEPTH = np.zeros((0, 0))
"""Depths of pixels, which nobody asks for here."""


@dataclass(frozen=True)
class Withheld:
    """``told``: the coarse relations' probabilities; ``hidden``: cells of either that the other's hiding changes."""

    true: CoarseRelation
    told: dict[CoarseRelation, float]
    hidden: int
    seconds: float

    @property
    def first(self) -> CoarseRelation:
        """The most probable relation."""
        return max(self.told, key=lambda name: self.told[name])

    @property
    def right(self) -> bool:
        """Whether that is the true one."""
        return self.first == self.true


def withheld_pairs(count: int, seed: int, say: Callable[[str], None]) -> list[Withheld]:
    """The pairs of a seed, drawn as the prior has them."""
    return _pairs(count, [pair], [seed, 39], say)


def aimed_pairs(count: int, seed: int, say: Callable[[str], None]) -> list[Withheld]:
    """Pairs whose relations are rare among these, half of either making."""
    return _pairs(count, [aimed, interlocked], [seed, 40], say)


def _pairs(count: int, makers: Sequence[Maker], seeds: list[int], say: Callable[[str], None]) -> list[Withheld]:
    """So many pairs; where remembered poses share volume (A4) there is no relation, and another is drawn."""
    perceiver, found = Perceiver(types(seeds[0])), list[Withheld]()
    i = 0
    while len(found) < count:
        rng, i = np.random.default_rng([*seeds, i]), i + 1
        objects = makers[i % len(makers)](perceiver.kb, rng)
        one = _judged(perceiver, objects if rng.random() < 0.5 else objects[::-1], rng)
        found += [] if one is None else [one]
        if i % 50 == 0:
            say(f"withheld: {len(found)} pairs")
    return found


@cache
def types(seed: int) -> KnowledgeBase:
    """Five random convex types, and an L, a U, a hook, a ring and a rod."""
    rng = np.random.default_rng([seed, 39])
    convex = random_types(5, FEATURES, LOOKS, rng, DETECTOR, CLUTTER).types
    rod = prism(shapely.box(-0.08, -1.2, 0.08, 1.2), 0.16)
    bodies = [*concave_bodies()[:4], rod]
    concave = [_type(f"c{i}", one.vertices, one.triangles, rng) for i, one in enumerate(bodies)]
    return knowledge_base([*convex, *concave], type_names(LOOKS), DETECTOR, CLUTTER)


def _type(name: str, vertices: Floats, triangles: NDArray[np.int64], rng: np.random.Generator) -> ObjectType:
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
    surface = Surface((vertices - middle) * SCALE, triangles)
    at, normal = scattered(surface, FEATURES, rng)
    looks = [type_names(LOOKS)[k] for k in rng.integers(LOOKS, size=FEATURES)]
    return made(name, surface, at, body_frames(normal, rng), looks, np.full(FEATURES, HALF_ANGLE))


def _judged(perceiver: Perceiver, objects: Objects, rng: np.random.Generator) -> Withheld | None:
    document = remembered(perceiver, objects, rng)
    start = time.process_time()
    fact = evidence(document, ["h1"])
    spent = time.process_time() - start
    if not fact.pairs:
        return None
    told: dict[CoarseRelation, float] = dict.fromkeys(COARSE, 0.0)
    for share, (relation,) in fact.states:
        told[coarse(relation)] = min(told[coarse(relation)] + share, 1.0)
    hidden = sum(
        bool(f["hidden_by"]) and f["in_image"] and f["in_lobe"] and not f["self_hidden"]
        for h in document["hypotheses"]
        for f in h["features"]
    )
    x, y = (_posed(one) for one in objects)
    return Withheld(coarse(occlusion(x, y, CAMERA)), told, hidden, spent)


def _posed(one: Placed) -> PosedSurface:
    surface = surface_of(one.kind)
    return PosedSurface(surface.vertices, surface.triangles, surface.rays, one.pose)


def pair(kb: KnowledgeBase, rng: np.random.Generator) -> Objects:
    """Two objects that share no volume.

    The one is wholly in the image, of any size; the other's middle is anywhere in it, even in log depth up to e times
    nearer or farther, in any rotation.
    """
    while True:
        first, second = (kb.types[int(i)] for i in rng.integers(len(kb.types), size=2))
        pose = random_pose(first, rng)
        depth = float(_middle(first, pose)[2]) * np.exp(rng.uniform(-1.0, 1.0))
        ray = CAMERA.rays(rng.uniform(-0.5, [CAMERA.width - 0.5, CAMERA.height - 0.5]))
        R = rotation_from_quat_xyzw(rng.normal(size=4))
        other = from_rotation_translation(R, ray / ray[2] * depth - R @ surface_of(second).centre)
        in_front = depth > surface_of(second).diameter
        if in_front and not meet(first, pose, second, other):
            return [Placed(first, pose, NO_DEPTH), Placed(second, other, NO_DEPTH)]


def aimed(kb: KnowledgeBase, rng: np.random.Generator) -> Objects:
    """One on the line of sight to a corner of the other, before or behind it."""
    while True:
        first, second = (kb.types[int(i)] for i in rng.integers(len(kb.types), size=2))
        pose, R = random_pose(first, rng), rotation_from_quat_xyzw(rng.normal(size=4))
        corner = transform_points(pose, surface_of(first).vertices)[int(rng.integers(len(surface_of(first).vertices)))]
        middle = corner * np.exp(rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 0.9))
        other = from_rotation_translation(R, middle - R @ surface_of(second).centre)
        if middle[2] > surface_of(second).diameter and not meet(first, pose, second, other):
            return [Placed(first, pose, NO_DEPTH), Placed(second, other, NO_DEPTH)]


def interlocked(kb: KnowledgeBase, rng: np.random.Generator) -> Objects:
    """A rod through the hollow of a U, a hook or a ring."""
    while True:
        frame, rod = kb.types[int(rng.integers(6, 9))], kb.types[9]
        pose = random_pose(frame, rng)
        lean = rotation_from_quat_xyzw(np.r_[rng.normal(0.0, 0.15, 3), 1.0])
        upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        at = SCALE * rng.uniform([-0.25, -0.25, -0.6], [0.25, 0.25, 0.6])
        other = pose @ from_rotation_translation(lean @ upright, at)
        if not meet(frame, pose, rod, other):
            return [Placed(frame, pose, NO_DEPTH), Placed(rod, other, NO_DEPTH)]


def _middle(kind: ObjectType, pose: Floats) -> Floats:
    return transform_points(pose, surface_of(kind).centre[None])[0]


def remembered(perceiver: Perceiver, objects: Objects, rng: np.random.Generator) -> Interpretation:
    """The interpretation of one Γ in which the objects are looked at where they are remembered, h1 and h2."""
    gamma = scene_of(perceiver.kb, objects, rng, DETECTOR).gamma
    data = data_of(gamma.in_order().appearances, gamma.camera)
    poses = [_off(one, rng) for one in objects]
    alone = [_looked(perceiver, one, pose, data, []) for one, pose in zip(objects, poses, strict=True)]
    first = int(alone[1].worth > alone[0].worth)
    other = _looked(perceiver, objects[1 - first], poses[1 - first], data, [alone[first]])
    both = (alone[0], other) if first == 0 else (other, alone[1])
    accepted = tuple(h.told(status="accepted", why="remembered") for h in both)
    return perceiver.document(gamma, data, Cycle(accepted, (), (), (), Trace()), Options(), None, Stopwatch())


def _looked(perceiver: Perceiver, one: Placed, pose: Floats, data: Any, beside: list[Hypothesis]) -> Hypothesis:  # noqa: ANN401
    model, free = perceiver.models[one.kind.name], np.ones(len(data.ids), bool)
    for other in beside:
        free[list(claims(other))] = False
    there = model.settle(pose, data, perceiver.kb, free=free, rounds=0)
    hidden = hidden_among(there, beside)
    there = model.settle(pose, data, perceiver.kb, free=free, hidden=hidden)
    return judged(there, data, perceiver.kb, perceiver.dv, hidden)


def _off(one: Placed, rng: np.random.Generator) -> Floats:
    turn, shift = REMEMBERED
    centre, diameter = surface_of(one.kind).centre, surface_of(one.kind).diameter
    R = rotation_from_quat_xyzw(np.r_[rng.normal(0.0, turn / 2.0, 3), 1.0]) @ one.pose[:3, :3]
    middle = transform_points(one.pose, centre[None])[0] + rng.normal(0.0, shift * diameter, 3)
    return from_rotation_translation(R, middle - R @ centre)


def withheld_rows(found: Sequence[Withheld]) -> list[dict[str, Any]]:
    """By the true relation: pairs, how many are told right, the same where hiding changes cells, and its mean share."""
    return [
        {
            "relation": name,
            "pairs": len(some),
            "first": sum(one.right for one in some),
            f"{CHANGED} cells": sum(one.hidden >= CHANGED for one in some),
            "first of them": sum(one.right for one in some if one.hidden >= CHANGED),
            "mean share": round(float(np.mean([one.told[name] for one in some])), 3) if some else "",
        }
        for name in COARSE
        for some in [[one for one in found if one.true == name]]
    ]


def every_forecast(found: Sequence[Withheld]) -> tuple[list[float], list[bool]]:
    """The probability of each coarse relation of each pair, and whether it holds."""
    return [one.told[name] for one in found for name in COARSE], [one.true == name for one in found for name in COARSE]


def first_forecasts(found: Sequence[Withheld]) -> tuple[list[float], list[bool]]:
    """The probability of each pair's most probable relation, and whether it holds."""
    return [one.told[one.first] for one in found], [one.right for one in found]


def reliability_rows(found: Sequence[Withheld]) -> list[dict[str, Any]]:
    """Of the most probable relations: what they were given, and how often they held."""
    return [
        {
            "from": round(b.low, 3),
            "to": round(b.high, 3),
            "forecast": round(b.forecast, 3),
            "true": round(b.true, 3),
            "pairs": b.count,
        }
        for b in reliability(*first_forecasts(found), BINS)
    ]


def withheld_figures(found: Sequence[Withheld]) -> dict[str, Any]:
    """What is beside the claims: the ECE of the first relations, what chance alone would make it, and the time."""
    p, y = first_forecasts(found)
    rng = np.random.default_rng(0)
    chance = [expected_calibration_error(p, rng.random(len(p)) < np.array(p), BINS) for _ in range(200)]
    spent = [one.seconds for one in found]
    return {
        "ECE of the first": round(expected_calibration_error(p, y, BINS), 3),
        "of it by chance": round(float(np.mean(chance)), 3),
        "s a pair, median": round(float(np.median(spent)), 2),
        "s, 95 %": round(float(np.quantile(spent, 0.95)), 2),
    }


def withheld_claims(found: Sequence[Withheld]) -> list[Claim]:
    """What was promised."""
    changed = [one.right for one in found if one.hidden >= CHANGED]
    told = f"withheld: right relation first, of the {len(changed)} pairs in which hiding changes {CHANGED} cells"
    return [
        Claim(told, ">=", 0.9, sum(changed) / max(len(changed), 1)),
        Claim(
            "withheld: ECE over all pairs and relations", "<=", 0.05, expected_calibration_error(*every_forecast(found))
        ),
        Claim(
            "withheld: ECE of the most probable relation",
            "<=",
            0.05,
            expected_calibration_error(*first_forecasts(found), BINS),
        ),
    ]
