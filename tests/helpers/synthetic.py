"""Synthetic Γ of the shipped towers.

What a camera would see of posed objects, with noise, misses, wrong arms and clutter.

``scene(rng, {"t1": pose})`` gives a ``Shot``: the Γ and, for each appearance, what truly caused it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from geometry.camera import Camera
from geometry.frames import inverse, look_at, pose_error, transform_points
from geometry.visibility.rays import behind
from kb.clouds.lobes import in_lobe
from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.cycle.perception import perceive
from plogic.cycle.state import Task
from plogic.match.gamma.data import data_of
from plogic.match.judged.evidence import judged
from plogic.run.perceive import Perceiver
from sensing.appearance import Appearance, Gamma

CAMERA = Camera(640, 480, np.array([[600.0, 0, 319.5], [0, 600.0, 239.5], [0, 0, 1]]))
MIDDLE = np.array([0.0, 0.0, 0.75])
ARMS = {"patch": 0, "l_junction": 2, "multi_junction": 4}
"""Arms of an appearance type; all the others have three."""


@cache
def towers():
    return read_kb(shipped("towers"))


@cache
def perceiver():
    return Perceiver(towers())


@dataclass(frozen=True)
class Shot:
    """A Γ, and the truth: ``causes`` appearance id → "t1/body/corner_0" without clutter, ``visible`` names alike."""

    gamma: Gamma
    poses: dict[str, np.ndarray]
    causes: dict[str, str]
    visible: frozenset[str]


def camera_pose(rng, distance=(3.0, 9.0), target=MIDDLE):
    """camera_from_world of a camera that looks down at the middle of a tower from anywhere around it, tilted a bit."""
    eye = target + rng.uniform(*distance) * direction(rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(8, 45)))
    return look_at(eye, target + rng.uniform(-0.2, 0.2, 3), (rng.normal(0, 0.05), rng.normal(0, 0.05), 1.0))


def direction(azimuth, elevation):
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def upright(x, y, turn):
    """world_from_object of a tower that stands at (x, y), turned about the vertical."""
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    pose[:2, 3] = x, y
    return pose


def seen_features(poses, camera=CAMERA):
    """Name → (F,) mask of the features in the image, in a lobe, and behind nothing: by projection and rays."""
    kb, masks = towers(), {}
    for name, pose in poses.items():
        kind = kb.type(name)
        at = transform_points(pose, [f.at for f in kind.features])
        lobes = in_lobe(kind.lobes, inverse(pose)[:3, 3], camera.f / kb.f_ref)[0]
        seen = camera.contains(camera.project(at)) & np.isin(np.arange(len(at)), kind.lobes.feature[lobes])
        for other, there in poses.items():
            seen &= ~behind(at, kb.type(other).surface.rays, there)
        masks[name] = seen
    return masks


def scene(rng, poses, *, hit=0.8, patch_hit=0.9, noise=0.4, clutter=12, arms=True, camera=CAMERA):
    """A Γ of the posed towers.

    ``hit`` is the chance that a junction is detected; ``clutter`` the number of false appearances.
    """
    kb, rows, names = towers(), [], set()
    for name, seen in seen_features(poses, camera).items():
        kind, pose = kb.type(name), poses[name]
        lobes = in_lobe(kind.lobes, inverse(pose)[:3, 3], camera.f / kb.f_ref)[0]
        for f in np.flatnonzero(seen):
            feature = kind.features[f]
            names.add(f"{name}/{feature.name}")
            if rng.random() > (patch_hit if feature.type == "patch" else hit):
                continue
            types = sorted({kind.lobes.types[i] for i in np.flatnonzero(lobes & (kind.lobes.feature == f))})
            uv = camera.project(transform_points(pose, feature.at[None]))[0] + rng.normal(0, noise, 2)
            directions = visible_arms(kind, pose, feature, camera) + rng.normal(0, 0.04, 1)
            rows.append((str(rng.choice(types)), uv, directions, f"{name}/{feature.name}"))
    rows += [clutter_row(rng, kb, camera) for _ in range(clutter)]
    order = rng.permutation(len(rows))
    data = [
        Appearance(f"a{i}", rows[k][0], tuple(rows[k][1]), "synthetic", arms=angles(rows[k][2]) if arms else ())
        for i, k in enumerate(order, 1)
    ]
    causes = {f"a{i}": rows[k][3] for i, k in enumerate(order, 1) if rows[k][3]}
    return Shot(Gamma(camera, tuple(data)), poses, causes, frozenset(names))


def visible_arms(kind, pose, feature, camera):
    """Screen angles of the edges at a feature whose first 3 cm its own tower does not hide."""
    along = transform_points(pose, feature.at + 0.03 * feature.arms.reshape(-1, 3))
    shown = along[~behind(along, kind.surface.rays, pose)]
    step = camera.project(shown) - camera.project(transform_points(pose, feature.at[None]))
    return np.arctan2(step[:, 1], step[:, 0])


def clutter_row(rng, kb, camera):
    name = str(rng.choice(kb.appearance_types))
    uv = rng.uniform([0, 0], [camera.width - 1, camera.height - 1])
    return name, uv, rng.uniform(0, 2 * np.pi, ARMS.get(name, 3)), ""


def angles(directions):
    return tuple(sorted(float(a) for a in np.mod(directions, 2 * np.pi)))


def side_by_side(rng, distance=5.0):
    """Both towers in view, 1.6 m apart across the line of sight: neither hides the other."""
    return stand(rng, distance, across=0.8, deep=0.0)


def one_before_the_other(rng, distance=5.0):
    """t1 in front, hiding a part of t2."""
    return stand(rng, distance, across=0.28, deep=0.75)


def stand(rng, distance, across, deep):
    """t1 and t2 on the floor, ``across`` m either side of the camera's axis.

    T1 ``deep`` m before the middle, t2 as far behind.
    """
    azimuth = rng.uniform(0, 2 * np.pi)
    eye = MIDDLE + distance * direction(azimuth, np.radians(rng.uniform(14, 22)))
    camera_from_world = look_at(eye, MIDDLE)
    to_camera, right = direction(azimuth, 0.0), camera_from_world[0, :3]
    places = {"t1": -across * right + deep * to_camera, "t2": across * right - deep * to_camera}
    turns = {"t1": rng.uniform(0, 2 * np.pi), "t2": rng.uniform(0, 2 * np.pi)}
    return {name: camera_from_world @ upright(*p[:2], turns[name]) for name, p in places.items()}


def is_right(name, pose, truth):
    """The project's bar: rotation within 3°, translation within 2 % of the distance, up to symmetry."""
    rotation, translation = pose_error(pose, truth, towers().type(name).symmetries)
    return bool(np.degrees(rotation) < 3.0 and translation < 0.02 * np.linalg.norm(truth[:3, 3]))


def data(shot):
    return data_of(shot.gamma.appearances, shot.gamma.camera)


def task_of(gamma, end=None):
    """What a run of the cycle over these data works on."""
    ready = perceiver()
    return Task(data_of(gamma.appearances, gamma.camera), ready.kb, ready.models, ready.dv, end)


def cycle_of(gamma, end=None):
    """One run of the perceptual cycle."""
    return perceive(task_of(gamma, end))


def posed_at(name, pose, of):
    """The hypothesis that a type stands at a pose, with its own matching, no polish."""
    index = perceiver().models[name]
    return index.settle(pose, of, towers(), rounds=0)


def belief_at(name, pose, of, status="accepted"):
    posed = posed_at(name, pose, of)
    return judged(posed, of, towers(), perceiver().dv).told(status=status)
