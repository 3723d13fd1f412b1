"""Letting bodies come to rest on the floor (z = 0) by pybullet's physics, each as its convex hull.

Good enough to stand things up; whether bodies share volume is decided elsewhere, from the exact meshes. Without pybullet
a body stays as it was put and its lowest place touches the floor.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from sensing.errors import SceneError
from sensing.simulated.client import client, has_physics

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from sensing.simulated.body import Body

STEP = 1 / 240
STEPS = 480
DENSITY = 400.0
"""kg/m³ of the box around a body."""


def settle(bodies: Sequence[Body], seed: int = 0, drop: float = 0.01, tilt: float = 0.005) -> tuple[Body, ...]:
    """Drop each body from ``drop`` metres with a random tilt of up to ``tilt`` radians, and return them where they are after 2 s.

    Without pybullet: each as it is, moved up or down until its lowest place touches the floor.

    Raises:
        SceneError: Something is still moving after that time.
    """
    if not has_physics():
        return tuple(_laid_down(body) for body in bodies)
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng([seed, 3])
    with client() as (bullet, number):
        bullet.setGravity(0, 0, -9.81, physicsClientId=number)
        bullet.setTimeStep(STEP, physicsClientId=number)
        plane = bullet.createCollisionShape(bullet.GEOM_PLANE, physicsClientId=number)
        bullet.createMultiBody(0, plane, physicsClientId=number)
        placed = []
        for body in bodies:
            leaning = Rotation.from_rotvec([*rng.uniform(-tilt, tilt, 2), 0.0]) * Rotation.from_matrix(
                body.world_from_body[:3, :3]
            )
            placed.append(_drop(bullet, number, body, leaning, drop))
        for _ in range(STEPS):
            bullet.stepSimulation(physicsClientId=number)
        poses = [_rest(bullet, number, n, body) for n, body in zip(placed, bodies, strict=True)]
    return tuple(replace(body, world_from_body=pose) for body, pose in zip(bodies, poses, strict=True))


def _laid_down(body: Body) -> Body:
    pose = np.array(body.world_from_body)
    pose[2, 3] -= body.vertices_world[:, 2].min()
    return replace(body, world_from_body=pose)


def _centre(body: Body) -> NDArray[np.float64]:
    """(3,) centre of the bounding box, body frame: the stand-in for the centre of mass."""
    return (body.mesh.vertices.min(axis=0) + body.mesh.vertices.max(axis=0)) / 2


def _drop(bullet: Any, number: int, body: Body, leaning: Any, drop: float) -> int:  # noqa: ANN401 - pybullet is untyped
    centre = _centre(body)
    hull = bullet.createCollisionShape(
        bullet.GEOM_MESH, vertices=(np.unique(body.mesh.vertices, axis=0) - centre).tolist(), physicsClientId=number
    )
    size = np.ptp(body.mesh.vertices, axis=0)
    at = body.world_from_body[:3, :3] @ centre + body.world_from_body[:3, 3] + (0, 0, drop)
    placed: int = bullet.createMultiBody(
        DENSITY * float(np.prod(np.maximum(size, 0.01))),
        hull,
        basePosition=at.tolist(),
        baseOrientation=leaning.as_quat().tolist(),
        physicsClientId=number,
    )
    rest = {"lateralFriction": 0.9, "rollingFriction": 0.01, "linearDamping": 0.2, "angularDamping": 0.4}
    bullet.changeDynamics(placed, -1, physicsClientId=number, **rest)
    return placed


def _rest(bullet: Any, number: int, placed: int, body: Body) -> NDArray[np.float64]:  # noqa: ANN401 - pybullet is untyped
    linear, angular = bullet.getBaseVelocity(placed, physicsClientId=number)
    if np.linalg.norm(linear) > 0.05 or np.linalg.norm(angular) > 0.1:
        raise SceneError(f"body {body.label!r}: does not come to rest")
    at, quat = bullet.getBasePositionAndOrientation(placed, physicsClientId=number)
    pose = np.eye(4)
    pose[:3, :3] = np.array(bullet.getMatrixFromQuaternion(quat)).reshape(3, 3)
    pose[:3, 3] = np.array(at) - pose[:3, :3] @ _centre(body)
    return pose
