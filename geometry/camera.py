"""A pinhole camera with OpenCV's lens distortion.

Frame: x right, y down, z forward. An integer pixel is a pixel's centre, so the image spans [-0.5, width - 0.5) across.
Example: `Camera(640, 480, [[600, 0, 320], [0, 600, 240], [0, 0, 1]])`.

What a camera description must satisfy, ``CameraRow``; every mistake is named by its key, all of them at once.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Mask, frozen, last_axes
from geometry.camera_row import LARGEST, LENGTHS, RIGID, SHORTEST, STRONGEST, CameraRow
from geometry.errors import CameraError, Keys, Mistake, told
from geometry.frames import inverse, is_rigid
from geometry.json_checks import check_of

_ROUNDS = 30  # of Newton's method in `undistort`; five are enough for a usual lens
_STEP = 1e-6  # for its central differences
_FOUND = 1e-8  # how near the distorted solution must come, in normalised units (6e-6 px at f = 600)


def distort(xy: Floats, dist: Floats) -> Floats:
    """Where the ideal points `xy` (..., 2) = x/z, y/z appear (..., 2) after the lens `dist` (k,); NaN past its fold."""
    if not np.any(dist):
        return xy
    inside = np.linalg.norm(xy, axis=-1, keepdims=True) < fold_radius(dist)
    return np.where(inside, _lens(np.where(inside, xy, 0.0), _padded(dist)), np.nan)


def undistort(xy: Floats, dist: Floats) -> Floats:
    """The ideal points (..., 2) that appear at `xy` (..., 2), by Newton's method; NaN where there is none."""
    if not np.any(dist):
        return xy
    k, edge = _padded(dist), fold_radius(dist)
    guess = np.where(np.isfinite(xy), xy, 0.0)
    target = guess
    for _ in range(_ROUNDS):
        off = _lens(guess, k) - target
        guess = _within(guess - _solve2(_slopes(guess, k), off), edge)
        if np.abs(off).max(initial=0.0) < _FOUND / 100:
            break
    found = np.abs(_lens(guess, k) - target).max(axis=-1, keepdims=True) < _FOUND
    return np.where(found & np.isfinite(xy), guess, np.nan)


def fold_radius(dist: Floats) -> float:
    """The first ideal radius at which the radial part stops growing, inf if none: past it a lens model shows ghosts."""
    k1, k2, _, _, k3, k4, k5, k6 = _padded(dist)[:8]
    up = np.polynomial.Polynomial([1.0, k1, k2, k3])  # in s = r^2
    down = np.polynomial.Polynomial([1.0, k4, k5, k6])
    s = np.polynomial.Polynomial([0.0, 1.0])
    slope = up * down + 2 * s * (up.deriv() * down - up * down.deriv())  # d(r up/down)/dr times down^2
    roots = [*slope.trim(1e-15).roots(), *down.trim(1e-15).roots()]
    real = [float(root.real) for root in roots if abs(root.imag) < 1e-9 and root.real > 0]
    return float(np.sqrt(min(real))) if real else float("inf")


def _padded(dist: Floats) -> Floats:
    return np.concatenate([dist, np.zeros(14 - len(dist))])


def _lens(xy: Floats, k: Floats) -> Floats:
    """OpenCV's formula, in its own names."""
    x, y = xy[..., 0], xy[..., 1]
    r2 = x * x + y * y
    radial = (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])))
    u = x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + r2 * (k[8] + r2 * k[9])
    v = y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + r2 * (k[10] + r2 * k[11])
    return _tilted(np.stack([u, v], axis=-1), k[12], k[13])


def _tilted(xy: Floats, tau_x: float, tau_y: float) -> Floats:
    """The points `xy` (..., 2) on a sensor tilted by the two angles (rad) against the lens."""
    if tau_x == 0 and tau_y == 0:
        return xy
    (cx, cy), (sx, sy) = np.cos([tau_x, tau_y]), np.sin([tau_x, tau_y])
    turn = np.array([[cy, 0, -sy], [0, 1, 0], [sy, 0, cy]]) @ np.array([[1, 0, 0], [0, cx, sx], [0, -sx, cx]])
    onto = np.array([[turn[2, 2], 0, -turn[0, 2]], [0, turn[2, 2], -turn[1, 2]], [0, 0, 1]]) @ turn
    raised = xy @ onto[:, :2].T + onto[:, 2]
    return np.asarray(raised[..., :2] / raised[..., 2:])


def _slopes(xy: Floats, k: Floats) -> Floats:
    """Jacobian (..., 2, 2) of the lens by central differences."""
    steps = np.eye(2) * _STEP
    return np.stack([(_lens(xy + step, k) - _lens(xy - step, k)) / (2 * _STEP) for step in steps], axis=-1)


