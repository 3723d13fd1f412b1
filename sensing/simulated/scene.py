"""Random scenes: bodies at rest on a floor, a camera that has them in view whole, a lamp, and the ground truth.

* ``Scene``: everything that a picture needs, ``Scene(bodies=(...), camera=Camera(...), light=Light(...), ...)``
* ``random_scene([("t1", mesh1), ("t2", mesh2)], seed=7, decoys=1, placement="hiding")``
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from sensing.errors import SceneError
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.camera import Rendering, Sensor, render, visible_fractions
from sensing.simulated.decoys import random_decoy
from sensing.simulated.lighting import Light
from sensing.simulated.settle import settle
from sensing.simulated.surroundings import Surroundings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

Placement = Literal["beside", "hiding"]
DISTANCE = (3.0, 9.0)
ELEVATION = (5.0, 45.0)
"""Degrees above the horizon at which the camera stands, seen from the things."""
ROLL = 4.0
MARGIN = 8.0
"""Pixels that everything keeps from the image's border."""
GAP = 0.08
"""Metres that footprints keep from one another."""
ATTEMPTS = 400


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies, the camera with its pose in the world, and what decides the pixels; ``fractions`` is the visible share of each body."""

    bodies: tuple[Body, ...]
    camera: Camera
    light: Light
    surroundings: Surroundings
    sensor: Sensor
    fractions: tuple[float, ...]

    @property
    def camera_from_bodies(self) -> NDArray[np.float64]:
        """(B, 4, 4) ground truth poses."""
        if self.camera.world_from_camera is None:
            raise SceneError("camera: has no pose in the world (T_world_camera)")
        poses = np.array([b.world_from_body for b in self.bodies]).reshape(-1, 4, 4)
        return np.asarray(inverse(self.camera.world_from_camera) @ poses)

    def photograph(self, supersample: int = 3) -> Rendering:
        """The picture with its depth and segmentation."""
        return render(self.bodies, self.camera, self.light, self.surroundings, self.sensor, supersample)


def default_camera() -> Camera:
    """640 × 480 pixels, f = 600, no distortion, no pose."""
    return Camera(640, 480, np.array([[600.0, 0, 320], [0, 600.0, 240], [0, 0, 1]]), np.zeros(0))


def random_scene(
    shapes: Sequence[tuple[str, TexturedMesh]],
    seed: int = 0,
    *,
    decoys: int = 0,
    placement: Placement = "beside",
    camera: Camera | None = None,
) -> Scene:
    """A scene with every one of ``shapes`` and as many ``decoys``; the same arguments give the same scene.

    ``beside``: each shape is seen to 97 % at least. ``hiding``: one of the first two hides 8 to 50 % of the other;
    decoys hide no more than half of any. In both, all is in view whole and the camera is 3 to 9 m from each shape (from
    the middle, where there is none).

    Raises:
        SceneError: ``hiding`` with fewer than two shapes, or nothing of the kind was found in 400 attempts.
    """
    if placement == "hiding" and len(shapes) < 2:
        raise SceneError(f"placement 'hiding' needs two shapes, not {len(shapes)}")
    rng = np.random.default_rng([seed, 4])
    template = camera or default_camera()
    for _ in range(ATTEMPTS):
        found = _attempt(shapes, rng, decoys, placement, template)
        if found is not None:
            bodies, placed_camera, fractions = found
            return Scene(
                bodies, placed_camera, _light(rng), _surroundings(rng), Sensor(seed=int(rng.integers(2**31))), fractions
            )
    raise SceneError(
        f"no scene of {len(shapes)} shapes and {decoys} decoys ({placement}) was found in {ATTEMPTS} attempts"
    )


def _attempt(
    shapes: Sequence[tuple[str, TexturedMesh]],
    rng: np.random.Generator,
    decoys: int,
    placement: Placement,
    template: Camera,
) -> tuple[tuple[Body, ...], Camera, tuple[float, ...]] | None:
    azimuth = rng.uniform(0, 2 * np.pi)
    bodies = _standing(shapes, rng, decoys, placement, azimuth)
    if bodies is None:
        return None
    camera = _aimed(bodies, len(shapes), azimuth, rng, template)
    if camera is None:
        return None
    bodies = settle(bodies, int(rng.integers(2**31)))
    if not _in_view(bodies, camera):
        return None
    fractions = visible_fractions(bodies, camera)
    return (bodies, camera, fractions) if _as_wanted(fractions[: len(shapes)], placement) else None


def _standing(
    shapes: Sequence[tuple[str, TexturedMesh]],
    rng: np.random.Generator,
    decoys: int,
    placement: Placement,
    azimuth: float,
) -> tuple[Body, ...] | None:
    """Bodies upright on the floor, footprints apart; None where chance put two into one place. ``azimuth`` is the camera's side."""
    away = -np.array([np.cos(azimuth), np.sin(azimuth)])
    across = np.array([-away[1], away[0]])
    bodies: list[Body] = []
    first = np.zeros(2)
    order = rng.permutation(len(shapes))
    for rank, index in enumerate(order):
        at = rng.uniform(-1.4, 1.4, 2) if rank else first
        if placement == "hiding" and rank == 1:
            at = first + rng.uniform(0.8, 2.4) * away + rng.uniform(-0.9, 0.9) * across
        label, mesh = shapes[index]
        bodies.append(Body(label, mesh, _upright(at, rng)))
    bodies += [Body(None, random_decoy(rng), _upright(rng.uniform(-1.8, 1.8, 2), rng)) for _ in range(decoys)]
    in_order = [bodies[int(np.flatnonzero(order == i)[0])] for i in range(len(shapes))] + bodies[len(shapes) :]
    return tuple(in_order) if _apart(in_order) else None


