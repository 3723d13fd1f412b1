"""The sequences of ``plogic bench constancy``.

Known and unknown bodies on a table, clutter, and a camera that moves on a ring round them.

* ``Sequence``: its views, what they show, and which datum is of which feature of whom

The types of the knowledge base are polyhedra; so are the unknown bodies, of other shapes, which look like features of
the same vocabulary.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.calibration.scenes import in_view
from benchmarks.clutter.scenes import CAMERA, surface_of
from benchmarks.clutter.types import knowledge_base, type_names
from benchmarks.many.placing import meet
from benchmarks.many.types import DETECTOR, polyhedron
from geometry.frames import (
    compose,
    from_rotation_translation,
    inverse,
    look_at,
    rotation_from_quat_xyzw,
    transform_points,
)
from plogic.match.gamma.grid import screen_angle
from plogic.sequence.constancy.sight_lines import View
from sensing.appearance import Appearance, Gamma

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType

    Floats = NDArray[np.float64]

TYPES, LOOKS = 8, 30
"""Types of the knowledge base; appearance types, of which corners look like one of the first 20."""
CLUTTER = 45.0
"""Data of clutter an image, on the average; each look has its own share of them."""
KNOWN, UNKNOWN = (1, 2), (1, 3)
"""Least and most objects of types of the KB, and of none."""
TABLE = 0.28
"""m; radius of the disc in which the objects' middles lie."""
RING, HEIGHT = (0.9, 1.3), (0.4, 0.8)
"""m; the camera's distance from the middle, and its height."""
STEP = np.radians(12.0), np.radians(25.0)
"""Least and most by which the camera moves on its ring from one view to the next: 0.2 to 0.5 m."""
VIEWS = 5
TRIES = 200
NUMBER = 60_013
"""Of these sequences' own, so that no other benchmark's seed gives the same draws."""


class Cause(NamedTuple):
    """Whose a datum is: of the ``object``-th body, which is of a type of the KB or not, the ``feature``-th."""

    object: int
    feature: int


@dataclass(frozen=True, eq=False)
class Sequence:
    """``causes`` by view and datum, of all that is no clutter; ``known`` (O,) whether each body is of a type of the KB.

    ``visible``: by view the features that are to be seen there, detected or not.
    """

    views: tuple[View, ...]
    causes: Mapping[str, Mapping[str, Cause]]
    known: tuple[bool, ...]
    visible: Mapping[str, frozenset[Cause]]


class _Standing(NamedTuple):
    kind: ObjectType
    world_from_object: Floats


def constancy_kb(seed: int) -> KnowledgeBase:
    """Σ: polyhedra, with the detector's statistics as they would be learned.

    Clutter has a rate of its own for each look.
    """
    rng = np.random.default_rng([seed, NUMBER, TYPES])
    names = type_names(LOOKS)
    kb = knowledge_base([polyhedron(f"p{i}", names, rng) for i in range(TYPES)], names, DETECTOR)
    share = rng.gamma(2.0, 1.0, LOOKS)
    clutter = {name: float(CLUTTER * part) for name, part in zip(names, share / share.sum(), strict=True)}
    return replace(
        kb, name="constancy", rates=replace(kb.rates, clutter=clutter, prior=dict.fromkeys(kb.rates.prior, 0.2))
    )


def sequence(kb: KnowledgeBase, seed: int, views: int = VIEWS) -> Sequence:
    """The sequence of a seed."""
    rng = np.random.default_rng([seed, NUMBER])
    known, unknown = (int(rng.integers(*bounds, endpoint=True)) for bounds in (KNOWN, UNKNOWN))
    kinds = [kb.types[int(rng.integers(len(kb.types)))] for _ in range(known)]
    kinds += [polyhedron(f"x{i}", kb.appearance_types, rng) for i in range(unknown)]
    standing = _placed(kinds, rng)
    shown = [_view(kb, standing, f"v{n}", frame, rng) for n, frame in enumerate(_ring(views, rng), 1)]
    return Sequence(
        tuple(view for view, _, _ in shown),
        {view.id: causes for view, causes, _ in shown},
        tuple(one.kind in kb.types for one in standing),
        {view.id: visible for view, _, visible in shown},
    )


