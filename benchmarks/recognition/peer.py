"""The peer of ``plogic bench recognition``.

SIFT, the ratio test against a type's learned keypoints, OpenCV's USAC RANSAC per type.

It gets its best: exact nearest neighbours instead of approximate ones, the next best of *another* feature in the ratio
test (a learned feature has many descriptors), local optimisation, several instances of a type, Levenberg-Marquardt on
the inliers, and of all that it may look at (SIFT's keypoints, or the points along edges that ours sees as well), its
ratios, inlier thresholds and minimal numbers of inliers those that are best over all scenes, chosen with the truth
known.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from time import perf_counter
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from benchmarks.recognition.score import Found

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from geometry.camera import Camera

SEEN = ("keypoints", "edges too")
"""What the peer looks at: SIFT's keypoints, or points along edges besides."""
RATIOS = (0.7, 0.8, 0.9)
THRESHOLDS = (1.5, 3.0, 5.0, 8.0)
"""Pixels within which a match is an inlier."""
LEAST_INLIERS = tuple(range(5, 41))
"""Numbers of inliers at which a pose may be accepted; all are tried."""
FEWEST = 5
WIDTH = 128
"""Bytes of a descriptor that are SIFT's; the others are colours."""
ITERATIONS, CONFIDENCE = 20_000, 0.999
INSTANCES = 2
"""Poses of one type that are looked for in an image, one after the other in what is left."""


class Learned(Protocol):
    """What the peer needs of a type: F places and L descriptors of them (a ``LearnedCloud``)."""

    @property
    def at(self) -> NDArray[np.float64]:
        """(F, 3) m, object frame."""

    @property
    def feature(self) -> NDArray[np.integer[Any]]:
        """(L,) whose descriptor it is."""

    @property
    def descriptor(self) -> NDArray[np.uint8]:
        """(L, 128) SIFT, or more: the others are left out."""


@dataclass(frozen=True)
class Setting:
    """What is looked at, ratio of the ratio test, inlier threshold in pixels, inliers at which a pose is accepted."""

    seen: str
    ratio: float
    threshold: float
    inliers: int = FEWEST

    def __str__(self) -> str:
        """As the benchmark prints it."""
        return f"{self.seen}, ratio {self.ratio:g}, {self.threshold:g} px, {self.inliers} inliers"


@dataclass(frozen=True, eq=False)
class Candidate:
    """A pose that RANSAC came to, and its inliers."""

    found: Found
    inliers: int


@dataclass(frozen=True, eq=False)
class Matches:
    """Per keypoint of the image (N).

    Place (N, 2), the nearest feature's place in the object (N, 3), the ratio to the next feature (N,).
    """

    uv: NDArray[np.float64]
    at: NDArray[np.float64]
    ratio: NDArray[np.float64]


Candidates = dict[tuple[str, float, float], list[Candidate]]
"""By what is looked at, ratio and threshold, of one image and all types."""


class Peer:
    """``Peer({"cracker_box": cloud, ...}).candidates(image, camera)``."""

    def __init__(self, learned: Mapping[str, Learned], seen: Sequence[str] = SEEN) -> None:
        """Sort each type's descriptors by feature; a type of fewer than two features is left out.

        ``seen``, of ``SEEN``: what it looks at.
        """
        self._seen = tuple(seen)
        self._types = {name: _sorted(cloud) for name, cloud in learned.items() if len(np.unique(cloud.feature)) > 1}

    def candidates(
        self, image: NDArray[np.uint8], camera: Camera, limit: float = np.inf
    ) -> tuple[Candidates, dict[str, float]]:
        """Of all settings, the poses with at least ``FEWEST`` inliers.

        And of all that it looks at, the seconds that one setting takes on average.

        What has not been tried after ``limit`` seconds is left out.
        """
        answer: Candidates = {setting: [] for setting in product(self._seen, RATIOS, THRESHOLDS)}
        begun, seconds = perf_counter(), dict.fromkeys(self._seen, 0.0)
        for seen in self._seen:
            start = perf_counter()
            matches = self._matches(image, edges=seen != SEEN[0])
            shared = perf_counter() - start
            for ratio, threshold in product(RATIOS, THRESHOLDS):
                for name, found in matches.items():
                    if perf_counter() - begun < limit:
                        answer[seen, ratio, threshold] += _poses(name, found, camera, ratio, threshold)
            seconds[seen] = shared + (perf_counter() - start - shared) / (len(RATIOS) * len(THRESHOLDS))
        return answer, seconds

    def _matches(self, image: NDArray[np.uint8], *, edges: bool) -> dict[str, Matches]:
        from sensing.detectors.keypoint_detector import described
        from sensing.detectors.keypoints import keypoints

        seen = described(image) if edges else keypoints(image)
        return (
            {
                name: _matches(np.asarray(seen.uv), seen.descriptors[:, :WIDTH], *rows)
                for name, rows in self._types.items()
            }
            if len(seen)
            else {}
        )


def accepted(candidates: Candidates, setting: Setting) -> list[Found]:
    """What the peer reports of one image at one setting."""
    return [c.found for c in candidates[setting.seen, setting.ratio, setting.threshold] if c.inliers >= setting.inliers]


