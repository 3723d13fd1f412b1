"""Expected and Detected of one posed hypothesis (D7, D8), and how its pose settles.

Match, refine on what was matched, match again (§7).

Where appearances carry depth (a stereo pair is one notional viewpoint, §3.3), depths fix poses. They do not decide what
is matched: some are wrong, where a feature was missed in one image and another that looks like it in the other.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from geometry.arrays import Floats, Indices, Mask, lengths
from geometry.camera import Camera
from geometry.frames import inverse, transform_points
from geometry.poses.refine import USUAL, Sight, Steps, refine_sights, refined_poses
from geometry.visibility.rays import behind
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.lobes import LobeTable, in_lobe
from kb.surfaces.surface import Surface
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data


def pose_of(object_type: ObjectType, camera_from_object: Floats, data: Data, kb: KnowledgeBase) -> Hypothesis:
    """What geometry says of a type at a pose: nothing is matched yet. Rays are cast for Behind its own host (§6.4)."""
    camera, table, surface = data.camera, object_type.lobes, object_type.surface
    at = transform_points(
        camera_from_object, np.array([feature.at for feature in object_type.seen_features]).reshape(-1, 3)
    )
    uv = camera.project(at)
    held = in_lobe(table, inverse(camera_from_object)[:3, 3][None], camera.f / kb.f_ref)[0]
    return Hypothesis(
        type=object_type.name,
        camera_from_object=camera_from_object,
        opaque=object_type.opaque,
        known_type=object_type,
        at=at,
        uv=uv,
        in_image=camera.contains(uv),
        in_lobe=np.bincount(table.feature[held], minlength=len(at)) > 0,
        self_hidden=np.zeros(len(at), bool) if surface is None else _behind(at, surface, camera_from_object),
        right=_right_types(table, held, data),
        matches=np.full(len(at), -1, dtype=np.intp),
        residual=np.full(len(at), np.nan),
    )


def _behind(at: Floats, surface: Surface, camera_from_object: Floats) -> Mask:
    """(N,) whether a posed surface is met before places (N, 3) m, camera frame (§3.4), for its own features."""
    return behind(at, surface.rays, camera_from_object, 0.004 * surface.diameter)


def _right_types(table: LobeTable, held: Mask, data: Data) -> Mask:
    """(F, A) the data whose type some lobe of the feature reports from here.

    ``held`` (L,) are the lobes that hold the viewpoint.
    """
    column = {name: i for i, name in enumerate(sorted(set(table.types)))}
    reports = np.zeros((table.features, len(column) + 1), bool)  # the last column is for types that no lobe reports
    lobes = np.flatnonzero(held)
    reports[table.feature[lobes], [column[table.types[lobe]] for lobe in lobes]] = True
    return np.asarray(reports[:, np.array([column.get(name, -1) for name in data.types], np.intp)])


def matched(
    posed: Hypothesis,
    data: Data,
    allowed: Mask,
    tolerance: float,
    free: Mask | None = None,
    hidden: Mask | None = None,
) -> Hypothesis:
    """The hypothesis' one assignment (D8): expected features first, with the types whose lobe holds v.

    Then unexpected ones.

    ``allowed`` (F, A) are the types of each feature in any lobe; ``tolerance`` in pixels; ``free`` (A,) the data that
    nobody else has claimed; ``hidden`` (F,) the features that accepted opaque objects hide. An appearance serves one
    feature; a feature takes one.
    """
    free = np.ones(len(data.ids), dtype=bool) if free is None else free
    expected = posed.expected(hidden)
    off = lengths(np.nan_to_num(posed.uv, nan=1e9)[:, None] - data.uv[None])
    near = off <= tolerance
    matches = np.full(len(posed.uv), -1, dtype=np.intp)
    _assign(matches, off, near & free & posed.right & expected[:, None], tolerance)
    left = free.copy()
    left[matches[matches >= 0]] = False
    _assign(matches, off, near & left & allowed & (posed.in_image & ~expected)[:, None], tolerance)
    return replace(posed, matches=matches, residual=of_matches(off, matches))


def of_matches(table: Floats, matches: Indices) -> Floats:
    """(F,) what a table (F, A) says of each feature and its datum ``matches`` (F,), NaN where that is −1."""
    if not table.size:
        return np.full(len(matches), np.nan)
    return np.where(matches >= 0, np.take_along_axis(table, np.maximum(matches, 0)[:, None], axis=1)[:, 0], np.nan)


def assigned(
    matches: Indices,
    feature: Indices,
    datum: Indices,
    off: Floats,
    tolerance: float,
) -> None:
    """The same assignment for few pairs (feature, datum), ``off`` pixels apart: fill ``matches`` (F,)."""
    rows, row = np.unique(feature, return_inverse=True)
    columns, column = np.unique(datum, return_inverse=True)
    if not len(rows):
        return
    distance, possible = np.full((len(rows), len(columns)), 2.0 * tolerance), np.zeros((len(rows), len(columns)), bool)
    distance[row, column], possible[row, column] = off, True
    found = np.full(len(rows), -1, np.intp)
    _assign(found, distance, possible, tolerance)
    matches[rows[found >= 0]] = columns[found[found >= 0]]


def _assign(matches: Indices, off: Floats, possible: Mask, tolerance: float) -> None:
    """Fill ``matches`` with the assignment of greatest Σ (1 − d²/2·tolerance²).

    As many as can be, the nearer the better.
    """
    rows, columns = np.flatnonzero(possible.any(axis=1)), np.flatnonzero(possible.any(axis=0))
    if not len(rows):
        return
    grid = np.ix_(rows, columns)
    gain = np.where(possible[grid], 1.0 - 0.5 * (off[grid] / tolerance) ** 2, 0.0)
    for r, c in zip(*_best_pairs(gain), strict=True):
        if possible[rows[r], columns[c]]:
            matches[rows[r]] = columns[c]


def _best_pairs(gain: Floats) -> tuple[Indices, Indices]:
    """Rows and columns of the assignment of greatest sum; SciPy's, where two rows and two columns want the same."""
    for best, own in (gain.argmax(axis=1), 0), (gain.argmax(axis=0), 1):
        if len(np.unique(best)) == len(best):
            pair = np.arange(len(best)), best
            return pair[own], pair[1 - own]
    from scipy.optimize import linear_sum_assignment  # SciPy is there in 0.2 s, and most searches never need it

    return linear_sum_assignment(gain, maximize=True)


