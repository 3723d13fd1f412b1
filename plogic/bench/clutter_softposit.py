"""A peer of ``plogic bench clutter``: SoftPOSIT from random starts, type by type."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.restarts import random_starts
from geometry.softposit import Annealing, softposit
from plogic.bench.clutter_pairs import refined, typed
from plogic.bench.clutter_scenes import PIXELS
from plogic.bench.processor import processor_seconds

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.cloud import KnowledgeBase
    from plogic.bench.clutter_pairs import Answer, Typed
    from sensing.appearance import Gamma

STARTS = 16
"""Random starts a type and round: annealed together they take less time than alone."""
BETA = 2e-4
"""1/pixel² at the start: what nobody knows is where in the image it stands."""
NARROW = 0.5
"""Least width of a picture, as a share of the body's greatest."""


def soft_posit(kb: KnowledgeBase, gamma: Gamma, budget_seconds: float) -> Answer | None:
    """Random-start SoftPOSIT where a feature may be any datum that looks like it; of what converged the most matches win, then the least error.

    Rounds over all types, most pairs first, until the time is over. It gets its best: it is told how large objects appear, which bounds the
    depth of its starts, and in the end the best pose is refined on its matches.
    """
    end = processor_seconds() + budget_seconds
    kinds, xy = typed(kb, gamma), gamma.camera.normalised(gamma.uv)
    setting, rng = Annealing(beta=BETA, noise=kb.rates.sigma, pixel=1.0 / gamma.camera.f), np.random.default_rng(0)
    best: tuple[tuple[int, float], Typed, NDArray[np.float64], NDArray[np.int64]] | None = None
    while kinds and processor_seconds() <= end:
        for pairs in kinds:
            if processor_seconds() > end:
                break
            start = random_starts(pairs.points, xy, STARTS, rng, depth=_depths(pairs, gamma.camera.f))
            found = softposit(pairs.points, xy, start, allowed=_allowed(pairs, len(xy)), annealing=setting)
            for i in np.flatnonzero(found.converged):
                worth = int(found.count[i]), -float(found.error[i])
                if best is None or worth > best[0]:
                    best = worth, pairs, found.camera_from_object[i], found.matches[i]
    if best is None:
        return None
    _, pairs, pose, matches = best
    some = np.flatnonzero(matches >= 0)
    return pairs.kind.name, refined(pose, pairs.points[some], matches[some], gamma, kb)


def _depths(pairs: Typed, f: float) -> tuple[float, float]:
    """Metres, nearest and farthest, at which the type's picture has a size of ``PIXELS``."""
    across = 2.0 * float(np.linalg.norm(pairs.points - pairs.points.mean(axis=0), axis=1).max())
    return f * NARROW * across / PIXELS[1], f * across / PIXELS[0]


def _allowed(pairs: Typed, data: int) -> NDArray[np.bool_]:
    mask = np.zeros((len(pairs.points), data), bool)
    mask[pairs.feature, pairs.datum] = True
    return mask
