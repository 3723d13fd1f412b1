"""What the colour camera of an RGB-D sensor does to the light.

Over-exposure, blur, vignetting, noise, a tone curve, sharpening, JPEG.

* ``RgbdSensor(noise=6, blur=0.9, gain=1.4, jpeg=75)``
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sensing.errors import SceneError
from sensing.simulated.camera import Sensor

if TYPE_CHECKING:
    from numpy.typing import NDArray


SHARPENED = 1.0


@dataclass(frozen=True)
class RgbdSensor(Sensor):
    """``noise``, ``blur`` and ``seed`` as of any sensor, and more that is at its best by default.

    Attributes:
        gain: What the light is multiplied by; what exceeds 255 is clipped, as in an over-exposed picture.
        gamma: Exponent of the tone curve on [0, 1]; below 1 is brighter.
        motion: Length of the motion blur, pixels.
        direction: Of the motion, radians from the image's x towards its y.
        vignette: Share of the light that is lost in the corners.
        jpeg: Quality of the compression, 1 to 100; 0 for none.
        sharpening: How much of what a blur of ``SHARPENED`` pixels takes away is added once more, as cameras do.
    """

    gain: float = 1.0
    gamma: float = 1.0
    motion: float = 0.0
    direction: float = 0.0
    vignette: float = 0.0
    jpeg: int = 0
    sharpening: float = 0.0


def random_sensor(rng: np.random.Generator, hard: float) -> RgbdSensor:
    """A sensor of chance.

    ``hard`` in [0, 1] from a good camera to what RGB-D cameras give: noise to 10, gain to 1.8, JPEG down to 40.
    """

    def up_to(most: float) -> float:
        return float(hard * rng.uniform(0, most))

    return RgbdSensor(
        noise=1.5 + up_to(8.5),
        blur=0.4 + up_to(1.1),
        seed=int(rng.integers(2**31)),
        gain=float(1 + hard * rng.uniform(-0.25, 0.8)),
        gamma=float(1 + hard * rng.uniform(-0.35, 0.35)),
        motion=up_to(4.0) if rng.random() < 0.5 else 0.0,
        direction=float(rng.uniform(0, np.pi)),
        vignette=up_to(0.4),
        jpeg=round(95 - up_to(55)),
    )


def sensed(picture: NDArray[np.float32], sensor: RgbdSensor) -> NDArray[np.uint8]:
    """The image (H, W, 3) uint8 of the light ``picture`` (H, W, 3), 0 to 255 where it is exposed right.

    Raises:
        SceneError: OpenCV cannot compress it.
    """
    import cv2

    light = picture * (sensor.gain * _vignette(picture.shape[:2], sensor.vignette))[:, :, None]
    if sensor.blur > 0:
        light = np.asarray(cv2.GaussianBlur(light, (0, 0), sensor.blur), np.float32)
    if sensor.motion > 0:
        light = np.asarray(
            cv2.filter2D(light, -1, _streak(sensor.motion, sensor.direction), borderType=cv2.BORDER_REFLECT), np.float32
        )
    noise = np.random.default_rng([sensor.seed, 2]).standard_normal(light.shape, dtype=np.float32)
    clipped = np.clip(light + sensor.noise * noise, 0, 255) / 255
    toned = 255 * clipped**sensor.gamma
    if sensor.sharpening > 0:
        toned = np.clip(toned + sensor.sharpening * (toned - cv2.GaussianBlur(toned, (0, 0), SHARPENED)), 0, 255)
    image = np.rint(toned).astype(np.uint8)
    if not sensor.jpeg:
        return image
    done, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, sensor.jpeg])
    if not done:
        raise SceneError(f"image: shape {image.shape} cannot be written as JPEG")
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.uint8)


def _vignette(shape: tuple[int, int], lost: float) -> NDArray[np.float32]:
    """(H, W) share of the light that arrives: 1 in the middle, 1 - ``lost`` in the corners."""
    y, x = (np.linspace(-1, 1, n) ** 2 / 2 for n in shape)
    return (1 - lost * (y[:, None] + x[None, :])).astype(np.float32)


def _streak(length: float, direction: float) -> NDArray[np.float32]:
    """The kernel of a straight motion during the exposure; its weights sum to 1."""
    half = int(np.ceil(length / 2)) + 1
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
    for t in np.linspace(-length / 2, length / 2, 64):
        x, y = half + t * np.cos(direction), half + t * np.sin(direction)
        left, top = int(x), int(y)
        for row, column in ((0, 0), (0, 1), (1, 0), (1, 1)):
            kernel[top + row, left + column] += (1 - abs(y - top - row)) * (1 - abs(x - left - column))
    return kernel / kernel.sum()
