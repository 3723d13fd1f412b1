"""How a pose settles: match, refine on what was matched, match again (§7).

Where appearances carry depth (a stereo pair is one notional viewpoint, §3.3), depths fix poses. They do not decide what
is matched: some are wrong, where a feature was missed in one image and another that looks like it in the other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.camera import Camera
from geometry.frames import transform_points
from geometry.poses.refine import refined_poses
from geometry.poses.refine_sights import Sight, refine_sights
from plogic.facts.hypothesis import Hypothesis

if TYPE_CHECKING:
    from collections.abc import Callable

    from geometry.arrays import Floats, Indices, Mask
    from plogic.match.gamma.data import Data


DEVIATIONS, SHARE = 4.0, 0.05
"""A depth counts that is off a pose's by so many standard deviations at most, or by this share of it."""
BASELINE = 1000.0
"""Depths between the camera and one far to the side, whose pixels then tell the depth and nothing else."""


def with_depths(
    pose: Floats, seen: Sight, points: Floats, datum: Indices, data: Data, *, sigma: float, huber: float
) -> Floats:
    """The pose (4, 4), camera_from_object, that fits what is ``seen`` of it and the depths of ``datum`` (N,), matched with ``points`` (N, 3) m.

    As it was where none has a depth. ``sigma``: the noise of places, pixels, for which the weights of what is seen
    stand, in whatever unit. ``huber``: pixels beyond which a residual counts linearly.
    """
    told = side_sight(pose, points, datum, data, sigma)
    if told is None:
        return pose
    unit = float(np.median(seen.weights)) * sigma**2
    return refine_sights(pose, [seen, told._replace(weights=unit * told.weights)], huber=huber)


def side_sight(pose: Floats, points: Floats, datum: Indices, data: Data, sigma: float) -> Sight | None:
    """The depths of ``datum`` (N,) as what a camera far to the side sees of ``points`` (N, 3), with noise of about ``sigma`` pixels.

    Weights are 1/variance. None where no depth is told that could be right at this ``pose`` (4, 4).
    """
    if data.depth is None or data.depth_sigma is None:
        return None
    here = transform_points(pose, points)[:, 2]
    known = np.abs(data.depth[datum] - here) <= np.maximum(DEVIATIONS * data.depth_sigma[datum], SHARE * here)
    if not known.any():
        return None
    depth, spread = data.depth[datum][known], data.depth_sigma[datum][known]
    aside = BASELINE * float(np.median(depth))
    focal = float(np.median(depth**2 / spread)) / aside * sigma
    camera = Camera(2, 2, np.array([[focal, 0.0, 0.0], [0.0, focal, 0.0], [0.0, 0.0, 1.0]]))
    moved = np.eye(4)
    moved[0, 3] = -aside
    ray = data.camera.normalised(data.uv[datum][known])
    uv = focal * np.stack([ray[:, 0] - aside / depth, ray[:, 1]], axis=1)
    noise = focal * aside * spread / depth**2
    across = np.broadcast_to([1.0, 0.0], uv.shape)
    return Sight(camera, moved, points[known], uv, 1.0 / noise**2, across)


FEWEST = 4
"""Matches that a pose is refined on."""


def settled(
    pose: Floats | Hypothesis,
    match: Callable[[Floats], Hypothesis],
    better: Callable[[Hypothesis], Floats | None],
    rounds: int,
    worth: Callable[[Hypothesis], float] | None = None,
    as_good: float = 0.0,
) -> Hypothesis:
    """Match, refine, and match again, until nothing changes or ``rounds``; ``better`` gives a better pose, or None.

    What is posed is matched already.

    With ``worth``, the one of greatest worth on the way: a pose that fits its matches better may still explain less. Of
    those that are less by no more than ``as_good`` it is the last, which depends least on where it began.
    """
    posed = best = pose if isinstance(pose, Hypothesis) else match(pose)
    most = -np.inf if worth is None or not rounds else worth(posed)
    for _ in range(rounds):
        refined = better(posed)
        if refined is None:
            break
        new = match(refined)
        stable = np.array_equal(new.matches, posed.matches)
        posed = new
        here = np.inf if worth is None else worth(posed)
        best, most = posed if here >= most - as_good else best, max(here, most)
        if stable:
            break
    return best


def polished(
    posed: Hypothesis,
    points: Floats,
    precision: Floats,
    data: Data,
    hidden: Mask | None,
    robust: float,
    sigma: float = 1.0,
) -> Floats | None:
    """Least squares (4, 4) on the expected features that were detected, or None where they are fewer than ``FEWEST``.

    ``points`` (F, 3) m, object frame; ``precision`` (F,) 1/pixel², or in any unit, that of ``sigma`` pixels; a residual
    beyond ``robust`` pixels weighs less. Depths count where data have them.
    """
    used = posed.candidate & posed.detected
    used = used if hidden is None else used & ~hidden
    if used.sum() < FEWEST:
        return None
    uv, across = data.uv[posed.matches[used]][None], None if posed.across is None else posed.across[used][None]
    pose, its = posed.camera_from_object[None], points[used][None]
    found = np.asarray(refined_poses(pose, its, uv, precision[used][None], data.camera, huber=robust, across=across)[0])
    if data.depth is None:
        return found
    seen = Sight(data.camera, np.eye(4), points[used], uv[0], precision[used], None if across is None else across[0])
    return with_depths(found, seen, points[used], posed.matches[used], data, sigma=sigma, huber=robust)
