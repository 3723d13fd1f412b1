"""Scenes of many objects, whose data have angles, for the laws: few types, so that their index is built in a second."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.clutter.scenes import random_pose
from benchmarks.clutter.types import type_names
from benchmarks.many.placing import Placed, depth_of, meet
from benchmarks.many.scenes import scene, scene_of
from benchmarks.many.types import LOOKS, polyhedron, with_rates
from geometry.frames import from_rotation_translation, inverse, rotation_from_quat_xyzw
from plogic.cycle.delta import Options
from plogic.run.perceive import Perceiver

TYPES = 8


@cache
def few_kb():
    """Polyhedra with corners, and patches on their faces, as in ``plogic bench many``."""
    rng, names = np.random.default_rng(5000), type_names(LOOKS)
    return with_rates([polyhedron(f"p{i:02d}", names, rng) for i in range(TYPES)], names)


@cache
def twins():
    """The same, with a second type like each, under another name."""
    kb = few_kb()
    return replace(
        kb, types=tuple(some for kind in kb.types for some in (replace(kind, name=f"{kind.name}_twin"), kind))
    )


@cache
def few_types():
    return Perceiver(few_kb())


@cache
def scene_of_seed(seed):
    """Five to ten of them, partly one behind another, among clutter."""
    return scene(few_kb(), seed)


@cache
def few_of_seed(seed):
    """Three or four of them: for laws that are not about how many there are."""
    return scene(few_kb(), seed, (3, 4))


def accepted_rows(document):
    return [h for h in document["hypotheses"] if h["status"] == "accepted"]


@cache
def seen(seed):
    """The interpretation of the scene of a seed, posterior reading."""
    return few_types()(scene_of_seed(seed).gamma, Options(reading="posterior"))


def touching(seed, degrees=0.0):
    """A scene of two, side by side, moved towards each other until they only just touch.

    By the ``camera`` turned around them by so much.
    """
    rng, kb = np.random.default_rng([seed, 1]), few_kb()
    one, other = (kb.types[i] for i in rng.choice(len(kb.types), 2, replace=False))
    there = from_rotation_translation(rotation_from_quat_xyzw(rng.normal(size=4)), [-0.12, 0.0, 0.9])
    turn, height = rotation_from_quat_xyzw(rng.normal(size=4)), rng.uniform(-0.05, 0.05)
    near, far = 0.0, 0.6
    for _ in range(40):
        x = 0.5 * (near + far)
        near, far = (
            (x, far) if meet(one, there, other, from_rotation_translation(turn, [x - 0.12, height, 0.9])) else (near, x)
        )
    beside = from_rotation_translation(turn, [far - 0.12, height, 0.9])
    poses = [(kind, inverse(camera(degrees)) @ pose) for kind, pose in ((one, there), (other, beside))]
    return scene_of(kb, [Placed(kind, pose, depth_of(kind, pose)) for kind, pose in poses], rng)


def camera(degrees):
    """world_from_camera of one turned about the vertical through the middle of two that touch.

    By 0 degrees it is where the world begins.
    """
    about, middle = Rotation.from_rotvec([0.0, np.radians(degrees), 0.0]).as_matrix(), np.array([0.0, 0.0, 0.9])
    return from_rotation_translation(about, middle - about @ middle)


def alike(seed, count=3):
    """A scene of some of one type, apart from each other."""
    rng, kb = np.random.default_rng([seed, 2]), few_kb()
    kind, objects = kb.types[seed % len(kb.types)], []
    while len(objects) < count:
        pose = random_pose(kind, rng)
        if all(
            np.linalg.norm(pose[:2, 3] / pose[2, 3] - other.pose[:2, 3] / other.pose[2, 3]) > 0.3 for other in objects
        ):
            objects.append(Placed(kind, pose, depth_of(kind, pose)))
    return scene_of(kb, objects, rng)