def hidden_by(posed: Hypothesis, other: Hypothesis) -> Mask:
    """(F,) Behind(f, other, v): the line of sight to each feature of ``posed`` meets the other's surface first (§3.4).

    Of a learned type's thousands of features it is asked of those alone that are expected or detected: of others
    nothing is said.
    """
    surface, mask = other.object_type.surface, np.zeros(len(posed.at), dtype=bool)
    if surface is None:
        return mask
    asked = np.flatnonzero(posed.candidate | posed.detected) if posed.hit is not None else np.arange(len(posed.at))
    mask[asked] = _behind(posed.at[asked], surface, other.camera_from_object)
    return mask


DEVIATIONS, SHARE = 4.0, 0.05
"""A depth counts that is off a pose's by so many standard deviations at most, or by this share of it."""
BASELINE = 1000.0
"""Depths between the camera and one far to the side, whose pixels then tell the depth and nothing else."""


def with_depths(pose: Floats, seen: Sight, datum: Indices, data: Data, *, sigma: float, huber: float) -> Floats:
    """The pose (4, 4), camera_from_object, that fits what is ``seen`` of it and the depths of ``datum`` (N,).

    The data are matched with its first N points.

    As it was where none has a depth. ``sigma``: the noise of places, pixels, for which the weights of what is seen
    stand, in whatever unit. ``huber``: pixels beyond which a residual counts linearly.
    """
    told = side_sight(pose, seen.points[: len(datum)], datum, data, sigma)
    if told is None:
        return pose
    unit = float(np.median(seen.weights)) * sigma**2
    return refine_sights(pose, [seen, told._replace(weights=unit * told.weights)], huber=huber)


def side_sight(pose: Floats, points: Floats, datum: Indices, data: Data, sigma: float) -> Sight | None:
    """The depths of ``datum`` (N,) as a far side camera's view of ``points`` (N, 3), with noise of ``sigma`` px.

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
    moved = np.eye(4)
    moved[0, 3] = -aside
    ray = data.camera.normalised(data.uv[datum][known])
    uv = focal * np.stack([ray[:, 0] - aside / depth, ray[:, 1]], axis=1)
    noise = focal * aside * spread / depth**2
    camera, across = Camera(2, 2, np.diag([focal, focal, 1.0])), np.broadcast_to([1.0, 0.0], uv.shape)
    return Sight(camera, moved, points[known], uv, 1.0 / noise**2, across)


FEWEST = 4
"""Matches of different features with different data that a pose needs: any three appearances have one."""
AS_GOOD = 3.0
"""Evidence, logarithms, that is less by so little is as good: of these the last, where the climb ends, whatever way it
came.

A sight that is expected and missed costs up to so much, and at the edge of its lobe a pose that is moved by next to
nothing expects it or does not."""


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
    steps: Steps = USUAL,
) -> Floats | None:
    """Least squares (4, 4) on the expected features that were detected, or None where they are fewer than ``FEWEST``.

    ``points`` (F, 3) m, object frame; ``precision`` (F,) 1/pixel², or in any unit, that of ``sigma`` pixels; a residual
    beyond ``robust`` pixels weighs less. In so many ``steps``. Depths count where data have them.
    """
    used = posed.expected(hidden) & posed.detected
    if used.sum() < FEWEST:
        return None
    across = None if posed.across is None else posed.across[used]
    seen = Sight(data.camera, np.eye(4), points[used], data.uv[posed.matches[used]], precision[used], across)
    found = refined_poses(
        posed.camera_from_object[None],
        seen.points[None],
        seen.uv[None],
        seen.weights[None],
        data.camera,
        steps,
        huber=robust,
        across=None if across is None else across[None],
    )[0]
    if data.depth is None:
        return np.asarray(found)
    return with_depths(found, seen, posed.matches[used], data, sigma=sigma, huber=robust)
