"""Expected and Detected of a type by hand at a pose (D7, D8), where a detector's angles count.

What lies at another angle is not right.

Least squares are on places and angles: an angle tells how a feature is turned in space, most where its x axis leads out
of the image plane.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Mask
from geometry.camera import Camera
from geometry.poses.refine import Sight, Steps, refined_poses
from geometry.poses.reprojection import WEIGHT, across, ends, reach
from kb.clouds.cloud import KnowledgeBase
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.gamma.grid import screen_angle, wrapped
from plogic.match.hand.hand_models import TypeIndex
from plogic.match.judged.expectation import FEWEST, matched, of_matches, pose_of, with_depths


class Noise(NamedTuple):
    """Standard deviations: ``pixels`` of a datum's place along one axis, ``angle`` of its angle, radians."""

    pixels: float
    angle: float


class Held(NamedTuple):
    """V matches that hold each of N poses.

    ``points``, ``turns`` (N, V, 3) places and x axes of the features, object frame; ``uv`` (N, V, 2) pixels, ``angle``
    (N, V) rad, NaN where a datum has none; ``weight`` (N, V), 0 where there is no match, else 1, or more where a place
    is more exact.
    """

    points: Floats
    turns: Floats
    uv: Floats
    angle: Floats
    weight: Floats


def refined(
    poses: Floats,
    held: Held,
    noise: Noise,
    camera: Camera,
    *,
    steps: int,
    robust: float | None = None,
    sigma: Floats | None = None,
) -> Floats:
    """(N, 4, 4) from poses (N, 4, 4); a residual beyond ``robust`` times the noise of places weighs less.

    ``sigma`` (N,): the noise of places of each pose, pixels, in place of that of all.
    """
    points, uv, weight, lines = met(poses, held, noise, camera, sigma)
    huber = None if robust is None else robust * noise.pixels
    return refined_poses(poses, points, uv, weight, camera, Steps(steps), huber=huber, across=lines)


def met(
    poses: Floats, held: Held, noise: Noise, camera: Camera, sigma: Floats | None = None
) -> tuple[Floats, Floats, Floats, Floats]:
    """What poses (N, 4, 4) are to meet, of places and then of angles, as ``refined_poses`` takes it.

    ``sigma`` as in ``refined``.

    Points (N, 2 V, 3) m, pixels (N, 2 V, 2), weights (N, 2 V) 1/pixel², and unit vectors across lines (N, 2 V, 2).
    """
    pixels = np.full((len(poses), 1), noise.pixels) if sigma is None else sigma[:, None]
    sided = np.isfinite(held.angle) & (held.weight > 0.0)
    lines = across(np.where(sided, held.angle, 0.0))
    depth = np.einsum("nj,nvj->nv", poses[:, 2, :3], held.points) + poses[:, None, 2, 3]
    return (
        np.concatenate(
            [held.points, ends(held.points, held.turns, depth, reach(pixels, noise.angle) / camera.f)], axis=1
        ),
        np.concatenate([held.uv, held.uv], axis=1),
        np.concatenate([held.weight, held.weight * sided * WEIGHT], axis=1) / pixels**2,
        np.concatenate([np.full(lines.shape, np.nan), lines], axis=1),
    )


DEVIATIONS = 3.0
"""Standard deviations within which an angle is right."""
STEPS = 8
"""Steps of a refinement."""
ROBUST = 3.0
"""Standard deviations of a place beyond which a match weighs less."""


def matched_at(
    index: TypeIndex,
    pose: Floats,
    data: Data,
    kb: KnowledgeBase,
    allowed: Mask,
    free: Mask | None = None,
    hidden: Mask | None = None,
) -> Hypothesis:
    """Matched with what is near, of a right type and at a right angle; a datum without an angle is right at any.

    ``likeness``: how much likelier the match's angle is than any.
    """
    assert kb.rates.sigma_angle is not None  # noqa: S101 - the caller looks
    sigma = kb.rates.sigma_angle
    posed = pose_of(index.object_type, pose, data, kb)
    axes = index.turns @ pose[:3, :3].T
    off = wrapped(data.angle[None] - screen_angle(axes, posed.at)[:, None])
    right = ~(np.abs(off) > DEVIATIONS * sigma)
    posed = replace(posed, right=posed.right & right)
    posed = matched(posed, data, allowed & right, kb.rates.match_tolerance, free, hidden)
    own = of_matches(off, posed.matches)
    bell = np.exp(-0.5 * (own / sigma) ** 2) * np.sqrt(2.0 * np.pi) / sigma
    # Where no datum has an angle nothing is searched for by angles either, and is to be as sure as without.
    count = np.isfinite(data.whole.angle).any()
    return replace(posed, likeness=np.where(np.isfinite(own), bell, 1.0), axes=axes if count else None)


def polished(index: TypeIndex, posed: Hypothesis, data: Data, kb: KnowledgeBase, hidden: Mask | None) -> Floats | None:
    """Least squares (4, 4) on places and angles of the detected expected features; None where below ``FEWEST``."""
    used = posed.expected(hidden) & posed.detected
    if used.sum() < FEWEST or kb.rates.sigma_angle is None:
        return None
    datum, weight = posed.matches[used], index.precision(kb.rates)[used]
    held = Held(
        *(rows[None] for rows in (index.points[used], index.turns[used], data.uv[datum], data.angle[datum], weight))
    )
    noise = Noise(kb.rates.sigma, kb.rates.sigma_angle)
    new = refined(posed.camera_from_object[None], held, noise, data.camera, steps=STEPS, robust=ROBUST)
    if data.depth is None:
        return np.asarray(new[0])
    seen = Sight(data.camera, np.eye(4), *(rows[0] for rows in met(new, held, noise, data.camera)))
    return with_depths(new[0], seen, datum, data, sigma=noise.pixels, huber=ROBUST * noise.pixels)
