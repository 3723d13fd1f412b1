"""SoftPOSIT from many starts: random ones, one after the other until enough points are matched.

Source: David et al. 2004 (formalism §6.2), random-start SoftPOSIT: a local minimum is met more often than not, and only
the match count tells.
"""

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, last_axes
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from geometry.poses.softposit import Annealing, SoftPositResult, joined, softposit


def random_starts(
    points: ArrayLike, xy: ArrayLike, count: int, rng: np.random.Generator | int, *, depth: tuple[float, float]
) -> Floats:
    """`count` poses (count, 4, 4): any rotation, the middle of `points` (N, 3) m in the box about `xy` (M, 2), `depth` m away.

    Depths are uniform in their logarithm between the two bounds. `rng` is a generator, which moves on, or a seed.

    Raises:
        GeometryError: where the shapes do not fit, a point is missing on either side, or the bounds are not 0 < nearest
        <= farthest.
    """
    objects, seen, generator = (
        last_axes(points, (-1, 3), "points"),
        last_axes(xy, (-1, 2), "xy"),
        np.random.default_rng(rng),
    )
    if objects.ndim != 2 or seen.ndim != 2 or not (len(objects) and len(seen) and 0 < depth[0] <= depth[1]):
        rule = "random starts need points (N, 3), xy (M, 2), one of each at least, and depths 0 < nearest <= farthest"
        raise GeometryError(f"{rule}, not {objects.shape}, {seen.shape} and {depth}")
    rotation = rotation_from_quat_xyzw(generator.normal(size=(count, 4)))
    z = np.exp(generator.uniform(np.log(depth[0]), np.log(depth[1]), (count, 1)))
    place = (
        np.concatenate([generator.uniform(seen.min(axis=0), seen.max(axis=0), (count, 2)), np.ones((count, 1))], axis=1)
        * z
    )
    return from_rotation_translation(rotation, place - rotation @ objects.mean(axis=0))


def softposit_restarts(
    points: ArrayLike,
    xy: ArrayLike,
    start: ArrayLike,
    enough: int,
    *,
    allowed: ArrayLike | None = None,
    annealing: Annealing | None = None,
    at_once: int = 16,
) -> SoftPositResult:
    """The starts `start` (K, 4, 4) one after the other, up to and with the first that converges with `enough` matches; all if none does.

    The paper takes 0.8 x the expected rate of detection x N for enough. Starts are annealed `at_once`, which changes
    the time only: what comes after the first success is dropped. The result has K' <= K starts; where it was found, the
    last is the one.
    """
    starts = last_axes(start, (4, 4), "start")
    parts: list[SoftPositResult] = []
    for i in range(0, max(1, len(starts)), at_once):
        part = softposit(points, xy, starts[i : i + at_once], allowed=allowed, annealing=annealing)
        hits = np.nonzero(part.converged & (part.count >= enough))[0]
        parts.append(part if not len(hits) else part.first(int(hits[0]) + 1))
        if len(hits):
            break
    return joined(parts)
