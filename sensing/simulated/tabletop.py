"""Table-top scenes: three to five textured things of 5 to 25 cm that physics has put down, as an RGB-D camera sees them.

* ``recognition_scene([("cracker", mesh), ...], seed=5000, hard=0.5)``

Seeds 0 to 59 are the benchmark's (``plogic bench recognition``). Develop on seeds from 5000 on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from sensing.errors import SceneError
from sensing.simulated.lighting import Light
from sensing.simulated.printed import random_package
from sensing.simulated.putting_down import put_down
from sensing.simulated.rgbd_sensor import RgbdSensor, random_sensor
from sensing.simulated.scene import Scene
from sensing.simulated.seen import bounds, seen_fractions
from sensing.simulated.table import Table, photographed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sensing.simulated.body import Body, TexturedMesh
    from sensing.simulated.camera import Rendering

FOCAL = (500.0, 620.0)
DISTANCE = (0.5, 1.2)
ELEVATION = (15.0, 60.0)
PIXELS = (60.0, 200.0)
"""The longer side of a thing's picture."""
MARGIN = 4.0
CROWDED = 0.67
"""Share of the scenes in which at least one thing is hidden to 30 to 60 %, none more; in the others none more than 30
%."""
TWINS = 0.15
"""Share of the scenes in which one type stands there twice."""
ARRANGEMENTS, VIEWS = 60, 16


@dataclass(frozen=True, eq=False)
class TabletopScene(Scene):
    """A scene whose surroundings are a table and whose sensor is an RGB-D camera's; drawn by rays."""

    surroundings: Table
    sensor: RgbdSensor

    def photograph(self, supersample: int = 2) -> Rendering:
        """The picture with its depth and segmentation."""
        return photographed(self.bodies, self.camera, self.light, self.surroundings, self.sensor, supersample)


def recognition_scene(
    shapes: Sequence[tuple[str, TexturedMesh]],
    seed: int,
    *,
    bodies: tuple[int, int] = (3, 5),
    empty: bool = False,
    hard: float = 0.5,
) -> TabletopScene:
    """From ``bodies[0]`` to ``bodies[1]`` of the shapes and up to two packages of no type (in ``empty`` scenes two to four, and no shape).

    ``hard`` in [0, 1]: from a good camera in good light to noise, blur, over-exposure and a lamp of any colour. Every
    shape is in view whole, 60 to 200 pixels long, 0.5 to 1.2 m away. The same arguments give the same scene.

    Raises:
        SceneError: No such scene was found in 60 arrangements, each seen from 16 places.
    """
    rng = np.random.default_rng([seed, 5])
    crowded = bool(rng.random() < CROWDED)
    for _ in range(ARRANGEMENTS):
        things = _packages(rng, int(rng.integers(2, 5))) if empty else _chosen(shapes, rng, bodies)
        placed = put_down(things, rng, spread=0.12 if crowded else 0.2)
        found = _viewed(placed, rng, crowded=crowded and not empty) if placed else None
        if placed and found:
            camera, fractions = found
            return TabletopScene(
                placed, camera, _light(rng, hard), _table(rng, camera, hard), random_sensor(rng, hard), fractions
            )
    raise SceneError(
        f"no table-top scene of {bodies[0]} to {bodies[1]} of {len(shapes)} shapes was found in {ARRANGEMENTS} arrangements"
    )


def _chosen(
    shapes: Sequence[tuple[str, TexturedMesh]], rng: np.random.Generator, bodies: tuple[int, int]
) -> list[tuple[str | None, TexturedMesh]]:
    number = int(rng.integers(bodies[0], bodies[1] + 1))
    order = rng.permutation(len(shapes))[:number].tolist()
    if len(order) > 1 and rng.random() < TWINS:
        order[-1] = order[0]
    return [*(shapes[i] for i in order), *_packages(rng, int(rng.choice(3, p=(0.4, 0.4, 0.2))))]


def _packages(rng: np.random.Generator, number: int) -> list[tuple[str | None, TexturedMesh]]:
    return [(None, random_package(rng)) for _ in range(number)]


