"""A peer of ``plogic bench clutter``: poselib's LO-RANSAC on typed correspondences."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.clutter.pairs import different, ideal, typed
from benchmarks.shared.processor import processor_seconds
from plogic.match.judged.expectation import FEWEST

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from benchmarks.clutter.pairs import Answer
    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.plain.quadruples import Typed
    from sensing.appearance import Gamma

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

FIRST = 200
"""Iterations of LO-RANSAC a type in the first round; each round has twice as many as the one before."""
MOST = 1_000_000
"""Iterations a type after which nobody would wait for more."""
SURE = 0.9999
"""Probability to have drawn a set without outliers at which RANSAC stops by itself."""


def lo_ransac(kb: KnowledgeBase, gamma: Gamma, budget_seconds: float) -> Answer | None:
    """Poselib's LO-RANSAC (P3P, local optimisation, bundle adjustment) on the typed correspondences of every type.

    The most inliers win.

    It gets its best: rounds over all types, each of twice as many iterations from another seed, until the time is over,
    and the best of all; the tolerance of the KB for inliers; pairs that share a feature or a datum counted once.
    """
    end = processor_seconds() + budget_seconds
    kinds, uv = typed(kb, gamma), ideal(gamma)
    best: tuple[tuple[int, float], Answer] | None = None
    turn, iterations = 0, FIRST
    while iterations <= MOST:
        for pairs in kinds:
            if processor_seconds() > end:
                return best[1] if best else None
            pose, inlying, score = estimated(pairs, uv, gamma.camera, kb, iterations, turn)
            worth = different(pairs, inlying), -score
            if worth[0] >= FEWEST and (best is None or worth > best[0]):
                best = worth, (pairs.kind.name, pose)
        turn, iterations = turn + 1, 2 * iterations
    return best[1] if best else None


def estimated(
    pairs: Typed, uv: Floats, camera: Camera, kb: KnowledgeBase, iterations: int, seed: int = 0
) -> tuple[Floats, Indices, float]:
    """Of one type ``camera_from_object`` (4, 4), the pairs (N,) that agree with it, and poselib's score.

    A lower score is better; ``uv`` (A, 2) ideal px.
    """
    poselib: Any = import_module("poselib")
    options = {"max_iterations": iterations, "min_iterations": min(iterations, 100), "success_prob": SURE, "seed": seed}
    options["max_reproj_error"] = kb.rates.match_tolerance
    bundle = {"loss_type": "CAUCHY", "loss_scale": kb.rates.sigma}
    pose, found = poselib.estimate_absolute_pose(
        uv[pairs.datum], pairs.points[pairs.feature], _pinhole(camera), options, bundle
    )
    return _matrix(pose), np.flatnonzero(found["inliers"]), float(found["model_score"])


def _pinhole(camera: Camera) -> dict[str, Any]:
    K = camera.K
    return {
        "model": "PINHOLE",
        "width": camera.width,
        "height": camera.height,
        "params": [K[0, 0], K[1, 1], K[0, 2], K[1, 2]],
    }


def _matrix(pose: Any) -> Floats:  # noqa: ANN401 - poselib has no types
    return np.vstack([np.asarray(pose.Rt, np.float64), [0.0, 0.0, 0.0, 1.0]])
