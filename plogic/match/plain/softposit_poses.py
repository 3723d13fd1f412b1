"""SoftPOSIT from random starts, for one type: pose and correspondence at once, where a feature may be any datum that looks like it (§6.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.poses.softposit import Annealing, SoftPositResult, random_starts, softposit
from plogic.base.clock import unhurried
from plogic.match.plain.extended import FEWEST, Typed, extended, scene_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from geometry.arrays import Floats
    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.gamma.data import Data
    from plogic.match.hand.hand_models import TypeIndex


MOST = 128
"""Random starts of a type."""
STARTS = 16
"""Starts at a time: annealed together they take less time than alone."""
BETA = 2e-4
"""1/pixel² at the start: what nobody knows is where in the image it stands."""
SMALLEST, LARGEST = 40.0, 2.0
"""Pixels across, and image heights, between which an object is looked for."""
PROPOSED = 24
"""Poses that are proposed."""


def proposals(index: TypeIndex, data: Data, kb: KnowledgeBase, check: Callable[[], None] = unhurried) -> list[Floats]:
    """Poses (4, 4) of a type, best first; none where no start converges.

    ``check`` is called between starts, and may raise to end the search.
    """
    scene, camera = scene_of(index, data, kb), data.camera
    if (scene.pairs.numbers > 0).sum() < FEWEST:
        return []
    rng, xy, across = np.random.default_rng(0), camera.normalised(data.uv), index.cells.diameter
    depth = camera.f * across / (LARGEST * camera.height), camera.f * across / SMALLEST
    poses = [np.zeros((0, 4, 4))]
    for _ in range(0, MOST, STARTS):
        check()
        found = annealed(scene.pairs, xy, rng, depth, noise=kb.rates.sigma, f=camera.f)
        poses.append(found.camera_from_object[found.converged])
    check()
    return extended(scene, np.concatenate(poses), PROPOSED)


def annealed(
    pairs: Typed, xy: Floats, rng: np.random.Generator, depth: tuple[float, float], *, noise: float, f: float
) -> SoftPositResult:
    """What SoftPOSIT makes of the next ``STARTS`` random starts, the object between two depths, m.

    ``noise`` and the focal length in pixels.
    """
    setting = Annealing(beta=BETA, noise=noise, pixel=1.0 / f)
    start = random_starts(pairs.points, xy, STARTS, rng, depth=depth)
    return softposit(pairs.points, xy, start, allowed=pairs.mask(len(xy)), annealing=setting)
