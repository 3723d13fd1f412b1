"""Random scenes: bodies at rest on a floor, a camera that has them in view whole, a lamp, and the ground truth.

* ``Scene``: everything that a picture needs, ``Scene(bodies=(...), camera=Camera(...), light=Light(...), ...)``
* ``random_scene([("t1", mesh1), ("t2", mesh2)], seed=7, decoys=1, placement="hiding")``

Untyped things to stand about: boxes and wedges of random sizes, plain or painted with random rectangles.

A simulated scene as a folder: ``image.png``, ``camera.json`` (the contract's camera), ``truth.json``; whole or not at
    all.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera, camera_to_dict
from geometry.frames import inverse, look_at, transform_points
from sensing.errors import SceneError
from sensing.files.whole_files import write_folder
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.camera import Rendering, Sensor, render, visible_fractions
from sensing.simulated.framing import Framing, resized, resized_scene
from sensing.simulated.physics import settle
from sensing.simulated.surroundings import Light, Surroundings, placed_at

CELL = 192
"""Side of one face's square in the texture, texels."""
_BOX = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7), (3, 2, 1, 0))
_WEDGE = ((0, 1, 4), (1, 2, 5, 4), (2, 3, 5), (3, 0, 4, 5), (3, 2, 1, 0))


Placement = Literal["beside", "hiding"]
ELEVATION = (5.0, 45.0)
"""Degrees above the horizon at which the camera stands, seen from the things."""
ROLL = 4.0
MARGIN = 8.0
"""Pixels that everything keeps from the image's border."""
GAP = 0.08
"""Units of the scene that footprints keep from one another."""
ATTEMPTS = 400
ROOM = 3
"""Shapes up to which the floor is of one size; it grows as they are more: on the same floor four towers found no
room for two of three seeds (1 and 3 of 0, 1, 3), on this for none of 0 to 4
(`plogic simulate --kb towers --objects 4 --gamma`)."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies, the camera with its pose in the world, and what decides the pixels; metres.

    ``fractions`` is the visible share of each body. ``unit``: metres of the unit in which the scene is drawn: a floor's
    grain, and the nearest and farthest that is seen, go with it.
    """

    bodies: tuple[Body, ...]
    camera: Camera
    light: Light
    surroundings: Surroundings
    sensor: Sensor
    fractions: tuple[float, ...]
    unit: float = 1.0

    @property
    def camera_from_bodies(self) -> NDArray[np.float64]:
        """(B, 4, 4) ground truth poses."""
        poses = np.array([b.world_from_body for b in self.bodies]).reshape(-1, 4, 4)
        return np.asarray(inverse(placed_at(self.camera)) @ poses)

    def photograph(self, supersample: int = 3) -> Rendering:
        """The picture with its depth, metres, and segmentation."""
        bodies, camera = resized_scene(self.bodies, self.camera, 1.0 / self.unit)
        drawn = render(bodies, camera, self.light, self.surroundings, self.sensor, supersample)
        return drawn if self.unit == 1.0 else replace(drawn, depth=drawn.depth * np.float32(self.unit))

    def visible_shares(self) -> tuple[float, ...]:
        """The visible share of each body from where the camera is now."""
        return visible_fractions(*resized_scene(self.bodies, self.camera, 1.0 / self.unit))


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
    framing: Framing | None = None,
) -> Scene:
    """A scene with every one of ``shapes`` and as many ``decoys``; the same arguments give the same scene.

    ``beside``: each shape is seen to 97 % at least. ``hiding``: one of the first two hides 8 to 50 % of the other;
    decoys hide no more than half of any. In both, all is in view whole and the camera is 3 to 9 units from each shape
    (from the middle, where there is none). A unit is a metre unless ``framing`` says otherwise.

    Raises:
        SceneError: ``hiding`` with fewer than two shapes, or nothing of the kind was found in 400 attempts.
    """
    if placement == "hiding" and len(shapes) < 2:
        raise SceneError(f"placement 'hiding' needs two shapes, not {len(shapes)}")
    rng = np.random.default_rng([seed, 4])
    template, framing = camera or default_camera(), framing or Framing()
    sized = [(label, resized(mesh, 1.0 / framing.unit)) for label, mesh in shapes]
    for _ in range(ATTEMPTS):
        found = _attempt(sized, rng, decoys, placement, template, framing)
        if found is not None:
            bodies, placed_camera = resized_scene(*found[:2], framing.unit)
            look = _light(rng), _surroundings(rng), Sensor(seed=int(rng.integers(2**31)))
            return Scene(bodies, placed_camera, *look, found[2], framing.unit)
    raise SceneError(
        f"no scene of {len(shapes)} shapes and {decoys} decoys ({placement}) was found in {ATTEMPTS} attempts; "
        "at another distance, with fewer or with another seed, there may be room"
    )