def _placed(kinds: list[ObjectType], rng: np.random.Generator) -> list[_Standing]:
    """Each somewhere over the table, turned at random; what finds no room is left out."""
    standing: list[_Standing] = []
    for kind in kinds:
        for _ in range(TRIES):
            R = rotation_from_quat_xyzw(rng.normal(size=4))
            radius, around = TABLE * np.sqrt(rng.random()), rng.uniform(0.0, 2.0 * np.pi)
            lift = -float((surface_of(kind).vertices @ R.T)[:, 2].min())
            pose = from_rotation_translation(R, np.array([radius * np.cos(around), radius * np.sin(around), lift]))
            if not any(meet(kind, pose, *other) for other in standing):
                standing.append(_Standing(kind, pose))
                break
    return standing


def _ring(count: int, rng: np.random.Generator) -> list[Floats]:
    """world_from_camera (4, 4) of each view.

    On from the last, always the same way round, looking at about the middle.
    """
    radius, height = rng.uniform(*RING), rng.uniform(*HEIGHT)
    around = rng.uniform(0.0, 2.0 * np.pi)
    frames = []
    for _ in range(count):
        eye = np.array([radius * np.cos(around), radius * np.sin(around), height]) * rng.uniform(0.95, 1.05, 3)
        frames.append(inverse(look_at(eye, np.array([0.0, 0.0, 0.08]) + rng.normal(0.0, 0.02, 3))))
        around += rng.uniform(*STEP)
    return frames


def _view(
    kb: KnowledgeBase, standing: list[_Standing], name: str, world_from_camera: Floats, rng: np.random.Generator
) -> tuple[View, dict[str, Cause], frozenset[Cause]]:
    """What the detector reports of one view, in an order that tells nothing.

    Noise may lead what is near the border out of the image.
    """
    camera_from_world = inverse(world_from_camera)
    placed = [(one.kind, compose(camera_from_world, one.world_from_object)) for one in standing]
    data: list[tuple[str, Floats, float, Cause | None]] = []
    visible: set[Cause] = set()
    for which, one in enumerate(placed):
        there = np.flatnonzero(in_view(kb, one, placed)[0])
        there = there[CAMERA.contains(CAMERA.project(transform_points(one[1], one[0].lobes.at[there])))]
        visible |= {Cause(which, int(f)) for f in there}
        data += _reported(one, which, there[rng.random(len(there)) < DETECTOR.hit], rng)
    data += _clutter(kb, rng)
    data = [datum for datum in data if CAMERA.contains(datum[1])]
    order = rng.permutation(len(data))
    rows = [data[i] for i in order]
    appearances = tuple(
        Appearance(f"a{n}", look, (float(uv[0]), float(uv[1])), "simulated", angle)
        for n, (look, uv, angle, _) in enumerate(rows)
    )
    causes = {f"a{n}": cause for n, (_, _, _, cause) in enumerate(rows) if cause is not None}
    return View(name, Gamma(CAMERA, appearances), world_from_camera), causes, frozenset(visible)


def _reported(
    one: tuple[ObjectType, Floats], which: int, seen: NDArray[np.intp], rng: np.random.Generator
) -> list[tuple[str, Floats, float, Cause | None]]:
    kind, pose = one
    at = transform_points(pose, kind.lobes.at[seen])
    x_axes = np.array([kind.features[f].rotation[:, 0] for f in seen]).reshape(-1, 3) @ pose[:3, :3].T
    uv = CAMERA.project(at) + rng.normal(0.0, DETECTOR.sigma, (len(seen), 2))
    angle = (screen_angle(x_axes, at) + rng.normal(0.0, DETECTOR.turn, len(seen))) % (2.0 * np.pi)
    return [(kind.lobes.types[f], uv[i], float(angle[i]), Cause(which, int(f))) for i, f in enumerate(seen.tolist())]


def _clutter(kb: KnowledgeBase, rng: np.random.Generator) -> list[tuple[str, Floats, float, Cause | None]]:
    names = [name for name, rate in kb.rates.clutter.items() for _ in range(int(rng.poisson(rate)))]
    uv = rng.uniform(-0.5, [CAMERA.width - 0.5, CAMERA.height - 0.5], (len(names), 2))
    angle = rng.uniform(0.0, 2.0 * np.pi, len(names))
    return [(name, uv[i], float(angle[i]), None) for i, name in enumerate(names)]
