"""A calibrated stereo pair as one notional viewpoint (§3.3), the left camera's.

Its appearances carry depth where the right camera tells it.

An appearance of the left image is found again in the right one by its type, what the detector says of it, and the
epipolar line. Where more than one fits, its depth is not told: a wrong depth is worse than none.

* ``Pair``: how the right camera stands beside the left, ``Pair(right_from_left)``

How a stereo pair is calibrated, as a file: ``stereo/1``.

``{"format": "stereo/1", "T_right_left": 4x4, "left": {camera}, "right": {camera}}``: ``T_right_left`` maps points of
the left camera's frame to the right one's, metres; the cameras are needed for images, and left out where both inputs
are Γ files, which have their own.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal, NamedTuple, NotRequired, TypedDict, cast

import numpy as np

from geometry.arrays import Floats, Mask, frozen
from geometry.camera import Camera, camera_from_dict, camera_mistakes
from geometry.camera_row import RIGID, CameraRow, Pose
from geometry.errors import CameraError, Mistake, told
from geometry.files.documents import read_json
from geometry.files.plain_files import must_be_plain
from geometry.files.pose_files import nearest_rigid
from geometry.frames import is_rigid, transform_points
from sensing.appearance import Appearance, Gamma

LARGEST = 2**20
"""Bytes of such a file that are read."""
HOLDS = 'should be {"format": "stereo/1", "T_right_left": 4x4, "left": {camera}, "right": {camera}}'


OFF = 3.0
"""Standard deviations of a place within which an appearance lies on the epipolar line of its partner."""
NEAREST = 0.02
"""Metres, least depth that is believed."""
TURNED, LARGER = 0.5, 1.6
"""Radians by which the angles, and the factor by which the scales, of one feature's appearances in the two images
differ at most."""
MOST = 30_000_000
"""Pairs of appearances that are compared at most, some 100 bytes each while that goes on: two images of 5,000."""
ALIKE = 0.8
"""Of descriptors, the next best partner must be this much farther: Lowe's ratio."""


@dataclass(frozen=True, eq=False)
class Pair:
    """``right_from_left`` (4, 4): points of the left camera's frame in the right one's, metres.

    Raises CameraError where it is no such pose.
    """

    right_from_left: Floats

    def __post_init__(self) -> None:
        """Keep a read-only pose."""
        if not is_rigid(self.right_from_left) or not np.linalg.norm(np.asarray(self.right_from_left)[:3, 3]) > 0.0:
            raise CameraError("T_right_left must be a rotation and a translation that is not zero")
        object.__setattr__(self, "right_from_left", frozen(self.right_from_left))


def fused(left: Gamma, right: Gamma, pair: Pair, sigma: float = 1.0) -> Gamma:
    """Γ of the pair: the left one's appearances, with ``depth`` and ``depth_sigma`` (m) where they are known.

    A depth is known where one appearance of the right image is the same feature's, and no other.

    ``sigma``: noise of places, pixels, in both images. Raises CameraError where there are more than ``MOST`` to
    compare, one with another.
    """
    if len(left.appearances) * len(right.appearances) > MOST:
        numbers = f"{len(left.appearances)} and {len(right.appearances)} appearances"
        raise CameraError(f"{numbers} are more than a pair may have: {MOST} to compare at most")
    near, depth = _partners(left, right, pair, sigma)
    found = _unique(left, right, near)
    rows = list(left.appearances)
    for i, j in found:
        spread = _sigma(left.camera, left.uv[i], float(depth[i, j]), pair, sigma)
        rows[i] = replace(rows[i], depth=float(depth[i, j]), depth_sigma=spread)
    return Gamma(left.camera, tuple(rows))


def _partners(left: Gamma, right: Gamma, pair: Pair, sigma: float) -> tuple[Mask, Floats]:
    """(L, R) which may be appearances of one feature, and the depth (L, R) m before the left camera that they tell."""
    count = len(left.appearances), len(right.appearances)
    if 0 in count:
        return np.zeros(count, bool), np.zeros(count)
    a, b = (np.asarray(gamma.camera.normalised(gamma.uv)) for gamma in (left, right))
    turned = np.concatenate([a, np.ones((len(a), 1))], axis=1) @ pair.right_from_left[:3, :3].T  # (L, 3) right frame
    t = pair.right_from_left[:3, 3]
    depth = _depths(turned, b, t)
    placed = turned[:, None] * depth[..., None] + t
    f = right.camera.f
    with np.errstate(divide="ignore", invalid="ignore"):
        off = f * np.linalg.norm(placed[..., :2] / placed[..., 2:] - b[None], axis=2)
    near = (off <= OFF * np.sqrt(2.0) * sigma) & (depth > NEAREST) & (placed[..., 2] > NEAREST)
    return near & _alike(left.appearances, right.appearances), depth


