"""The faces that bodies are found to stand on, against pybullet: they stand there, and fall onto one from any side."""

from contextlib import contextmanager

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from geometry.bodies.resting import ALIKE, along_plane, resting_faces
from sensing.simulated.physics import STEP, client, has_physics

pytestmark = pytest.mark.skipif(not has_physics(), reason="pybullet is not installed")
SECONDS = 8.0
STEADY = 0.04
"""Metres, of bodies about a metre long: what stands nearer to its support's rim may tip when it is put down."""


def body(seed):
    """(N, 3) corners, the middle of mass in the origin."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.5, 0.5, (9, 3)) * rng.uniform(0.4, 1.0, 3)
    hull = ConvexHull(points)
    corners, inside = points[hull.simplices], points.mean(axis=0)
    volume = np.abs(np.linalg.det(corners - inside))
    middle = (volume[:, None] * (corners.sum(axis=1) + inside)).sum(axis=0) / (4.0 * volume.sum())
    return points[hull.vertices] - middle


def steadiness(points, down, reach):
    """Metres from under the middle of mass, the origin, to the rim of the support."""
    support = ConvexHull(points[points @ down > reach - 0.02] @ along_plane(down))
    return -support.equations[:, 2].max()


@contextmanager
def floor():
    with client() as (bullet, number):
        bullet.setGravity(0, 0, -9.81, physicsClientId=number)
        bullet.setTimeStep(STEP, physicsClientId=number)
        plane = bullet.createCollisionShape(bullet.GEOM_PLANE, physicsClientId=number)
        bullet.createMultiBody(0, plane, physicsClientId=number)
        yield bullet, number


def let_go(points, turn, drop=0.001):
    """(3,) down in the body's frame once it has come to rest, put ``drop`` m above the floor with this rotation."""
    with floor() as (bullet, number):
        shape = bullet.createCollisionShape(bullet.GEOM_MESH, vertices=points.tolist(), physicsClientId=number)
        low = (points @ turn.as_matrix().T)[:, 2].min()
        args = {"basePosition": [0, 0, drop - low], "baseOrientation": turn.as_quat().tolist()}
        placed = bullet.createMultiBody(1.0, shape, physicsClientId=number, **args)
        bullet.changeDynamics(placed, -1, lateralFriction=0.9, angularDamping=0.4, physicsClientId=number)
        for _ in range(int(SECONDS / STEP)):
            bullet.stepSimulation(physicsClientId=number)
        quat = bullet.getBasePositionAndOrientation(placed, physicsClientId=number)[1]
    return -Rotation.from_quat(quat).as_matrix()[2]


@pytest.mark.parametrize("seed", range(4))
def test_on_each_face_found_it_stands_and_from_any_side_it_ends_on_one(seed):
    points, rng = body(seed), np.random.default_rng(seed)
    faces = resting_faces(points)
    firm = [
        down for down, reach in zip(faces.down, faces.reach, strict=True) if steadiness(points, down, reach) > STEADY
    ]
    assert len(firm) >= 2
    for down in firm:
        turn = Rotation.align_vectors([[0.0, 0.0, -1.0]], [down])[0]
        assert let_go(points, turn) @ down > np.cos(ALIKE)
    for turn in Rotation.random(8, rng=rng):
        assert (faces.down @ let_go(points, turn)).max() > np.cos(ALIKE)
