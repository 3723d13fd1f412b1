"""Table-top scenes: three to five textured things of 5 to 25 cm, put down by physics, as an RGB-D camera sees them.

* ``recognition_scene([("cracker", mesh), ...], seed=5000, hard=0.5)``

Seeds 0 to 59 are the benchmark's (``plogic bench recognition``), those from 20000 on ``plogic bench photos
--simulated``'s, and from 40000 on ``plogic bench support``'s. Develop on seeds from 5000 on.

How much of each body a camera sees, by rays: the share of its own picture that the others leave visible.

Putting things down on a table: a side of chance below, close together but apart, then physics brings them to rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.tabletop.patterns import random_package
from benchmarks.tabletop.rgbd_sensor import RgbdSensor, random_sensor
from benchmarks.tabletop.table import Table, photographed
from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from geometry.visibility.rays import RayMesh
from sensing.errors import SceneError
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.physics import settle
from sensing.simulated.scene import Scene
from sensing.simulated.surroundings import Light

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from sensing.simulated.camera import Rendering

UPRIGHT = 0.6
"""Share of the things that stand as their mesh does; the others lie on a side of chance."""
GAP = 0.006
"""Metres between two footprints before the physics."""
TRIES = 40
GRAIN = 0.002
"""Metres that a hull may miss: one of thousands of corners takes long and is no better."""
FLOATING = 0.006


STEP = 2
"""Pixels between neighbouring rays."""


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
SEEN = (0.7, 1.0), (0.4, 0.7)
"""Bounds of what is visible of the most hidden thing: of a scene that is not crowded, and of one that is."""
ARRANGEMENTS, VIEWS = 60, 16


@dataclass(frozen=True)
class Arrangement:
    """How things lie and are seen: how many, how far away (m), how long (pixels), and the chance of a crowded scene.

    ``packages``: chances of none, one, two and so on that are of no type; ``elevation``: degrees above the table.
    """

    bodies: tuple[int, int] = (3, 5)
    distance: tuple[float, float] = DISTANCE
    pixels: tuple[float, float] = PIXELS
    crowded: float = CROWDED
    packages: tuple[float, ...] = (0.4, 0.4, 0.2)
    elevation: tuple[float, float] = ELEVATION


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
    arranged: Arrangement = Arrangement(),
    empty: bool = False,
    hard: float = 0.5,
) -> TabletopScene:
    """So many of the shapes and packages of no type as are ``arranged``: three to five, and up to two packages.

    ``empty`` scenes have two to four packages, and no shape.

    ``hard`` in [0, 1]: from a good camera in good light to noise, blur, over-exposure and a lamp of any colour. Every
    shape is in view whole, unless it is said otherwise 60 to 200 pixels long, 0.5 to 1.2 m away. The same arguments
    give the same scene.

    Raises:
        SceneError: No such scene was found in 60 arrangements, each seen from 16 places.
    """
    rng = np.random.default_rng([seed, 5])
    crowded = bool(rng.random() < arranged.crowded)
    for _ in range(ARRANGEMENTS):
        things = _packages(rng, int(rng.integers(2, 5))) if empty else _chosen(shapes, rng, arranged)
        placed = put_down(things, rng, spread=0.12 if crowded else 0.2)
        found = viewed(placed, rng, arranged, seen=SEEN[crowded and not empty]) if placed else None
        if placed and found:
            camera, fractions = found
            return TabletopScene(
                placed,
                camera,
                random_light(rng, hard),
                random_table(rng, camera, hard),
                random_sensor(rng, hard),
                fractions,
            )
    few, many = arranged.bodies
    raise SceneError(
        f"no table-top scene of {few} to {many} of {len(shapes)} shapes was found in {ARRANGEMENTS} arrangements"
    )


def _chosen(
    shapes: Sequence[tuple[str, TexturedMesh]], rng: np.random.Generator, arranged: Arrangement
) -> list[tuple[str | None, TexturedMesh]]:
    number = int(rng.integers(arranged.bodies[0], arranged.bodies[1] + 1))
    order = rng.permutation(len(shapes))[:number].tolist()
    if len(order) > 1 and rng.random() < TWINS:
        order[-1] = order[0]
    return [*(shapes[i] for i in order), *_packages(rng, int(rng.choice(len(arranged.packages), p=arranged.packages)))]


def _packages(rng: np.random.Generator, number: int) -> list[tuple[str | None, TexturedMesh]]:
    return [(None, random_package(rng)) for _ in range(number)]


def viewed(
    bodies: Sequence[Body], rng: np.random.Generator, arranged: Arrangement, seen: tuple[float, float]
) -> tuple[Camera, tuple[float, ...]] | None:
    """A camera that sees them as wanted, with the visible fractions; None if 16 places of chance give none.

    ``seen``: bounds of what is visible of that typed body of which the least is.
    """
    typed = [i for i, body in enumerate(bodies) if body.label is not None] or list(range(len(bodies)))
    for _ in range(VIEWS):
        camera = _aimed([bodies[i] for i in typed], rng, arranged)
        if not all(_fits(bodies[i], camera, arranged) for i in typed):
            continue
        fractions = seen_fractions(bodies, camera)
        if seen[0] <= min(fractions[i] for i in typed) <= seen[1]:
            return camera, fractions
    return None


def _aimed(bodies: Sequence[Body], rng: np.random.Generator, arranged: Arrangement) -> Camera:
    points = np.concatenate([b.vertices_world for b in bodies])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    elevation, azimuth = np.radians(rng.uniform(*arranged.elevation)), rng.uniform(0, 2 * np.pi)
    side = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    eye = middle + rng.uniform(*arranged.distance) * side
    angle, f = np.radians(rng.uniform(-8, 8)), rng.uniform(*FOCAL)
    roll = np.eye(4)
    roll[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    world_from_camera = inverse(roll @ look_at(eye, middle + rng.uniform(-0.06, 0.06, 3), (0, 0, 1)))
    centre = np.array([320.0, 240.0]) + rng.uniform(-12, 12, 2)
    return Camera(640, 480, np.array([[f, 0, centre[0]], [0, f, centre[1]], [0, 0, 1]]), np.zeros(0), world_from_camera)


def _fits(body: Body, camera: Camera, arranged: Arrangement) -> bool:
    """Whether it is in view whole, at a size and distance as wanted."""
    low, high = bounds(body, camera)
    away = np.linalg.norm(
        transform_points(inverse(np.asarray(camera.world_from_camera)), body.vertices_world).mean(axis=0)
    )
    inside = (low >= MARGIN).all() and (high <= (camera.width - 1 - MARGIN, camera.height - 1 - MARGIN)).all()
    (small, large), (near, far) = arranged.pixels, arranged.distance
    return bool(inside and small <= (high - low).max() <= large and near <= away <= far)


def random_light(rng: np.random.Generator, hard: float) -> Light:
    """A lamp and a sky of chance; the harder, the brighter is the lamp."""
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


def random_table(rng: np.random.Generator, camera: Camera, hard: float) -> Table:
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


def seen_fractions(bodies: Sequence[Body], camera: Camera) -> tuple[float, ...]:
    """Per body: what is seen of it over what would be seen of it alone, both within the image.

    0 where it is not in the image.
    """
    columns, rows = np.arange(0, camera.width, STEP), np.arange(0, camera.height, STEP)
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    rays = np.c_[pixels, np.ones(len(pixels))] @ np.linalg.inv(camera.K).T
    depths = np.stack([_depths(body, camera, pixels, rays) for body in bodies])
    alone = np.isfinite(depths).sum(axis=1)
    first = np.where(np.isfinite(depths).any(axis=0), depths.argmin(axis=0), -1)
    return tuple(float((first == i).sum() / n) if n else 0.0 for i, n in enumerate(alone))


def bounds(body: Body, camera: Camera) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The least and the greatest (2,) pixel of the body's picture; not finite where some of it is behind the camera."""
    uv = camera.project(transform_points(inverse(np.asarray(camera.world_from_camera)), body.vertices_world))
    if not np.isfinite(uv).all():
        return np.full(2, -np.inf), np.full(2, np.inf)
    return uv.min(axis=0), uv.max(axis=0)