def settings(seen: Sequence[str] = SEEN) -> Iterator[Setting]:
    """All that are tried where it looks at ``seen``."""
    return (Setting(*values) for values in product(seen, RATIOS, THRESHOLDS, LEAST_INLIERS))


def _sorted(cloud: Learned) -> tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.float64]]:
    """Descriptors (L, 128) in the order of features, each described feature's first row (G,) and place (G, 3)."""
    order = np.argsort(cloud.feature, kind="stable")
    which, first = np.unique(np.asarray(cloud.feature)[order], return_index=True)
    return np.asarray(cloud.descriptor[:, :WIDTH], np.float32)[order], first, np.asarray(cloud.at, np.float64)[which]


def _matches(
    uv: NDArray[np.float64],
    seen: NDArray[np.uint8],
    learned: NDArray[np.float32],
    first: NDArray[np.int64],
    at: NDArray[np.float64],
) -> Matches:
    """Each keypoint's nearest feature, exactly."""
    mine = np.asarray(seen, np.float32)
    square = (mine**2).sum(axis=1)[:, None] + (learned**2).sum(axis=1) - 2 * mine @ learned.T
    by_feature = np.minimum.reduceat(square, first, axis=1)
    best = by_feature.argmin(axis=1)
    rows = np.arange(len(mine))
    nearest = np.sqrt(np.maximum(by_feature[rows, best], 0))
    by_feature[rows, best] = np.inf
    second = np.sqrt(np.maximum(by_feature.min(axis=1), 1e-9))
    return Matches(uv, at[best], (nearest / second).astype(np.float64))


def _poses(name: str, matches: Matches, camera: Camera, ratio: float, threshold: float) -> list[Candidate]:
    """Up to ``INSTANCES`` poses, each from the matches that those before have left."""
    kept = np.flatnonzero(matches.ratio < ratio)
    kept = kept[np.argsort(matches.ratio[kept], kind="stable")]
    uv, at = matches.uv[kept], matches.at[kept]
    poses: list[Candidate] = []
    while len(poses) < INSTANCES:
        found = _ransac(at, uv, camera, threshold)
        if found is None:
            break
        pose, inlying = found
        poses.append(Candidate(Found(name, pose, 1.0), _support(at[inlying])))
        uv, at = uv[~inlying], at[~inlying]
    return [c for c in poses if c.inliers >= FEWEST]


def _support(at: NDArray[np.float64]) -> int:
    """Inliers of different features: two keypoints at one place are one."""
    return len(np.unique(np.round(at, 6), axis=0))


def _ransac(
    at: NDArray[np.float64], uv: NDArray[np.float64], camera: Camera, threshold: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]] | None:
    """``camera_from_object`` (4, 4), refined, and the mask (N,) of its inliers.

    None where there is no pose in front of the camera.
    """
    import cv2

    if len(uv) < FEWEST or _support(at) < FEWEST:
        return None
    K, dist = np.asarray(camera.K, np.float64), np.asarray(camera.dist, np.float64)
    try:
        done, _, rvec, tvec, chosen = cv2.solvePnPRansac(at, uv, K.copy(), dist, params=_usac(threshold))
    except cv2.error:  # its minimal solver gives up on some samples
        return None
    if not done or chosen is None or len(chosen) < FEWEST:
        return None
    picked = np.asarray(chosen).reshape(-1)
    rvec, tvec = cv2.solvePnPRefineLM(at[picked], uv[picked], K, dist, rvec, tvec)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(rvec)[0], np.asarray(tvec).reshape(3)
    inlying = _inlying(pose, at, uv, camera, threshold)
    return (pose, inlying) if inlying.sum() >= FEWEST else None


def _usac(threshold: float) -> Any:  # noqa: ANN401 - cv2.UsacParams, as OpenCV 4 and 5 name it alike
    import cv2

    params: Any = cv2.UsacParams()
    params.threshold, params.maxIterations, params.confidence = threshold, ITERATIONS, CONFIDENCE
    params.sampler, params.score = cv2.SAMPLING_UNIFORM, cv2.SCORE_METHOD_MSAC
    params.loMethod, params.loIterations, params.loSampleSize = cv2.LOCAL_OPTIM_INNER_LO, 10, 14
    params.isParallel, params.randomGeneratorState = False, 0
    return params


def _inlying(
    pose: NDArray[np.float64], at: NDArray[np.float64], uv: NDArray[np.float64], camera: Camera, threshold: float
) -> NDArray[np.bool_]:
    points = at @ pose[:3, :3].T + pose[:3, 3]
    if not np.isfinite(points).all() or (points[:, 2] <= 0).all():
        return np.zeros(len(at), dtype=bool)
    away = np.linalg.norm(camera.project(points) - uv, axis=1)
    return np.asarray(np.nan_to_num(away, nan=np.inf) <= threshold)


def best_setting(score: Mapping[Setting, float]) -> Setting:
    """The one with the highest score; of equals, the first."""
    return max(score, key=lambda setting: score[setting])
