"""The simulated camera: bodies, a lamp, a floor and a background go in; pixels, depth and segmentation come out.

Bodies are drawn (``stage``) at ``supersample`` times the size and averaged down: a pixel is the mean light over its
square. Floor, background and shadows are drawn behind them. Then the lens blurs and the sensor adds noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from sensing.simulated.body import Body
from sensing.simulated.stage import stage
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


def extent(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Middle (3,) of the box of vertices (V, 3), and the diameter of the ball around it that holds them all."""
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
    return middle, 2.0 * float(np.linalg.norm(vertices - middle, axis=1).max())
