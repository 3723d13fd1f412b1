"""The scenes of ``plogic bench look-again``.

What would tell the worlds apart is turned away from the first view, or something stands before it.

* ``Scene``: what stands where in the world, where the camera is first, and what it would report from anywhere

A third of the scenes each: ``behind``, one object whose mark is on a side that the first view does not show;
``before``, one whose mark faces the camera, with a plain box before it; ``two``, two objects whose marks are turned
away, each its own way.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.scenes import CAMERA, surface_of, visible
from benchmarks.clutter.types import SLACK
from benchmarks.look_again.types import CLUTTER, DETECTOR
from benchmarks.many.placing import meet
from geometry.frames import inverse, look_at, transform_points
from geometry.visibility.rays import behind
from plogic.match.gamma.grid import screen_angle
from plogic.sequence.constancy.sight_lines import View
from sensing.appearance import Appearance, Gamma

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType

    Floats = NDArray[np.float64]

KINDS = "behind", "before", "two"
DISTANCE, HEIGHT = (0.9, 1.3), (0.35, 0.6)
"""Of the camera from the middle, on the level, and above the table, m."""
AWAY = 95.0, 265.0
"""Degrees between the camera's side and a mark that the first view does not show."""
FACING = 25.0
"""Degrees, at most, between the camera's side and a mark that something stands before."""
BETWEEN = 0.08, 0.12
"""M between an object and the box before it."""
APART = 0.3, 0.4
"""M between the middles of two objects."""
TRIES = 100


@dataclass(frozen=True, eq=False)
class Standing:
    """One true object: its type, and world_from_object (4, 4)."""

    kind: ObjectType
    pose: Floats


@dataclass(frozen=True, eq=False)
class Scene:
    """``sort``: one of ``KINDS``; ``first``: world_from_camera (4, 4) of the first view."""

    kb: KnowledgeBase
    sort: str
    objects: tuple[Standing, ...]
    first: Floats
    seed: int

    def view(self, name: str, world_from_camera: Floats, number: int) -> View:
        """What the detector reports from a place; of the same place and ``number`` the same again."""
        rng = np.random.default_rng([self.seed, 2, number])
        parts = [self._reported(i, world_from_camera, rng) for i in range(len(self.objects))] + [_noise(self.kb, rng)]
        uv, angle = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
        looks = [look for part in parts for look in part[2]]
        inside = CAMERA.contains(uv)
        order = [i for i in rng.permutation(len(uv)).tolist() if inside[i]]
        rows = [(looks[i], (float(uv[i, 0]), float(uv[i, 1])), float(angle[i])) for i in order]
        data = tuple(
            Appearance(f"d{n}", look, at, "simulated", angle=turned) for n, (look, at, turned) in enumerate(rows)
        )
        return View(name, Gamma(CAMERA, data), world_from_camera)

    def _reported(
        self, which: int, world_from_camera: Floats, rng: np.random.Generator
    ) -> tuple[Floats, Floats, list[str]]:
        """Places, angles and looks of what is reported of one object."""
        camera_from_world = inverse(world_from_camera)
        poses = [camera_from_world @ one.pose for one in self.objects]
        kind, pose = self.objects[which].kind, poses[which]
        at = transform_points(pose, kind.lobes.at)
        there = visible(kind, pose, self.kb.f_ref) & (rng.random(len(at)) < DETECTOR.hit)
        for other, one in enumerate(self.objects):
            if other != which:
                surface = surface_of(one.kind)
                there &= ~behind(at, surface.rays, poses[other], SLACK * surface.diameter)
        seen = np.flatnonzero(there)
        x_axes = np.array([kind.features[f].rotation[:, 0] for f in seen]).reshape(-1, 3) @ pose[:3, :3].T
        uv = CAMERA.project(at[seen]) + rng.normal(0.0, DETECTOR.sigma, (len(seen), 2))
        angle = (screen_angle(x_axes, at[seen]) + rng.normal(0.0, DETECTOR.turn, len(seen))) % (2.0 * np.pi)
        return uv, angle, [kind.lobes.types[f] for f in seen]


def _noise(kb: KnowledgeBase, rng: np.random.Generator) -> tuple[Floats, Floats, list[str]]:
    looks = [name for name in kb.appearance_types for _ in range(int(rng.poisson(CLUTTER / len(kb.appearance_types))))]
    uv = rng.uniform(-0.5, [CAMERA.width - 0.5, CAMERA.height - 0.5], (len(looks), 2))
    return uv, rng.uniform(0.0, 2.0 * np.pi, len(looks)), looks


def scene(kb: KnowledgeBase, seed: int) -> Scene:
    """The scene of a seed, of a sort in turn."""
    rng = np.random.default_rng([seed, 2007])
    sort = KINDS[seed % len(KINDS)]
    azimuth = float(rng.uniform(0.0, 2.0 * np.pi))
    objects = _placed(kb, sort, azimuth, rng)
    side = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    eye = rng.uniform(*DISTANCE) * side + [0.0, 0.0, rng.uniform(*HEIGHT)]
    return Scene(kb, sort, objects, inverse(look_at(eye, (0.0, 0.0, 0.1))), seed)


def _placed(kb: KnowledgeBase, sort: str, azimuth: float, rng: np.random.Generator) -> tuple[Standing, ...]:
    """What stands there; ``azimuth``, radians: the first camera's side."""
    marked = [kind for kind in kb.types if kind.name != "plain"]
    for _ in range(TRIES):
        kinds = [marked[i] for i in rng.choice(len(marked), 2, replace=False)]
        if sort == "two":
            across = azimuth + np.pi / 2.0 + rng.uniform(-0.4, 0.4)
            place = rng.uniform(*APART) / 2.0 * np.array([np.cos(across), np.sin(across)])
            found = [
                _stood(kind, s * place, azimuth + np.radians(rng.uniform(*AWAY)))
                for kind, s in zip(kinds, (1.0, -1.0), strict=True)
            ]
        elif sort == "behind":
            found = [_stood(kinds[0], np.zeros(2), azimuth + np.radians(rng.uniform(*AWAY)))]
        else:
            found = _with_box(kb, kinds[0], azimuth, rng)
        if not any(meet(a.kind, a.pose, b.kind, b.pose) for i, a in enumerate(found) for b in found[:i]):
            break
    return tuple(found)


def _with_box(kb: KnowledgeBase, kind: ObjectType, azimuth: float, rng: np.random.Generator) -> list[Standing]:
    """An object whose mark faces the camera, and a low box right before it."""
    turned = azimuth + np.radians(rng.uniform(-FACING, FACING))
    plain = kb.type("plain")
    depths = [float(np.ptp(surface_of(some).vertices[:, 0])) for some in (kind, plain)]
    away = sum(depths) / 2.0 + rng.uniform(*BETWEEN)
    place = away * np.array([np.cos(turned), np.sin(turned)])
    return [_stood(kind, np.zeros(2), turned), _stood(plain, place, turned)]


def _stood(kind: ObjectType, at: Floats, yaw: float) -> Standing:
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    pose[:2, 3] = at
    return Standing(kind, pose)