def _attempt(
    shapes: Sequence[tuple[str, TexturedMesh]],
    rng: np.random.Generator,
    decoys: int,
    placement: Placement,
    template: Camera,
    framing: Framing,
) -> tuple[tuple[Body, ...], Camera, tuple[float, ...]] | None:
    azimuth = rng.uniform(0, 2 * np.pi)
    bodies = _standing(shapes, rng, decoys, placement, azimuth)
    if bodies is None:
        return None
    camera = _aimed(bodies, len(shapes), azimuth, rng, template, framing)
    if camera is None:
        return None
    bodies = settle(bodies, int(rng.integers(2**31)))
    if not _in_view(bodies, camera) or not _covering(bodies[: len(shapes)], camera, framing):
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
    """Bodies upright on the floor, footprints apart; None where chance put two into one place.

    ``azimuth`` is the camera's side.
    """
    away = -np.array([np.cos(azimuth), np.sin(azimuth)])
    across = np.array([-away[1], away[0]])
    bodies: list[Body] = []
    first = np.zeros(2)
    order = rng.permutation(len(shapes))
    for rank, index in enumerate(order):
        at = rng.uniform(-1.4, 1.4, 2) * max(1.0, len(shapes) / ROOM) if rank else first
        if placement == "hiding" and rank == 1:
            at = first + rng.uniform(0.8, 2.4) * away + rng.uniform(-0.9, 0.9) * across
        label, mesh = shapes[index]
        bodies.append(Body(label, mesh, _upright(at, rng)))
    bodies += [Body(None, random_decoy(rng), _upright(rng.uniform(-1.8, 1.8, 2), rng)) for _ in range(decoys)]
    in_order = [bodies[int(np.flatnonzero(order == i)[0])] for i in range(len(shapes))] + bodies[len(shapes) :]
    return tuple(in_order) if _apart(in_order) else None