def _depths(turned: Floats, b: Floats, t: Floats) -> Floats:
    """(L, R) the depth at which a left ray (L, 3) comes nearest to a right pixel (R, 2) on its line.

    Rays in the right frame per metre of depth.
    """
    # x_right = (d·turned + t), and b·z = xy: two equations in d, in least squares
    slope = turned[:, None, :2] - b[None] * turned[:, None, 2:]
    rest = b * t[2] - t[:2]
    square = (slope**2).sum(axis=2)
    return np.asarray((slope * rest[None]).sum(axis=2) / np.where(square > 1e-18, square, np.inf))


def _alike(left: tuple[Appearance, ...], right: tuple[Appearance, ...]) -> Mask:
    """(L, R) of one type, and alike in angle and scale where both have them."""
    types = np.array([a.type for a in left])[:, None] == np.array([a.type for a in right])[None]
    angles = [np.array([np.nan if a.angle is None else a.angle for a in some]) for some in (left, right)]
    scales = [np.array([np.nan if a.scale is None else a.scale for a in some]) for some in (left, right)]
    turn = np.abs((angles[0][:, None] - angles[1][None] + np.pi) % (2.0 * np.pi) - np.pi)
    larger = np.abs(np.log(scales[0])[:, None] - np.log(scales[1])[None])
    return np.asarray(types & ~(turn > TURNED) & ~(larger > np.log(LARGER)))


def _unique(left: Gamma, right: Gamma, near: Mask) -> list[tuple[int, int]]:
    """Pairs of which neither has another partner.

    Of keypoints, of which the descriptors say that no other is nearly as like.
    """
    cost = np.where(near, _unlikeness(left, right, near), np.inf)
    if not cost.size:
        return []
    best_right, best_left = cost.argmin(axis=1), cost.argmin(axis=0)
    mutual = [i for i in range(len(cost)) if np.isfinite(cost[i, best_right[i]]) and best_left[best_right[i]] == i]
    return [
        (i, int(best_right[i]))
        for i in mutual
        if _clear(cost[i], int(best_right[i])) and _clear(cost[:, best_right[i]], i)
    ]


def _clear(costs: Floats, best: int) -> bool:
    others = np.delete(costs, best)
    return bool(costs[best] < ALIKE * others.min()) if len(others) and np.isfinite(others.min()) else True


def _unlikeness(left: Gamma, right: Gamma, near: Mask) -> Floats:
    """(L, R) the distance of descriptors; 1 where there are none to compare."""
    result = np.ones(near.shape)
    for i, j in np.argwhere(near):
        one, other = left.appearances[i].descriptor, right.appearances[j].descriptor
        if one is not None and other is not None and len(one) == len(other):
            result[i, j] = np.linalg.norm(
                np.frombuffer(one, np.uint8).astype(float) - np.frombuffer(other, np.uint8).astype(float)
            )
    return result


def _sigma(camera: Camera, uv: Floats, depth: float, pair: Pair, sigma: float) -> float:
    """Standard deviation of a depth, metres: of what both places' noise makes along the epipolar line."""
    ray = np.append(np.asarray(camera.normalised(uv[None]))[0], 1.0)
    ends = transform_points(pair.right_from_left, np.stack([ray * depth, ray * (depth * 1.001)]))
    step = np.linalg.norm(ends[1, :2] / ends[1, 2] - ends[0, :2] / ends[0, 2]) / (0.001 * depth)  # normalised, a metre
    return float(np.sqrt(2.0) * sigma / camera.f / max(step, 1e-12))


class StereoRow(TypedDict):
    """How a stereo pair is calibrated."""

    format: Literal["stereo/1"]
    T_right_left: Annotated[Pose, "Maps the left camera's coordinates to the right one's; row-major, metres."]
    left: NotRequired[Annotated[CameraRow, "The left camera; needed where the inputs are images."]]
    right: NotRequired[Annotated[CameraRow, "The right camera; needed where the inputs are images."]]


class Calibration(NamedTuple):
    """The pair, and its cameras where the file has them."""

    pair: Pair
    left: Camera | None
    right: Camera | None


def read_stereo(path: Path | str) -> Calibration:
    """The calibration of a file. Raises CameraError, a line a mistake."""
    must_be_plain(path, CameraError, LARGEST)
    document = read_json(path, LARGEST, HOLDS, CameraError, single=True)
    given = document.data if isinstance(document.data, dict) and not document.is_other(StereoRow) else {}
    sides = [side for side in ("left", "right") if side in given]
    wrong = [mistake for mistake in document.against(StereoRow) if mistake.place[:1] not in {("left",), ("right",)}]
    wrong += [mistake for side in sides for mistake in camera_mistakes(given[side], (side,))]
    if wrong:
        raise CameraError(told(document.told(wrong)))
    row = cast("StereoRow", document.data)
    pose = nearest_rigid(row["T_right_left"])
    if pose is None or not np.linalg.norm(pose[:3, 3]) > 0.0:
        what = RIGID if pose is None else "must be a rotation and a translation that is not zero"
        raise CameraError(told(document.told([Mistake(("T_right_left",), what)])))
    cameras = {side: camera_from_dict(given[side]) for side in sides}
    return Calibration(Pair(pose), cameras.get("left"), cameras.get("right"))
