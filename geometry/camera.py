"""A pinhole camera with OpenCV's lens distortion.

Frame: x right, y down, z forward. An integer pixel is a pixel's centre, so the image spans [-0.5, width - 0.5) across.
Example: `Camera(640, 480, [[600, 0, 320], [0, 600, 240], [0, 0, 1]])`.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Mask, frozen, last_axes
from geometry.camera_checks import camera_mistakes
from geometry.distortion import distort, undistort
from geometry.errors import CameraError
from geometry.frames import inverse
from geometry.mistakes import told

if TYPE_CHECKING:
    from collections.abc import Mapping

NEAREST = 1e-6  # m; what is not farther than this in front of the camera has no image


@dataclass(frozen=True, eq=False)
class Camera:
    """One camera: size in pixels, `K` (3, 3), `dist` (0, 4, 5, 8, 12 or 14,), and its pose in the world if known.

    Raises:
        CameraError: listing everything that is wrong with the numbers.
    """

    width: int
    height: int
    K: Floats
    dist: Floats = field(default_factory=lambda: np.zeros(0))
    world_from_camera: Floats | None = None

    def __post_init__(self) -> None:
        """Check everything, and keep read-only copies."""
        mistakes = camera_mistakes(
            {
                "width": self.width,
                "height": self.height,
                "K": self.K,
                "dist": self.dist,
                "T_world_camera": self.world_from_camera,
            }
        )
        if mistakes:
            raise CameraError(told(mistakes, "; "))
        object.__setattr__(self, "K", frozen(self.K))
        object.__setattr__(self, "dist", frozen(self.dist))
        if self.world_from_camera is not None:
            object.__setattr__(self, "world_from_camera", frozen(self.world_from_camera))

    @cached_property
    def f(self) -> float:
        """Mean focal length, px: what lobes' ranges scale by (formalism §2.7)."""
        return float(self.K[0, 0] + self.K[1, 1]) / 2

    @cached_property
    def camera_from_world(self) -> Floats | None:
        """The inverse of `world_from_camera` (4, 4), None where the camera does not know its place."""
        return None if self.world_from_camera is None else frozen(inverse(self.world_from_camera))

    def project(self, points_camera: ArrayLike) -> Floats:
        """Pixels (..., 2) of `points_camera` (..., 3) m; NaN rows for z <= 1e-6 m and past the lens' fold."""
        points = last_axes(points_camera, (3,), "points_camera")
        front = points[..., 2:] > NEAREST
        ideal = np.where(front, points[..., :2] / np.where(front, points[..., 2:], 1.0), np.nan)
        return self.to_pixels(distort(ideal, self.dist))

    def normalised(self, uv: ArrayLike) -> Floats:
        """Ideal image points x/z, y/z (..., 2) of the pixels `uv` (..., 2): undistorted; NaN where there are none."""
        return undistort(self.from_pixels(last_axes(uv, (2,), "uv")), self.dist)

    def rays(self, uv: ArrayLike) -> Floats:
        """Unit directions (..., 3) in the camera frame along which the pixels `uv` (..., 2) look."""
        ideal = self.normalised(uv)
        ray = np.concatenate([ideal, np.ones((*ideal.shape[:-1], 1))], axis=-1)
        return np.asarray(ray / np.linalg.norm(ray, axis=-1, keepdims=True))

    def contains(self, uv: ArrayLike) -> Mask:
        """Mask (...) of the pixels `uv` (..., 2) that lie in the image; NaN lies outside."""
        pixels = last_axes(uv, (2,), "uv")
        return np.asarray(((pixels >= -0.5) & (pixels < [self.width - 0.5, self.height - 0.5])).all(axis=-1))

    def to_pixels(self, xy: Floats) -> Floats:
        """Pixels (..., 2) of normalised points `xy` (..., 2) by `K` alone."""
        return np.asarray(xy @ self.K[:2, :2].T + self.K[:2, 2])

    def from_pixels(self, uv: Floats) -> Floats:
        """Normalised points (..., 2) of pixels `uv` (..., 2) by `K` alone."""
        return np.asarray((uv - self.K[:2, 2]) @ np.linalg.inv(self.K[:2, :2]).T)


def camera_to_dict(camera: Camera) -> dict[str, Any]:
    """The contract's `camera` key of `camera`: width, height, K, dist, and T_world_camera where known."""
    document: dict[str, Any] = {
        "width": int(camera.width),
        "height": int(camera.height),
        "K": camera.K.tolist(),
        "dist": camera.dist.tolist(),
    }
    if camera.world_from_camera is not None:
        document["T_world_camera"] = camera.world_from_camera.tolist()
    return document


def camera_from_dict(document: object, where: str = "camera") -> Camera:
    """The camera that the contract's `camera` key describes.

    Raises:
        CameraError: naming each wrong key as `where.key`, all on one line.
    """
    mistakes = camera_mistakes(document, where)
    if mistakes:
        raise CameraError(told(mistakes, "; "))
    camera = cast("Mapping[str, Any]", document)
    return Camera(camera["width"], camera["height"], camera["K"], camera.get("dist", []), camera.get("T_world_camera"))
