"""A pinhole camera with OpenCV's lens distortion.

Frame: x right, y down, z forward. An integer pixel is a pixel's centre, so the image spans [-0.5, width - 0.5) across.
Example: `Camera(640, 480, [[600, 0, 320], [0, 600, 240], [0, 0, 1]])`.

What a camera description must satisfy; every mistake is named by its key, all of them at once.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Mask, frozen, last_axes
from geometry.distortion import LENGTHS, distort, undistort
from geometry.errors import CameraError, told
from geometry.frames import inverse, is_rigid

KEYS = ("width", "height", "K", "dist", "T_world_camera")
MAX_SIDE = 65536  # px
SHORTEST, LARGEST = (
    1e-3,
    1e9,
)  # px; focal lengths beyond, and larger numbers of a matrix, belong to no camera, and squares of them overflow
STRONGEST = 1e6  # a distortion coefficient; past a few thousand no lens is known


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


def camera_mistakes(document: object, where: str = "camera") -> list[str]:
    """Each mistake in the contract's `camera` key as one line `where.key: rule, value`; empty for a good camera."""
    if not isinstance(document, Mapping):
        return [f"{where}: must be an object with the keys width, height and K, not {_shown(document)}"]
    unknown = [f"{where}.{key}: unknown key; known are {', '.join(KEYS)}" for key in document if key not in KEYS]
    missing = [f"{where}.{key}: is missing" for key in KEYS[:3] if key not in document]
    sides = [_side(document[key], f"{where}.{key}") for key in KEYS[:2] if key in document]
    rest = [_matrix(document[key], f"{where}.K") for key in ("K",) if key in document]
    rest += [_dist(document.get("dist", []), f"{where}.dist")]
    rest += [_pose(document.get("T_world_camera"), f"{where}.T_world_camera")]
    return unknown + missing + [mistake for mistake in sides + rest if mistake]


def _side(value: object, where: str) -> str:
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if whole and 1 <= int(str(value)) <= MAX_SIDE:
        return ""
    return f"{where}: must be a whole number of pixels from 1 to {MAX_SIDE}, not {_shown(value)}"


def _matrix(value: object, where: str) -> str:
    K = _numbers(value)
    if K is None or K.shape != (3, 3):
        return f"{where}: must be a 3x3 matrix of finite numbers, not {_shown(value)}"
    if not (K[0, 0] > 0 and K[1, 1] > 0):
        return f"{where}: focal lengths must be positive, not {K[0, 0]:g} and {K[1, 1]:g}"
    if min(K[0, 0], K[1, 1]) < SHORTEST or np.abs(K).max() > LARGEST:
        return f"{where}: focal lengths must be at least {SHORTEST:g} px, and no number above {LARGEST:g}, not {_shown(value)}"
    if K[1, 0] != 0 or K[2].tolist() != [0, 0, 1]:
        return f"{where}: must be [[fx, skew, cx], [0, fy, cy], [0, 0, 1]], not {_shown(value)}"
    return ""


def _dist(value: object, where: str) -> str:
    dist = _numbers(value)
    if dist is None or dist.ndim != 1 or len(dist) not in LENGTHS:
        return f"{where}: must be a list of {', '.join(map(str, LENGTHS))} finite numbers, not {_shown(value)}"
    if np.abs(dist).max(initial=0.0) > STRONGEST:
        return f"{where}: no coefficient may be above {STRONGEST:g}, not {_shown(value)}"
    return ""


def _pose(value: object, where: str) -> str:
    if value is None:
        return ""
    pose = _numbers(value)
    if pose is None or not is_rigid(pose):
        return f"{where}: must be a rigid 4x4 matrix (row-major, metres), not {_shown(value)}"
    if np.abs(pose).max() > LARGEST:
        return f"{where}: no number may be above {LARGEST:g} m, not {_shown(value)}"
    return ""


def _numbers(value: object) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    """`value` as an array of finite numbers; None for anything else (texts and truth values are no numbers)."""
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):
        return None
    if array.size == 0:
        return array.astype(np.float64) if isinstance(value, (list, tuple, np.ndarray)) else None
    if array.dtype.kind not in "iuf":
        return None
    numbers = array.astype(np.float64)
    return numbers if np.isfinite(numbers).all() else None


def _shown(value: object) -> str:
    text = repr(value.tolist() if isinstance(value, np.ndarray) else value).replace("\n", " ")
    return text if len(text) <= 80 else text[:77] + "..."