def _solve2(matrix: Floats, right: Floats) -> Floats:
    """Solutions (..., 2) of 2x2 systems; a singular one gives a zero step."""
    (a, b), (c, d) = np.moveaxis(matrix, (-2, -1), (0, 1))
    det = a * d - b * c
    safe = np.where(np.abs(det) > 1e-12, det, np.inf)
    p, q = right[..., 0], right[..., 1]
    return np.stack([(d * p - b * q) / safe, (a * q - c * p) / safe], axis=-1)


def _within(xy: Floats, edge: float) -> Floats:
    """`xy` (..., 2) drawn back inside the fold."""
    if not np.isfinite(edge):
        return xy
    radius = np.linalg.norm(xy, axis=-1, keepdims=True)
    return np.asarray(xy * np.minimum(1.0, 0.999 * edge / np.maximum(radius, 1e-12)))


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
                "width": _plain(self.width),
                "height": _plain(self.height),
                "K": _plain(self.K),
                "dist": _plain(self.dist),
                "T_world_camera": _plain(self.world_from_camera),
            }
        )
        if mistakes:
            raise CameraError(told([mistake.below("camera") for mistake in mistakes], "; "))
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

    def resized(self, width: int, height: int) -> "Camera":
        """The camera of the same picture at another size, px; an integer is a pixel's centre in both."""
        by = np.array([width / self.width, height / self.height])
        K = self.K.copy()
        K[:2] *= by[:, None]
        K[:2, 2] += 0.5 * (by - 1.0)
        return Camera(width, height, K, self.dist, self.world_from_camera)

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


def centred_camera(size: tuple[int, int], f: float) -> Camera:
    """A camera without distortion, fx = fy = `f` px, its centre at the middle of an image of `size` (width, height)."""
    width, height = size
    return Camera(width, height, np.array([[f, 0, (width - 1) / 2], [0, f, (height - 1) / 2], [0, 0, 1.0]]))


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
    mistakes = camera_mistakes(document, (where,))
    if mistakes:
        raise CameraError(told(mistakes, "; "))
    camera = cast("CameraRow", document)
    pose = camera.get("T_world_camera")
    return Camera(
        camera["width"],
        camera["height"],
        np.asarray(camera["K"], dtype=float),
        np.asarray(camera.get("dist", []), dtype=float),
        None if pose is None else np.asarray(pose, dtype=float),
    )


def camera_mistakes(document: object, keys: Keys = ()) -> list[Mistake]:
    """Each mistake in a `CameraRow` that stands under these keys; none of a good camera."""
    if not isinstance(document, Mapping):
        return [Mistake(keys, f"must be an object with the keys width, height and K, not {_shown(document)}")]
    ruled = {key: wrong for key, rule in RULES.items() if key in document and (wrong := rule(document[key]))}
    found = [mistake for mistake in check_of(CameraRow)(dict(document)) if mistake.place[0] not in ruled]
    found += [Mistake((key,), wrong) for key, wrong in ruled.items()]
    return [mistake.below(*keys) for mistake in found]


def _plain(value: object) -> object:
    """Arrays and tuples as the lists that JSON has."""
    value = value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
    return [_plain(each) for each in value] if isinstance(value, (list, tuple)) else value


def _matrix(value: object) -> str:
    K = _numbers(value)
    if K is None or K.shape != (3, 3):
        return f"must be a 3x3 matrix of finite numbers, not {_shown(value)}"
    if not (K[0, 0] > 0 and K[1, 1] > 0):
        return f"focal lengths must be positive, not {K[0, 0]:g} and {K[1, 1]:g}"
    if min(K[0, 0], K[1, 1]) < SHORTEST or np.abs(K).max() > LARGEST:
        return f"focal lengths must be at least {SHORTEST:g} px, and no number above {LARGEST:g}, not {_shown(value)}"
    if K[1, 0] != 0 or K[2].tolist() != [0, 0, 1]:
        return f"must be [[fx, skew, cx], [0, fy, cy], [0, 0, 1]], not {_shown(value)}"
    return ""


def _dist(value: object) -> str:
    dist = _numbers(value)
    if dist is None or dist.ndim != 1 or len(dist) not in LENGTHS:
        return f"must be a list of {', '.join(map(str, LENGTHS))} finite numbers, not {_shown(value)}"
    if np.abs(dist).max(initial=0.0) > STRONGEST:
        return f"no coefficient may be above {STRONGEST:g}, not {_shown(value)}"
    return ""


def _pose(value: object) -> str:
    if value is None:
        return ""
    pose = _numbers(value)
    if pose is None or not is_rigid(pose):
        return f"{RIGID}, not {_shown(value)}"
    if np.abs(pose).max() > LARGEST:
        return f"no number may be above {LARGEST:g} m, not {_shown(value)}"
    return ""


RULES: dict[str, Callable[[object], str]] = {"K": _matrix, "dist": _dist, "T_world_camera": _pose}
"""What is wrong with the numbers of a key, in one sentence: it has better words than the shape."""


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
