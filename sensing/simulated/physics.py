"""Physics by pybullet, where there is one: a client per use, closed afterwards, silent.

And bodies that come to rest on the floor.

It has wheels for CPython 3.11 on x86-64 Linux; its fork ``pybullet-arm64``, a module of the same name, has them for
3.12 and 3.13 and for macOS on Arm. Elsewhere pictures are drawn by rays, and nothing settles or is held.

Bodies come to rest on the floor (z = 0) each as its convex hull: good enough to stand things up. Whether bodies share
volume is decided elsewhere, from the exact meshes. Without pybullet a body stays as it was put and its lowest place
touches the floor.
"""

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.diverted import DIVERTED
from geometry.room import MB, check_room
from sensing.errors import SceneError
from sensing.simulated.body import Body

DISTRIBUTIONS = "pybullet", "pybullet-arm64"
INSTALL = "pip install pybullet (CPython 3.11 on x86-64 Linux) or pybullet-arm64 (3.12, 3.13; macOS on Arm)"
"""What a user can do who needs physics."""
NO_PHYSICS = "pybullet is not installed"
ROOM = 120 * MB
"""Bytes that are wanted before it starts, as it aborts without: the picture of two boxes takes 113 MB."""


def has_physics() -> bool:
    """Whether pybullet is installed."""
    return find_spec("pybullet") is not None


def physics_version() -> str:
    """The distribution and its version, ``pybullet 3.2.7``; empty where there is none."""
    for name in DISTRIBUTIONS if has_physics() else ():
        try:
            return f"{name} {version(name)}"
        except PackageNotFoundError:
            continue
    return ""


@contextmanager
def quiet() -> Iterator[None]:
    """Send file descriptors 1 and 2 to nowhere meanwhile.

    Pybullet's C code prints a banner and warnings past ``sys.stdout``.
    """
    with DIVERTED:
        sys.stdout.flush()
        sys.stderr.flush()
        saved = [os.dup(1), os.dup(2)]
        nowhere = os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(nowhere, 1)
            os.dup2(nowhere, 2)
            yield
        finally:
            _flush_c()
            os.dup2(saved[0], 1)
            os.dup2(saved[1], 2)
            for descriptor in (*saved, nowhere):
                os.close(descriptor)


@contextmanager
def client() -> Iterator[tuple[Any, int]]:
    """Yield ``(pybullet, id)`` of a fresh DIRECT client; it is disconnected on the way out.

    Raises:
        MemoryError: There is no room for it.
    """
    check_room(ROOM)
    with quiet():
        import pybullet

        number = pybullet.connect(pybullet.DIRECT)
        try:
            yield pybullet, number
        finally:
            pybullet.disconnect(physicsClientId=number)


def _flush_c() -> None:
    """C's own buffers hold the banner back until they are flushed.

    Flush them while the descriptors still lead nowhere.
    """
    import ctypes

    ctypes.CDLL(None).fflush(None)


STEP = 1 / 240
STEPS = 480
DENSITY = 400.0
"""kg/m³ of the box around a body."""


def settle(bodies: Sequence[Body], seed: int = 0, drop: float = 0.01, tilt: float = 0.005) -> tuple[Body, ...]:
    """Drop each body from ``drop`` metres with a tilt of up to ``tilt`` radians, and return them after 2 s.

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
