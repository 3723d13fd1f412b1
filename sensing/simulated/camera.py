"""The simulated camera: bodies, a lamp, a floor and a background go in; pixels, depth and segmentation come out.

Bodies are drawn (``stage``) at ``supersample`` times the size and averaged down: a pixel is the mean light over its
square. Floor, background and shadows are drawn behind them. Then the lens blurs and the sensor adds noise.

* ``Turn``: one large picture of a body alone with its depth, as learning a type looks at it, ``Turn(image, mask, depth,
  camera, pixels=990.0)``
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera, centred_camera
from geometry.frames import inverse, look_at
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.stage import Stage, stage
from sensing.simulated.surroundings import Light, Surroundings, draw_surroundings, floor_depth


@dataclass(frozen=True)
class Sensor:
    """``noise``: standard deviation, grey levels per channel; ``blur``: the lens' standard deviation, pixels.

    ``seed`` of the noise.
    """

    noise: float = 3.5
    blur: float = 0.4
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Rendering:
    """One picture with its ground truth.

    Attributes:
        image: (H, W, 3) uint8, blue first.
        depth: (H, W) float32 metres along the optical axis at the pixel's centre; inf where there is nothing.
        segmentation: (H, W) int32 index into the bodies at the pixel's centre; -1 floor or background.
    """

    image: NDArray[np.uint8]
    depth: NDArray[np.float32]
    segmentation: NDArray[np.int32]


def render(
    bodies: Sequence[Body],
    camera: Camera,
    light: Light | None = None,
    surroundings: Surroundings | None = None,
    sensor: Sensor | None = None,
    supersample: int = 3,
) -> Rendering:
    """Take a picture. The same arguments give the same bytes.

    Raises:
        SceneError: The camera has no pose or has lens distortion, or a body has too many triangles.
    """
    light, sensor = light or Light(), sensor or Sensor()
    with stage(bodies, light) as drawn:
        colour, segmentation, depth = drawn.shoot(camera, supersample)
    picture = _composed(colour, segmentation, draw_surroundings(camera, bodies, light, surroundings or Surroundings()))
    middle = slice(supersample // 2, None, supersample)
    seen, depth = segmentation[middle, middle], depth[middle, middle]
    whole_depth = np.where(seen >= 0, depth, floor_depth(camera)).astype(np.float32)
    return Rendering(_sensed(picture, sensor), whole_depth, np.ascontiguousarray(seen, np.int32))


def visible_fractions(bodies: Sequence[Body], camera: Camera) -> tuple[float, ...]:
    """Return for each body the share of its own picture (alone, within the image) that the others leave visible.

    It is 0 of a body that is not in the image. Raises SceneError as ``render`` does.
    """
    with stage(bodies, Light()) as drawn:
        together = drawn.shoot(camera, 1)[1]
        fractions = []
        for own in range(len(bodies)):
            alone = int((drawn.alone(own, camera) == own).sum())
            fractions.append(int((together == own).sum()) / alone if alone else 0.0)
    return tuple(fractions)


def _composed(
    colour: NDArray[np.uint8], segmentation: NDArray[np.int32], behind: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Average the bodies' light over each pixel's square and let the surroundings through where they leave some."""
    size = (behind.shape[1], behind.shape[0])
    own = (segmentation >= 0).astype(np.uint8)
    share = np.asarray(cv2.resize(own * 255, size, interpolation=cv2.INTER_AREA), np.float32)[:, :, None] / 255
    mean = np.asarray(cv2.resize(colour * own[:, :, None], size, interpolation=cv2.INTER_AREA), np.float32)
    return np.asarray(mean + (1 - share) * behind, np.float32)


def _sensed(picture: NDArray[np.float32], sensor: Sensor) -> NDArray[np.uint8]:
    if sensor.blur > 0:
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), sensor.blur), np.float32)
    noise = np.random.default_rng([sensor.seed, 2]).standard_normal(picture.shape, dtype=np.float32)
    return np.clip(np.rint(picture + sensor.noise * noise), 0, 255).astype(np.uint8)


