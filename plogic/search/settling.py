"""How a pose settles: match, refine on what was matched, match again (§7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.refine import refine_poses
from plogic.expectation import Posed

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from plogic.search.data import Data

    Floats = NDArray[np.float64]

FEWEST = 4
"""Matches that a pose is refined on."""


def settled(
    pose: Floats | Posed,
    match: Callable[[Floats], Posed],
    better: Callable[[Posed], Floats | None],
    rounds: int,
    worth: Callable[[Posed], float] | None = None,
) -> Posed:
    """Match, refine, and match again, until nothing changes or ``rounds``; ``better`` gives a better pose, or None. What is posed is matched already.

    With ``worth``, the one of greatest worth on the way: a pose that fits its matches better may still explain less.
    """
    posed = best = pose if isinstance(pose, Posed) else match(pose)
    for _ in range(rounds):
        refined = better(posed)
        if refined is None:
            break
        new = match(refined)
        stable = np.array_equal(new.matches, posed.matches)
        posed = new
        best = posed if worth is None or worth(posed) >= worth(best) else best
        if stable:
            break
    return best


def polished(posed: Posed, points: Floats, precision: Floats, data: Data, hidden: NDArray[np.bool_] | None, robust: float) -> Floats | None:
    """Least squares (4, 4) on the expected features that were detected, or None where they are fewer than ``FEWEST``.

    ``points`` (F, 3) m, object frame; ``precision`` (F,) 1/pixel²; a residual beyond ``robust`` pixels weighs less.
    """
    used = posed.candidate & posed.detected
    used = used if hidden is None else used & ~hidden
    if used.sum() < FEWEST:
        return None
    uv, across = data.uv[posed.matches[used]][None], None if posed.across is None else posed.across[used][None]
    pose, its = posed.camera_from_object[None], points[used][None]
    return np.asarray(refine_poses(pose, its, uv, precision[used][None], data.camera, huber=robust, across=across)[0][0])
