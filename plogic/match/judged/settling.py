"""How a pose settles: match, refine on what was matched, match again (§7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.poses.refine import refined_poses
from geometry.poses.refine_sights import Sight
from plogic.facts.hypothesis import Hypothesis
from plogic.match.judged.depths import with_depths

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data

    Floats = NDArray[np.float64]

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
    """Match, refine, and match again, until nothing changes or ``rounds``; ``better`` gives a better pose, or None. What is posed is matched already.

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
    hidden: NDArray[np.bool_] | None,
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