FINER = 3
"""Pictures are drawn so many times larger than the largest that is needed."""
EVEN = Light(ambient=1.0, lamp=0.0, sky=0.0, back=0.0)
UNIT = 1.0
"""The body is drawn this large, metres, whatever its size: pybullet's clipping planes suit no dice and no buildings."""
STEEP = 0.95


@dataclass(frozen=True, eq=False)
class Turn:
    """One picture of the body before nothing.

    ``image`` (H, W, 3) uint8, blue first; ``mask`` (H, W) where the body is; ``depth`` (H, W) metres along the optical
    axis; ``camera``, whose ``world_from_camera`` is body_from_camera; ``pixels``: the body's diameter in the picture.
    """

    image: NDArray[np.uint8]
    mask: NDArray[np.bool_]
    depth: NDArray[np.float32]
    camera: Camera
    pixels: float


def turned(
    mesh: TexturedMesh, viewpoints: Sequence[NDArray[np.float64]], pixels: float, margin: float, away: float
) -> Iterator[Turn]:
    """One picture a direction (3,) from the middle of the mesh's box; distances and depth are the mesh's own metres.

    ``pixels``: the body's diameter, of which pictures are ``FINER`` times as many; ``margin``: what is left around the
    body, and ``away``: the viewpoint's distance, both in diameters.
    """
    middle, diameter = extent(mesh.vertices)
    scale = UNIT / diameter
    small = replace(mesh, vertices=(mesh.vertices - middle) * scale)
    with stage([Body(None, small, np.eye(4))], EVEN) as drawn:
        for direction in viewpoints:
            upward = (0.0, 0.0, 1.0) if abs(direction[2]) < STEEP else (0.0, 1.0, 0.0)
            camera_from_body = look_at(np.asarray(direction, float) * away * UNIT, np.zeros(3), upward)
            yield _taken(drawn, camera_from_body, (pixels, margin, away), (middle, scale))


def extent(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Middle (3,) of the box of vertices (V, 3), and the diameter of the ball around it that holds them all."""
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
    return middle, 2.0 * float(np.linalg.norm(vertices - middle, axis=1).max())


def _taken(
    drawn: Stage,
    camera_from_body: NDArray[np.float64],
    size: tuple[float, float, float],
    place: tuple[NDArray[np.float64], float],
) -> Turn:
    (pixels, margin, away), (middle, scale) = size, place
    side = round(pixels * (1.0 + 2.0 * margin))
    colour, segmentation, depth = drawn.shoot(_square(side, pixels * away, inverse(camera_from_body)), FINER)
    object_from_camera = inverse(camera_from_body)
    object_from_camera[:3, 3] = object_from_camera[:3, 3] / scale + middle
    camera = _square(side * FINER, pixels * away * FINER, object_from_camera)
    mask = segmentation >= 0
    window = _around(mask, round(margin * pixels * FINER))
    colour, mask, depth = (np.ascontiguousarray(values[window]) for values in (colour, mask, depth / np.float32(scale)))
    return Turn(colour, mask, depth, _cut(camera, window), pixels * FINER)


def _around(mask: NDArray[np.bool_], margin: int) -> tuple[slice, slice]:
    """Rows and columns of the body's box and a margin; all where there is no body."""
    spans = [np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0)]
    if not len(spans[0]):
        return slice(0, mask.shape[0]), slice(0, mask.shape[1])
    ends = [
        (max(0, int(some[0]) - margin), min(size, int(some[-1]) + margin + 1))
        for some, size in zip(spans, mask.shape, strict=True)
    ]
    return slice(*ends[0]), slice(*ends[1])


def _cut(camera: Camera, window: tuple[slice, slice]) -> Camera:
    """The camera of a part of its picture, which no lens distorts."""
    rows, columns = window
    K = camera.K - np.array([[0, 0, columns.start], [0, 0, rows.start], [0, 0, 0]])
    return Camera(columns.stop - columns.start, rows.stop - rows.start, K, np.zeros(0), camera.world_from_camera)


def _square(side: int, f: float, world_from_camera: NDArray[np.float64]) -> Camera:
    return replace(centred_camera((side, side), f), world_from_camera=world_from_camera)
