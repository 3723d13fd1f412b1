"""A peer of ``plogic bench clutter``: SoftPOSIT from random starts, type by type."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.pairs import refined, typed
from benchmarks.clutter.scenes import PIXELS
from benchmarks.shared.processor import processor_seconds
from plogic.match.plain.plain_models import annealed, setting_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from benchmarks.clutter.pairs import Answer
    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.plain.quadruples import Typed
    from sensing.appearance import Gamma

NARROW = 0.5
"""Least width of a picture, as a share of the body's greatest."""


def soft_posit(kb: KnowledgeBase, gamma: Gamma, budget_seconds: float) -> Answer | None:
    """Random-start SoftPOSIT where a feature may be any datum that looks like it.

    Of what converged the most matches win, then the least error.

    Rounds over all types, most pairs first, until the time is over. It gets its best: it is told how large objects
    appear, which bounds the depth of its starts, and in the end the best pose is refined on its matches.
    """
    end = processor_seconds() + budget_seconds
    kinds, xy = typed(kb, gamma), gamma.camera.normalised(gamma.uv)
    rng = np.random.default_rng(0)
    best: tuple[tuple[int, float], Typed, NDArray[np.float64], NDArray[np.int64]] | None = None
    while kinds and processor_seconds() <= end:
        for pairs in kinds:
            if processor_seconds() > end:
                break
            found = annealed(pairs, xy, rng, _depths(pairs, gamma.camera.f), setting_of(kb, gamma.camera))
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
