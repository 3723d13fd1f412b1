"""The scenes of ``plogic bench calibration``.

Bodies that look alike, seen by a poor detector in clutter, partly one behind another.

* ``World``: the types, and how well they are really seen, which perception is not told: it learns it from training
  scenes
* ``CalibrationScene``: one Γ, and what stands where

Types come in families: siblings have one body and share the looks of most features, so that often few data tell which
of them stands there. Each look is reported with a hit rate of its own, and clutter has a density of its own for each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.scenes import CAMERA, random_pose, surface_of, visible
from benchmarks.clutter.types import HALF_ANGLE, SLACK, Detector, knowledge_base, made, random_types
from benchmarks.many.placing import meet
from geometry.frames import transform_points
from geometry.visibility.rays import behind
from plogic.match.gamma.grid import screen_angle
from plogic.rates.scene_records import TrueObject, Truth
from sensing.appearance import Appearance, Gamma

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]
    Placed = tuple[ObjectType, Floats]
    Reports = tuple[Floats, NDArray[np.intp], Floats]  # places (N, 2), looks (N,) and angles (N,)

FAMILIES, SIBLINGS, FEATURES, LOOKS = 4, 3, 60, 20
"""Bodies, types of one body, features a type, appearance types in all."""
OWN = 0.12
"""Share of its features that a sibling redraws the looks of."""
DETECTOR = Detector("poor", 0.5, 1.0, float(np.radians(8.0)))
"""What perception is told before it has learned: half of what is in view is reported, one pixel and eight degrees
off."""
HIT = 0.2, 0.7
"""Least and greatest true hit rate of a look."""
CLUTTER = 300.0
"""Data of clutter an image, on the average."""
OBJECTS = 0, 4
"""Least and most objects a scene."""
TRIES = 200
"""Poses that are tried for an object that must not share volume with others."""
SCENES = 50_021
"""A number of these scenes' own, so that no other benchmark's seed gives the same draws."""


@dataclass(frozen=True, eq=False)
class World:
    """``kb``: Σ as perception has it before learning.

    ``hit`` and ``clutter`` (L,) the true rates of its looks, in their order.
    """

    kb: KnowledgeBase
    hit: Floats
    clutter: Floats


@dataclass(frozen=True, eq=False)
class CalibrationScene:
    """One Γ, and all that stands there."""

    gamma: Gamma
    truth: Truth


def random_world(seed: int) -> World:
    """Families of look-alikes, and how well their looks are seen."""
    rng = np.random.default_rng([seed, FAMILIES, SIBLINGS])
    bodies = random_types(FAMILIES, FEATURES, LOOKS, rng, DETECTOR, round(CLUTTER))
    types = [kind for body in bodies.types for kind in _family(body, bodies.appearance_types, rng)]
    hit, share = rng.uniform(*HIT, LOOKS), rng.gamma(2.0, 1.0, LOOKS)
    return World(
        knowledge_base(types, bodies.appearance_types, DETECTOR, round(CLUTTER)), hit, CLUTTER * share / share.sum()
    )


def _family(body: ObjectType, names: Sequence[str], rng: np.random.Generator) -> list[ObjectType]:
    """Types of one body, each of which has drawn the looks of some of its features anew."""
    at, frames = np.array([f.at for f in body.features]), np.array([f.rotation for f in body.features])
    kinds = []
    for sibling in range(SIBLINGS):
        own, anew = rng.random(FEATURES) < OWN, rng.integers(len(names), size=FEATURES)
        looks = [names[anew[i]] if own[i] else body.lobes.types[i] for i in range(FEATURES)]
        kinds.append(made(f"{body.name}_{sibling}", body.surface, at, frames, looks, np.full(FEATURES, HALF_ANGLE)))
    return kinds


def scene(world: World, seed: int) -> CalibrationScene:
    """The scene of a seed: objects that share no volume, their detected features, and clutter, in random order."""
    rng = np.random.default_rng([seed, SCENES])
    placed = _placed(world.kb, rng)
    shown = [in_view(world.kb, one, placed) for one in placed]
    parts = [_reported(one, there, world, rng) for one, (there, _) in zip(placed, shown, strict=True)] + [
        _noise(world, rng)
    ]
    uv, looks, angle = (np.concatenate([part[i] for part in parts]) for i in range(3))
    inside, names = CAMERA.contains(uv), world.kb.appearance_types
    order = [i for i in rng.permutation(len(uv)) if inside[i]]
    data = tuple(
        Appearance(f"d{n}", names[looks[i]], (float(uv[i, 0]), float(uv[i, 1])), "simulated", angle=float(angle[i]))
        for n, i in enumerate(order)
    )
    objects = [TrueObject(kind.name, pose, share) for (kind, pose), (_, share) in zip(placed, shown, strict=True)]
    return CalibrationScene(Gamma(CAMERA, data), Truth(tuple(objects), complete=True))


def _placed(kb: KnowledgeBase, rng: np.random.Generator) -> list[Placed]:
    placed: list[Placed] = []
    for _ in range(int(rng.integers(OBJECTS[0], OBJECTS[1] + 1))):
        kind = kb.types[int(rng.integers(len(kb.types)))]
        for _ in range(TRIES):
            pose = random_pose(kind, rng)
            if not any(meet(kind, pose, *other) for other in placed):
                placed.append((kind, pose))
                break
    return placed


def in_view(kb: KnowledgeBase, one: Placed, placed: Sequence[Placed]) -> tuple[Flags, float]:
    """(F,) the features that the camera sees of one object among others, and their share of those seen of it alone."""
    kind, pose = one
    alone, at = visible(kind, pose, kb.f_ref), transform_points(pose, kind.lobes.at)
    hidden = np.zeros(len(at), bool)
    for other in placed:
        if other is not one:
            surface = surface_of(other[0])
            hidden |= behind(at, surface.rays, other[1], SLACK * surface.diameter)
    return alone & ~hidden, float((alone & ~hidden).sum() / max(alone.sum(), 1))


def _reported(one: Placed, there: Flags, world: World, rng: np.random.Generator) -> Reports:
    """What the detector reports of an object of which these features (F,) are to be seen."""
    kind, pose = one
    code = {name: i for i, name in enumerate(world.kb.appearance_types)}
    looks = np.array([code[name] for name in kind.lobes.types], np.intp)
    seen = np.flatnonzero(there & (rng.random(len(looks)) < world.hit[looks]))
    at = transform_points(pose, kind.lobes.at[seen])
    x_axes = np.array([kind.features[f].rotation[:, 0] for f in seen]).reshape(-1, 3) @ pose[:3, :3].T
    uv = CAMERA.project(at) + rng.normal(0.0, DETECTOR.sigma, (len(seen), 2))
    angle = screen_angle(x_axes, at) + rng.normal(0.0, DETECTOR.turn, len(seen))
    return uv, looks[seen], angle % (2.0 * np.pi)


def _noise(world: World, rng: np.random.Generator) -> Reports:
    looks = np.repeat(np.arange(len(world.clutter)), rng.poisson(world.clutter))
    uv = rng.uniform(-0.5, [CAMERA.width - 0.5, CAMERA.height - 0.5], (len(looks), 2))
    return uv, looks, rng.uniform(0.0, 2.0 * np.pi, len(looks))
