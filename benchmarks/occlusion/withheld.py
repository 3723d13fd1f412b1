"""Pairs of which one pose is withheld, for ``plogic bench occlusion``: what detections alone say of how they stand.

Two objects of ten types, five convex and five concave with a rod among them, remembered where they truly stand but for
0.3 degrees and 0.2 % of their size (Δp), are looked at in one Γ with misses and clutter by the normal matching (D7, D8).
Then the pose of the first is withheld, and the distribution over ROC-20 (``plogic.sequence.unposed``) is compared with
the true relation.

* ``Withheld``: one pair, ``Withheld("aimed", "partially_occludes", {"partially_occludes": 0.97, ...}, hidden=7)``
"""

from __future__ import annotations

import time
from collections import Counter
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
from plogic.sequence.unposed.reading import target_of
from plogic.sequence.unposed.relations import states as states_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from geometry.visibility.roc import CoarseRelation
    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.facts.document import Interpretation
    from plogic.facts.hypothesis import Hypothesis

    Floats = NDArray[np.float64]
    Objects = list[Placed]

WITHHELD, QUICK_WITHHELD = 300, 8
import os
DETECTOR = Detector("withheld", float(os.environ.get("HIT","0.8")), 1.0, float(np.radians(3.0)))
"""Two in ten features are missed."""
FEATURES, LOOKS, CLUTTER = int(os.environ.get("FEAT","40")), 20, 60
"""Features a type, appearance types in all, and data of clutter that the knowledge base is told an image has."""
SCALE = 0.15
"""Of the concave bodies, which are some 1.4 across: to 0.2 m."""
REMEMBERED = float(np.radians(0.3)), 0.002
"""Radians, and share of the diameter, by which a remembered pose is off, standard deviations an axis."""
CHANGED = 3
"""Cells that hiding changes in pairs of which the relation should be told."""
TRIES = 60
KINDS = ("anywhere",)


@dataclass(frozen=True)
class Withheld:
    """``told``: the coarse relations' probabilities; ``hidden``: cells of either that the other's hiding changes."""

    kind: str
    true: CoarseRelation
    told: dict[CoarseRelation, float]
    hidden: int
    seconds: float

    @property
    def first(self) -> CoarseRelation:
        """The most probable relation."""
        return max(self.told, key=lambda name: self.told[name])


def withheld_pairs(count: int, seed: int, say: Callable[[str], None]) -> list[Withheld]:
    """The pairs of a seed, the kinds in turn."""
    kb = types(seed)
    perceiver = Perceiver(kb)
    found = []
    for i in range(count):
        found.append(_judged(perceiver, KINDS[i % len(KINDS)], np.random.default_rng([seed, i, 39])))
        if (i + 1) % 50 == 0:
            say(f"withheld: {i + 1} pairs")
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


def _judged(perceiver: Perceiver, kind: str, rng: np.random.Generator) -> Withheld:
    objects = pair(perceiver.kb, kind, rng)
    document = remembered(perceiver, objects, rng)
    start = time.process_time()
    states = states_of(target_of(document, "h1", ("h2",)))
    spent = time.process_time() - start
    told: Counter[CoarseRelation] = Counter(dict.fromkeys(COARSE, 0.0))
    for (relation,), share in states.items():
        told[coarse(relation)] += share
    hidden = sum(
        bool(f["hidden_by"]) and f["in_image"] and f["in_lobe"] and not f["self_hidden"]
        for h in document["hypotheses"]
        for f in h["features"]
    )
    x, y = (_posed(one) for one in objects)
    return Withheld(kind, coarse(occlusion(x, y, CAMERA)), dict(told), hidden, spent)


def _posed(one: Placed) -> PosedSurface:
    surface = surface_of(one.kind)
    return PosedSurface(surface.vertices, surface.triangles, surface.rays, one.pose)


