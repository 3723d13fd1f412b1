"""How surely a pose is right: the share, of all that may be the pose, that is within a radius of it (formalism §9.10).

What may be: the pose, and those that starts beside it (nearer, farther, tilted) settle at, weighed by a softmax of how
well each fits; and about each of them, its neighbours as wide as its pixels leave it free.

Where the outline that fits best is off by a share of its size, mesh and object differ by as much, and so may their
sizes: the distance is as unsure besides.

* ``sureness(photo, paint, pose, symmetries, before)``: P(the pose is within ``RADIUS`` of the true one)
"""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats
from geometry.frames import transform_points
from geometry.visibility.rays import RayMesh
from sensing.pixels.crop import crop_of
from sensing.pixels.drawn import Paint
from sensing.pixels.energy import choice
from sensing.pixels.photo import Photo
from sensing.pixels.refine import (
    COARSE,
    FINE,
    FIRST,
    INDEPENDENT,
    INEXACT,
    different,
    exact,
    far,
    fits_of,
    moved,
    normal,
    ordered,
    settled,
    starts_about,
)

RADIUS = 0.1
"""Diameters: mean distance of the surface's places (ADD) within which a pose is right."""
UNLIKELY = 9.0
"""Fit, below the best, of starts that are not followed to the end: in a softmax less than 1 in 8000."""
DRAWS, PLACES = 256, 60
"""Neighbours that are drawn of each pose, and places of the surface that are compared."""


class Alternative(NamedTuple):
    """A pose (4, 4), how well it fits, and Gauss-Newton's normal matrix there (6, 6): expected of a step, and told.

    ``inexact``: as its fit's.
    """

    pose: Floats
    score: float
    expected: Floats
    told: Floats
    inexact: float


def sureness(
    photo: Photo, paint: Paint, pose: Floats, symmetries: Floats, before: Sequence[tuple[RayMesh, Floats]] = ()
) -> float | None:
    """P(a pose (4, 4) is within ``RADIUS`` of the true one, given that the object is there); None where it is not seen.

    ``symmetries`` (S, 4, 4): motions of the object's frame that change nothing of it. ``before``: the surfaces of what
    stands there for sure, and its poses.
    """
    found = alternatives(photo, paint, pose, before)
    return share_of(found, paint, pose, symmetries) if found else None


def alternatives(
    photo: Photo, paint: Paint, pose: Floats, before: Sequence[tuple[RayMesh, Floats]] = ()
) -> list[Alternative]:
    """The pose first, then where starts beside it settle, none where one before is; [] where too little is seen."""
    small, large = (crop_of(photo, paint, pose, size, before) for size in (COARSE, FINE))
    if small is None or large is None:
        return []
    coarse = [settled(small, paint, some, [FIRST]) for some in starts_about(pose, paint)]
    found, trust = ordered(coarse, fits_of(small, paint, coarse), paint)
    coarse = different([settled(small, paint, some, far(trust)) for some, _ in found], paint)
    found, trust = ordered(coarse, fits_of(small, paint, coarse), paint)
    likely = [some for some, score in found if score >= found[0][1] - UNLIKELY]
    poses = different([pose, *(settled(large, paint, some, exact(trust)) for some in likely)], paint)
    known = [(some, normal(large, paint, some, exact(trust)[-1])) for some in poses]
    seen = [(some, matrices) for some, matrices in known if matrices is not None]
    fits = fits_of(large, paint, [some for some, _ in seen])
    scores = choice(fits)[1] if seen else []
    return [
        Alternative(some, score, *matrices[:2], fit.inexact)
        for (some, matrices), score, fit in zip(seen, scores, fits, strict=True)
    ]


def share_of(
    found: Sequence[Alternative],
    paint: Paint,
    pose: Floats,
    symmetries: Floats,
    independent: float = INDEPENDENT,
    inexact: float = INEXACT,
) -> float:
    """Of alternatives with their neighbours, the share that is within ``RADIUS`` of a pose, up to symmetry."""
    places = paint.mesh.vertices[:: max(1, len(paint.mesh.vertices) // PLACES)]
    turned = np.stack([transform_points(pose @ motion, places) for motion in symmetries])
    near, even = RADIUS * paint.diameter, _even()
    shares = []
    for some in found:
        steps = np.linalg.solve(np.linalg.cholesky(some.expected + independent * some.told).T, even[:, :6].T).T
        middle = transform_points(some.pose, paint.middle[None])[0]
        steps[:, 3:] += inexact * some.inexact * even[:, 6:] * middle
        shares.append(np.mean([_off(moved(some.pose, paint.middle, step), places, turned) < near for step in steps]))
    scores = np.array([some.score for some in found])
    weights = np.exp(scores - scores.max())
    return float(np.dot(weights, shares) / weights.sum())


def _off(pose: Floats, places: Floats, turned: Floats) -> float:
    """Mean distance (m) of places at a pose from the nearest of ``turned`` (S, P, 3)."""
    return float(np.linalg.norm(turned - transform_points(pose, places), axis=2).mean(axis=1).min())


@cache
def _even() -> Floats:
    """(``DRAWS``, 7) of a standard normal, the same always: evenly spread, by the powers of the root of x⁸ = x + 1."""
    from scipy.special import ndtri

    root = 1.0
    for _ in range(40):
        root = (1.0 + root) ** (1.0 / 8.0)
    return np.asarray(ndtri((0.5 + np.outer(np.arange(1, DRAWS + 1), root ** -np.arange(1.0, 8.0))) % 1.0))