def _upright(at: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    yaw = rng.uniform(0, 2 * np.pi)
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    pose[:2, 3] = at
    return pose


def _apart(bodies: Sequence[Body]) -> bool:
    from shapely import MultiPoint

    prints = [MultiPoint(b.vertices_world[:, :2]).convex_hull for b in bodies]
    return all(a.distance(b) > GAP for i, a in enumerate(prints) for b in prints[:i])


def _aimed(
    bodies: Sequence[Body], shapes: int, azimuth: float, rng: np.random.Generator, template: Camera
) -> Camera | None:
    """A camera on the side ``azimuth`` that has everything in view; None if eight distances and elevations of chance give none."""
    points = np.concatenate([b.vertices_world for b in bodies]) if bodies else np.zeros((1, 3))
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    for _ in range(8):
        elevation = np.radians(rng.uniform(*ELEVATION))
        side = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
        eye = middle + rng.uniform(*DISTANCE) * side
        target = middle + rng.uniform(-0.3, 0.3, 3)
        camera_from_world = _rolled(look_at(eye, target, (0, 0, 1)), np.radians(rng.uniform(-ROLL, ROLL)))
        camera = replace(template, world_from_camera=inverse(camera_from_world))
        if eye[2] > 0.1 and _in_view(bodies, camera) and _in_reach(bodies[:shapes], eye):
            return camera
    return None


def _rolled(camera_from_world: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    roll = np.eye(4)
    roll[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return np.asarray(roll @ camera_from_world)


def _in_reach(bodies: Sequence[Body], eye: NDArray[np.float64]) -> bool:
    away = [float(np.linalg.norm(b.vertices_world.mean(axis=0) - eye)) for b in bodies]
    return all(DISTANCE[0] <= d <= DISTANCE[1] for d in away)


def _in_view(bodies: Sequence[Body], camera: Camera) -> bool:
    if camera.world_from_camera is None:
        return False
    camera_from_world = inverse(camera.world_from_camera)
    for body in bodies:
        uv = camera.project(transform_points(camera_from_world, body.vertices_world))
        last = np.array([camera.width - 1, camera.height - 1]) - MARGIN
        if not ((uv >= MARGIN) & (uv <= last)).all():
            return False
    return True


def _as_wanted(fractions: Sequence[float], placement: Placement) -> bool:
    if placement == "beside":
        return all(f >= 0.97 for f in fractions)
    return all(f >= 0.5 for f in fractions) and min(fractions[:2]) <= 0.92


def _light(rng: np.random.Generator) -> Light:
    azimuth, elevation = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(25, 75))
    direction = (np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation))
    lamp = rng.uniform(0.35, 0.5)
    return Light((float(direction[0]), float(direction[1]), float(direction[2])), ambient=0.75 - lamp, lamp=lamp)


def _surroundings(rng: np.random.Generator) -> Surroundings:
    def colour(low: float, high: float) -> tuple[float, float, float]:
        b, g, r = rng.uniform(low, high) + rng.uniform(-10, 10, 3)
        return (float(b), float(g), float(r))

    return Surroundings(
        int(rng.integers(2**31)),
        colour(70, 140),
        colour(90, 190),
        float(rng.uniform(4, 10)),
        float(rng.uniform(0.1, 0.4)),
    )