def pair(kb: KnowledgeBase, kind: str, rng: np.random.Generator) -> Objects:
    """Two objects that share no volume, in random order.

    Anywhere in the image; or the one on the line of sight to a place of the other, before or behind it; or a rod through
    the hollow of a U, a hook or a ring.
    """
    while True:
        first, second = (kb.types[int(i)] for i in rng.integers(len(kb.types), size=2))
        if kind == "interlocking":
            first, second = kb.types[int(rng.integers(6, 9))], kb.types[9]
        pose = random_pose(first, rng)
        for _ in range(TRIES):
            other = {"anywhere": _anywhere, "aimed": _aimed, "interlocking": _through}[kind](first, pose, second, rng)
            if not meet(first, pose, second, other) and bool(CAMERA.contains(CAMERA.project(_middle(second, other)))[0]):
                two = [Placed(first, pose, np.zeros((0, 0))), Placed(second, other, np.zeros((0, 0)))]
                return two if rng.random() < 0.5 else two[::-1]


def _middle(kind: ObjectType, pose: Floats) -> Floats:
    return transform_points(pose, surface_of(kind).centre[None])


def _anywhere(kind: ObjectType, pose: Floats, other: ObjectType, rng: np.random.Generator) -> Floats:
    depth = float(_middle(kind, pose)[0, 2]) * np.exp(rng.uniform(-1.0, 1.0))
    ray = CAMERA.rays(rng.uniform(-0.5, [CAMERA.width - 0.5, CAMERA.height - 0.5]))
    R = rotation_from_quat_xyzw(rng.normal(size=4))
    return from_rotation_translation(R, ray / ray[2] * depth - R @ surface_of(other).centre)


def _aimed(kind: ObjectType, pose: Floats, other: ObjectType, rng: np.random.Generator) -> Floats:
    vertices = surface_of(kind).vertices
    aim = transform_points(pose, vertices[int(rng.integers(len(vertices)))][None])[0]
    R = rotation_from_quat_xyzw(rng.normal(size=4))
    return from_rotation_translation(R, aim * np.exp(rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.7)) - R @ surface_of(other).centre)


def _through(kind: ObjectType, pose: Floats, other: ObjectType, rng: np.random.Generator) -> Floats:
    lean = rotation_from_quat_xyzw(np.r_[rng.normal(0.0, 0.15, 3), 1.0])
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    at = [*(SCALE * rng.uniform(-0.25, 0.25, 2)), SCALE * rng.uniform(-0.6, 0.6)]
    return np.asarray(pose @ from_rotation_translation(lean @ upright, at))


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
    """By the true relation: how many pairs, how often it is first, the same where hiding changes cells, and its share."""
    rows = []
    for name in COARSE:
        some = [one for one in found if one.true == name]
        changed = [one for one in some if one.hidden >= CHANGED]
        rows.append({
            "relation": name,
            "pairs": len(some),
            "first": sum(one.first == name for one in some),
            f"{CHANGED} cells": len(changed),
            "first of them": sum(one.first == name for one in changed),
            "mean P": round(float(np.mean([one.told[name] for one in some])), 3) if some else "",
        })  # fmt: skip
    return rows


def forecasts(found: Sequence[Withheld]) -> tuple[list[float], list[bool]]:
    """The probability of each coarse relation of each pair, and whether it holds."""
    return [one.told[name] for one in found for name in COARSE], [one.true == name for one in found for name in COARSE]


def top_forecasts(found: Sequence[Withheld]) -> tuple[list[float], list[bool]]:
    """The probability of the most probable relation, and whether it holds."""
    return [min(one.told[one.first], 1.0) for one in found], [one.first == one.true for one in found]


def reliability_rows(found: Sequence[Withheld], bins: int = 10) -> list[dict[str, Any]]:
    """Of the most probable relations: what they were given, and how often they held."""
    return [
        {"from": round(b.low, 3), "to": round(b.high, 3), "forecast": round(b.forecast, 3), "true": round(b.true, 3), "pairs": b.count}
        for b in reliability(*top_forecasts(found), bins)
    ]  # fmt: skip


def withheld_claims(found: Sequence[Withheld]) -> list[Claim]:
    """What was promised."""
    changed = [one for one in found if one.hidden >= CHANGED]
    return [
        Claim(f"withheld: the right relation is first where hiding changes {CHANGED} cells", ">=", 0.9, sum(one.first == one.true for one in changed) / max(len(changed), 1)),
        Claim("withheld: ECE of the most probable relation", "<=", 0.05, expected_calibration_error(*top_forecasts(found), 10)),
        Claim("withheld: ECE of all relations", "<=", 0.05, expected_calibration_error(*(np.clip(forecasts(found)[0], 0, 1), forecasts(found)[1]), 15)),
    ]  # fmt: skip