def _depths(body: Body, camera: Camera, pixels: NDArray[np.int64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) distances to this body alone; inf for none."""
    low, high = bounds(body, camera)
    near = ((pixels >= low - 1) & (pixels <= high + 1)).all(axis=1)
    found = np.full(len(pixels), np.inf)
    if near.any():
        mesh = RayMesh(body.vertices_world, body.mesh.triangles)
        pose = np.asarray(camera.world_from_camera)
        found[near] = mesh.first_hit(pose[None, :3, 3], rays[near] @ pose[:3, :3].T)
    return found


def put_down(
    things: Sequence[tuple[str | None, TexturedMesh]], rng: np.random.Generator, spread: float
) -> tuple[Body, ...] | None:
    """The things at rest around the origin, ``spread`` metres and more about it.

    None where there is no room or no rest.
    """
    placed: list[Body] = []
    for label, mesh in things:
        body = _beside(placed, label, mesh, rng, spread)
        if body is None:
            return None
        placed.append(body)
    proxies = [replace(body, mesh=hull(body.mesh)) for body in placed]
    try:
        rested = settle(proxies, int(rng.integers(2**31)), drop=0.004)
    except SceneError:
        return None
    return tuple(
        _grounded(replace(body, world_from_body=r.world_from_body)) for body, r in zip(placed, rested, strict=True)
    )


def hull(mesh: TexturedMesh) -> TexturedMesh:
    """The convex hull, of corners at least 2 mm apart: what the physics takes the thing for, concave or not."""
    from scipy.spatial import ConvexHull

    points = np.unique(np.round(mesh.vertices[ConvexHull(mesh.vertices).vertices] / GRAIN), axis=0) * GRAIN
    corners = points[ConvexHull(points).vertices]
    return TexturedMesh(corners, ConvexHull(corners).simplices)


def _beside(
    placed: Sequence[Body], label: str | None, mesh: TexturedMesh, rng: np.random.Generator, spread: float
) -> Body | None:
    """The mesh at a place where its footprint is free; the circle around the origin grows with every try."""
    from shapely import MultiPoint

    prints = [MultiPoint(b.vertices_world[:, :2]).convex_hull for b in placed]
    for i in range(TRIES):
        reach = spread * (0.5 + i / TRIES)
        pose = _standing(mesh, rng, rng.uniform(-reach, reach, 2))
        body = Body(label, mesh, pose)
        own = MultiPoint(body.vertices_world[:, :2]).convex_hull
        if all(own.distance(other) > GAP for other in prints):
            return body
    return None


def _standing(mesh: TexturedMesh, rng: np.random.Generator, at: NDArray[np.float64]) -> NDArray[np.float64]:
    """World pose on one of the six sides, turned about the vertical by chance, its box's middle over ``at`` (2,)."""
    from scipy.spatial.transform import Rotation

    down = Rotation.identity()
    if rng.random() > UPRIGHT:
        axis, turns = ("x", (90, 180, 270)) if rng.random() < 0.6 else ("y", (90, 270))
        down = Rotation.from_euler(axis, float(rng.choice(turns)), degrees=True)
    pose = np.eye(4)
    pose[:3, :3] = (Rotation.from_euler("z", rng.uniform(0, 360), degrees=True) * down).as_matrix()
    points = mesh.vertices @ pose[:3, :3].T
    low, high = points.min(axis=0), points.max(axis=0)
    pose[:3, 3] = (*(at - (low + high)[:2] / 2), -low[2])
    return pose


def _grounded(body: Body) -> Body:
    """Set on the floor what the physics' margins left a little above or below it."""
    lowest = float(body.vertices_world[:, 2].min())
    if abs(lowest) > FLOATING:
        return body
    pose = body.world_from_body.copy()
    pose[2, 3] -= lowest
    return replace(body, world_from_body=pose)