def _viewed(
    bodies: Sequence[Body], rng: np.random.Generator, *, crowded: bool
) -> tuple[Camera, tuple[float, ...]] | None:
    """A camera that sees them as wanted, with the visible fractions; None if 16 places of chance give none."""
    typed = [i for i, body in enumerate(bodies) if body.label is not None] or list(range(len(bodies)))
    for _ in range(VIEWS):
        camera = _aimed([bodies[i] for i in typed], rng)
        if not all(_fits(bodies[i], camera) for i in typed):
            continue
        fractions = seen_fractions(bodies, camera)
        mine = [fractions[i] for i in typed]
        if min(mine) >= (0.4 if crowded else 0.7) and (not crowded or min(mine) <= 0.7):
            return camera, fractions
    return None


def _aimed(bodies: Sequence[Body], rng: np.random.Generator) -> Camera:
    points = np.concatenate([b.vertices_world for b in bodies])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    elevation, azimuth = np.radians(rng.uniform(*ELEVATION)), rng.uniform(0, 2 * np.pi)
    side = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    eye = middle + rng.uniform(*DISTANCE) * side
    angle, f = np.radians(rng.uniform(-8, 8)), rng.uniform(*FOCAL)
    roll = np.eye(4)
    roll[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    world_from_camera = inverse(roll @ look_at(eye, middle + rng.uniform(-0.06, 0.06, 3), (0, 0, 1)))
    centre = np.array([320.0, 240.0]) + rng.uniform(-12, 12, 2)
    return Camera(640, 480, np.array([[f, 0, centre[0]], [0, f, centre[1]], [0, 0, 1]]), np.zeros(0), world_from_camera)


def _fits(body: Body, camera: Camera) -> bool:
    """Whether it is in view whole, at a size and distance as wanted."""
    low, high = bounds(body, camera)
    away = np.linalg.norm(
        transform_points(inverse(np.asarray(camera.world_from_camera)), body.vertices_world).mean(axis=0)
    )
    inside = (low >= MARGIN).all() and (high <= (camera.width - 1 - MARGIN, camera.height - 1 - MARGIN)).all()
    return bool(inside and PIXELS[0] <= (high - low).max() <= PIXELS[1] and DISTANCE[0] <= away <= DISTANCE[1])


def _light(rng: np.random.Generator, hard: float) -> Light:
    azimuth, elevation = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(30, 80))
    x, y, z = np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)
    lamp = rng.uniform(0.3, 0.5 + 0.25 * hard)
    return Light(
        (float(x), float(y), float(z)),
        ambient=float(rng.uniform(0.35, 0.5)),
        lamp=float(lamp),
        sky=float(rng.uniform(0.1, 0.25)),
        back=0.0,
    )


def _table(rng: np.random.Generator, camera: Camera, hard: float) -> Table:
    """Patterns and colours of chance; the wall is on the far side, as the camera looks."""
    forward = np.asarray(camera.world_from_camera)[:2, 2]

    def colour() -> tuple[float, float, float]:
        b, g, r = 1 + hard * rng.uniform(-0.18, 0.18, 3)
        return (float(b), float(g), float(r))

    return Table(
        seed=int(rng.integers(2**31)),
        floor_pattern=_named(rng, {"wood": 0.3, "plain": 0.15, "noise": 0.2, "checks": 0.15, "newsprint": 0.2}),
        wall_pattern=_named(
            rng, {"plain": 0.35, "noise": 0.2, "wood": 0.1, "checks": 0.1, "newsprint": 0.1, "label": 0.15}
        ),
        floor_metres=float(rng.uniform(0.9, 1.5)),
        wall_metres=float(rng.uniform(0.9, 2.0)),
        wall_distance=float(rng.uniform(0.45, 1.2)),
        wall_azimuth=float(np.arctan2(forward[1], forward[0]) + rng.uniform(-0.5, 0.5)),
        lamp_colour=colour(),
        sky_colour=colour(),
        gloss=float(rng.uniform(0, 0.05 + 0.2 * hard)),
    )


def _named(rng: np.random.Generator, chances: dict[str, float]) -> str:
    return str(rng.choice(list(chances), p=list(chances.values())))