def _upright(at: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    pose = _turned(rng.uniform(0, 2 * np.pi))
    pose[:2, 3] = at
    return pose


def _turned(angle: float) -> NDArray[np.float64]:
    """(4, 4) turn about the z axis."""
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return pose


def _apart(bodies: Sequence[Body]) -> bool:
    from shapely import MultiPoint

    prints = [MultiPoint(b.vertices_world[:, :2]).convex_hull for b in bodies]
    return all(a.distance(b) > GAP for i, a in enumerate(prints) for b in prints[:i])


def _aimed(
    bodies: Sequence[Body],
    shapes: int,
    azimuth: float,
    rng: np.random.Generator,
    template: Camera,
    framing: Framing,
) -> Camera | None:
    """A camera on the side ``azimuth`` that has everything in view.

    None if eight distances and elevations of chance give none.
    """
    points = np.concatenate([b.vertices_world for b in bodies]) if bodies else np.zeros((1, 3))
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    for _ in range(8):
        elevation = np.radians(rng.uniform(*ELEVATION))
        side = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
        eye = middle + rng.uniform(*framing.distance) * side
        target = middle + rng.uniform(-0.3, 0.3, 3)
        camera_from_world = _turned(np.radians(rng.uniform(-ROLL, ROLL))) @ look_at(eye, target, (0, 0, 1))
        camera = replace(template, world_from_camera=inverse(camera_from_world))
        away = [float(np.linalg.norm(b.vertices_world.mean(axis=0) - eye)) for b in bodies[:shapes]]
        reached = framing.reach is None or all(framing.reach[0] <= d <= framing.reach[1] for d in away)
        fits = eye[2] > 0.1 and reached and _in_view(bodies, camera)
        if fits and _covering(bodies[:shapes], camera, framing):
            return camera
    return None


def _in_view(bodies: Sequence[Body], camera: Camera) -> bool:
    last = np.array([camera.width - 1, camera.height - 1]) - MARGIN
    return all(((uv >= MARGIN) & (uv <= last)).all() for uv in _pictures(bodies, camera))


def _covering(bodies: Sequence[Body], camera: Camera, framing: Framing) -> bool:
    """Whether each has its share of the picture's height, where one is asked for."""
    if framing.cover is None:
        return True
    low, high = np.array(framing.cover) * camera.height
    return all(low <= np.ptp(uv[:, 1]) <= high for uv in _pictures(bodies, camera))


def _pictures(bodies: Sequence[Body], camera: Camera) -> Iterator[NDArray[np.float64]]:
    """(V, 2) pixels of the vertices of each."""
    camera_from_world = inverse(placed_at(camera))
    return (camera.project(transform_points(camera_from_world, body.vertices_world)) for body in bodies)


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


def random_decoy(rng: np.random.Generator) -> TexturedMesh:
    """A box or a wedge, 0.3 to 1.2 m a side, origin at the centre of its base, painted with probability 1/2."""
    size = rng.uniform((0.3, 0.3, 0.3), (0.9, 0.9, 1.2))
    painted = bool(rng.random() < 0.5)
    return box(size, rng, painted=painted) if rng.random() < 0.5 else wedge(size, rng, painted=painted)


def box(size: NDArray[np.float64], rng: np.random.Generator, *, painted: bool) -> TexturedMesh:
    """A box of ``size`` (3,) metres; a wall colour of chance, with random rectangles if ``painted``."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    base = [(-x, -y), (x, -y), (x, y), (-x, y)]
    points: list[tuple[float, ...]] = [(*p, 0.0) for p in base] + [(*p, z) for p in base]
    return _painted(points, _BOX, rng, painted=painted)


def wedge(size: NDArray[np.float64], rng: np.random.Generator, *, painted: bool) -> TexturedMesh:
    """A ramp of ``size`` (3,) metres: a right-angled triangle along x, as wide as y."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    points: list[tuple[float, ...]] = [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0), (-x, -y, z), (-x, y, z)]
    return _painted(points, _WEDGE, rng, painted=painted)


def _painted(
    points: list[tuple[float, ...]], faces: tuple[tuple[int, ...], ...], rng: np.random.Generator, *, painted: bool
) -> TexturedMesh:
    wall = rng.uniform(110, 230) + rng.uniform(-20, 20, 3)
    texture = np.empty((CELL, CELL * len(faces), 3), np.uint8)
    texture[:] = np.clip(wall, 0, 255).astype(np.uint8)
    square = np.array([(0.02, 0.02), (0.98, 0.02), (0.98, 0.98), (0.02, 0.98)])
    vertices: list[tuple[float, ...]] = []
    uv: list[tuple[float, float]] = []
    triangles: list[tuple[int, int, int]] = []
    for i, face in enumerate(faces):
        start = len(vertices)
        vertices += [points[k] for k in face]
        uv += [((i + float(s)) / len(faces), float(t)) for s, t in square[: len(face)]]
        triangles += [(start, start + j, start + j + 1) for j in range(1, len(face) - 1)]
        if painted:
            _paint(texture[:, i * CELL : (i + 1) * CELL], rng)
    return TexturedMesh(np.array(vertices), np.array(triangles), np.array(uv), texture)


def _paint(cell: NDArray[np.uint8], rng: np.random.Generator) -> None:
    """One to six rectangles of any brightness, anywhere inside the face; they may overlap."""
    for _ in range(int(rng.integers(1, 7))):
        width, height = rng.integers(CELL // 12, CELL // 3, 2)
        left, top = rng.integers(8, CELL - 8 - width), rng.integers(8, CELL - 8 - height)
        cell[top : top + height, left : left + width] = np.clip(rng.uniform(20, 240) + rng.uniform(-15, 15, 3), 0, 255)


def truth_to_dict(scene: Scene) -> dict[str, Any]:
    """Ground truth: per body its label (null for a decoy), ``T_camera_object``, and its visible fraction."""
    rows = zip(scene.bodies, scene.camera_from_bodies, scene.fractions, strict=True)
    objects = [{"label": b.label, "T_camera_object": T.tolist(), "visible_fraction": f} for b, T, f in rows]
    return {"format": "truth/1", "objects": objects}


def write_scene(scene: Scene, folder: str | Path, supersample: int = 3) -> None:
    """Photograph the scene and write its folder; the same scene gives the same bytes.

    Raises:
        SceneError: The picture cannot be made.
        SensingError: The folder holds something already, or cannot be written.
    """
    image = scene.photograph(supersample).image
    documents = {"camera.json": camera_to_dict(scene.camera), "truth.json": truth_to_dict(scene)}
    write_folder(
        Path(folder), {"image.png": png(image), **{name: json_bytes(document) for name, document in documents.items()}}
    )


def json_bytes(document: object) -> bytes:
    """The document as the bytes of a JSON file."""
    return (json.dumps(document, indent=1) + "\n").encode()


def png(image: NDArray[np.uint8]) -> bytes:
    """The (H, W, 3) uint8 picture, blue first, as the bytes of a PNG file."""
    done, data = cv2.imencode(".png", image)
    if not done:
        raise SceneError(f"image: shape {image.shape} cannot be written as PNG")
    return bytes(data.tobytes())
