"""Scenes for SoftPOSIT: a random cloud of 1 m, 4 to 9 m away, seen among strangers, f = 600 px.

And poses near the true one.
"""

import numpy as np
from geometry_bodies import random_rotations

from geometry.frames import from_rotation_translation, pose_error, rotation_from_quat_xyzw, transform_points
from geometry.poses.softposit import Annealing

NEAR = Annealing(beta=2e-3)  # as a refiner: the points are some 20 px off
PIXEL = 1 / 600


def scene(seed, points=50, missed=0.2, clutter=0.5, types=1, noise=0.0):
    """Model, image points in any order (`clutter` strangers), pose, equal types (N, M), true matches, generator."""
    rng = np.random.default_rng(seed)
    model, z = rng.uniform(-0.5, 0.5, (points, 3)), rng.uniform(4, 9)
    pose = from_rotation_translation(random_rotations(rng, 1)[0], [*(rng.uniform(-0.2, 0.2, 2) * z), z])
    placed = transform_points(pose, model)
    xy, seen = placed[:, :2] / placed[:, 2:], rng.random(points) >= missed
    strangers = rng.uniform(
        xy.min(axis=0) - 0.05, xy.max(axis=0) + 0.05, (round(seen.sum() * clutter / (1 - clutter)), 2)
    )
    image = np.concatenate([xy[seen] + rng.normal(0, 1, (seen.sum(), 2)) * noise * PIXEL, strangers])
    kinds, order = rng.integers(0, types, points), rng.permutation(len(image))
    image_kinds = np.concatenate([kinds[seen], rng.integers(0, types, len(strangers))])
    truth = np.full(points, -1)
    truth[seen] = np.argsort(order)[: seen.sum()]
    return model, image[order], pose, kinds[:, None] == image_kinds[order], truth, rng


def off(pose, rng, degrees, part, count=1):
    """`count` poses turned by `degrees` about any axis and moved by `part` of the distance in any direction."""
    quaternions = np.concatenate(
        [
            directions(rng, count) * np.sin(np.radians(degrees) / 2),
            np.full((count, 1), np.cos(np.radians(degrees) / 2)),
        ],
        axis=1,
    )
    place = pose[:3, 3] + directions(rng, count) * part * np.linalg.norm(pose[:3, 3])
    return from_rotation_translation(rotation_from_quat_xyzw(quaternions) @ pose[:3, :3], place)


def directions(rng, count):
    arrows = rng.normal(size=(count, 3))
    return arrows / np.linalg.norm(arrows, axis=1, keepdims=True)


def right(found, pose):
    """Which poses (K,) are right: within 1 degree and 1 % of the distance."""
    rotation, translation = pose_error(found.camera_from_object, pose)
    return (np.degrees(rotation) < 1) & (translation < 0.01 * np.linalg.norm(pose[:3, 3]))
