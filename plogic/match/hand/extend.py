"""From coarse pairs to refined poses.

Sets of four, POSIT, then least squares on all inliers (§6.1, §6.3), batched over all candidates.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask
from geometry.poses.posit import posit
from geometry.poses.refine import Steps, refined_poses
from plogic.match.gamma.data import Columns, Data, centre_of, project_ideal
from plogic.match.hand.correspondences import Pairs
from plogic.match.hand.triples import turn_z_to
from plogic.match.hand.view_cells import LOOSE, DistanceMaps, ViewCells, seen_cells, sizes
from plogic.match.judged.expectation import FEWEST

ROUNDS = ((0.06, 48), (0.035, 32), (0.02, 24), (0.0, 24))
"""Of the successive rounds, the match tolerance in projected diameters (never below the detector's own) and how many of
the best go on."""


TRUSTED = 64
"""Candidates that are taken as they are, the best by votes: the order that they come in."""
CLOSE = ((0.025, 32), (0.0, 16))
"""The same for candidates that are trusted to be close already."""
ROBUST = 1.0
"""Pixels beyond which a match weighs less: among near ones a wrong match must not pull the pose."""
STEPS = Steps(5)
"""Of least squares in a round."""
MISSED = 0.4
"""Weight of a missed feature against a matched one where candidates are thinned."""


@dataclass(frozen=True)
class Candidates(Columns):
    """N candidate poses (N, 4, 4); ``matches`` (N, F) datum indices, −1 for none.

    ``fitted`` (N,) whether to at least ``FEWEST`` of them.
    """

    camera_from_object: Floats
    matches: Indices
    fitted: Mask


@dataclass(frozen=True)
class _Shown(Columns):
    """Of N poses, ``places`` (N, F, 2) of the features, ideal px, and the nearest cell's ``visible`` ones (N, F)."""

    places: NDArray[np.float32]
    visible: Mask


def coarse_poses(pairs: Pairs, cells: ViewCells, data: Data) -> Floats:
    """(N, 4, 4) camera_from_object of coarse pairs.

    The cell's rotation and roll, about the ray through the object's centre.
    """
    local = -cells.xy[pairs.cell, pairs.feature]
    cos, sin = np.cos(pairs.roll), np.sin(pairs.roll)
    turned = np.stack([cos * local[:, 0] - sin * local[:, 1], sin * local[:, 0] + cos * local[:, 1]], axis=1)
    centre = data.ideal[pairs.datum] + pairs.scale[:, None] * turned
    return poses_about(centre, pairs.roll, pairs.scale, cells.cell_from_object[pairs.cell], cells.centre, data)


def poses_about(
    centre: Floats,
    roll: Floats,
    scale: Floats,
    cell_from_object: Floats,
    middle: Floats,
    data: Data,
) -> Floats:
    """(N, 4, 4) camera_from_object of cells (N, 3, 3) turned by ``roll`` (N,) rad about the rays through ``centre``.

    ``centre`` (N, 2) ideal pixels.

    There lies each object's ``middle``, (N, 3) or (3,) in its own frame, where a metre is ``scale`` (N,) pixels.
    """  # fmt: skip
    camera = data.camera
    ray = np.concatenate([(centre - centre_of(camera)) / camera.f, np.ones((len(centre), 1))], axis=1)
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    cos, sin = np.cos(roll), np.sin(roll)
    turn = np.zeros((len(centre), 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = cos, -sin, sin, cos, 1.0
    poses = np.tile(np.eye(4), (len(centre), 1, 1))
    poses[:, :3, :3] = turn_z_to(ray) @ turn @ cell_from_object
    poses[:, :3, 3] = ray * (camera.f / scale)[:, None] - (poses[:, :3, :3] @ np.atleast_2d(middle)[..., None])[..., 0]
    return poses


def extend(
    poses: Floats,
    cells: ViewCells,
    points: Floats,
    weights: Floats,
    maps: DistanceMaps,
    data: Data,
    tolerance: float,
) -> Candidates:
    """Match, solve and refine all candidates together, the best first.

    Each candidate goes two ways: by sets of four and POSIT, with tolerances that shrink from the cell's width to the
    detector's ``tolerance`` (pixels); and as it is, trusted to be close, for wide tolerances make wrong matches where
    features lie dense.
    """
    matches = rematch(poses, cells, points, maps, data, LOOSE * sizes(poses, cells, data.camera.f))
    starts = (_from_quadruples(poses, points, weights, matches, data), ROUNDS), (poses[:TRUSTED], CLOSE)
    both = Candidates.joined(
        [_narrowed(some, rounds, cells, points, weights, maps, data, tolerance) for some, rounds in starts]
    )
    worth = _worth(_shown(both.camera_from_object, cells, points, data), both.matches, weights, maps)
    return both.take(np.argsort(-worth, kind="stable"))


def _narrowed(
    poses: Floats,
    rounds: tuple[tuple[float, int], ...],
    cells: ViewCells,
    points: Floats,
    weights: Floats,
    maps: DistanceMaps,
    data: Data,
    tolerance: float,
) -> Candidates:
    """Match and refine in rounds of shrinking tolerance, the best going on."""
    poses = rigid(poses)
    size, shown = sizes(poses, cells, data.camera.f), _shown(poses, cells, points, data)
    matches = np.full((len(poses), len(points)), -1, dtype=np.intp)
    for fraction, most in rounds:
        matches = _nearest(shown, maps, np.maximum(fraction * size, tolerance))
        poses = _refined(poses, points, matches, data)
        shown = _shown(poses, cells, points, data)
        best = np.argsort(-_worth(shown, matches, weights, maps), kind="stable")[:most]
        poses, shown, matches, size = poses[best], shown.take(best), matches[best], size[best]
    return Candidates(rigid(poses), matches, _enough(matches))


def _shown(poses: Floats, cells: ViewCells, points: Floats, data: Data) -> _Shown:
    return _Shown(project_ideal(poses, points, data), cells.visible[seen_cells(poses, cells)])


def _enough(matches: Indices) -> Mask:
    return np.asarray((matches >= 0).sum(axis=1) >= FEWEST)


def rigid(poses: Floats) -> Floats:
    """The nearest rigid motions (N, 4, 4): rounding adds up over many small turns."""
    left, _, right = np.linalg.svd(poses[:, :3, :3])
    turned = poses.copy()
    turned[:, :3, :3] = left @ right
    return turned


def _worth(shown: _Shown, matches: Indices, weights: Floats, maps: DistanceMaps) -> Floats:
    """(N,) what was matched, less ``MISSED`` times what should be seen and was not; 0.2 + dv a feature."""
    value = shown.visible * ~maps.is_covered(shown.places) * (0.2 + weights)
    worth = np.where(matches >= 0, 0.2 + weights, -MISSED * value).sum(axis=1)
    return np.asarray(np.where(_enough(matches), worth, -np.inf))


def rematch(
    poses: Floats,
    cells: ViewCells,
    points: Floats,
    maps: DistanceMaps,
    data: Data,
    tolerance: Floats,
) -> Indices:
    """(N, F) the datum of each feature that the nearest cell shows, within ``tolerance`` (N,) pixels, −1 for none."""
    return _nearest(_shown(poses, cells, points, data), maps, tolerance)


def _nearest(shown: _Shown, maps: DistanceMaps, tolerance: Floats) -> Indices:
    """Nearest data within tolerance, each datum given to the nearest of the features that want it."""
    distance, datum = maps.look_up(shown.places)
    wanted = shown.visible & (distance <= tolerance[:, None])
    matches = np.where(wanted, datum, -1)
    order = np.argsort(np.where(wanted, distance, np.inf), axis=1, kind="stable")
    ranked = np.take_along_axis(matches, order, axis=1)
    np.put_along_axis(matches, order, np.where(_first_of_each(ranked), ranked, -1), axis=1)
    return matches


def _first_of_each(rows: Indices) -> Mask:
    """(N, F) whether an entry is the first of its value in its row."""
    by_value = np.argsort(rows, axis=1, kind="stable")
    ordered = np.take_along_axis(rows, by_value, axis=1)
    fresh = np.ones_like(ordered, dtype=bool)
    fresh[:, 1:] = ordered[:, 1:] != ordered[:, :-1]
    first = np.empty_like(fresh)
    np.put_along_axis(first, by_value, fresh, axis=1)
    return first


def _from_quadruples(
    coarse: Floats,
    points: Floats,
    weights: Floats,
    matches: Indices,
    data: Data,
) -> Floats:
    """POSIT on the four matched features of highest dv, spread apart.

    Where it refuses or reprojects worse, the coarse pose stays.
    """
    four = _sets_of_four(points, weights, matches)
    chosen = np.take_along_axis(matches, four, axis=1)
    complete = np.flatnonzero((chosen >= 0).all(axis=1))
    if not len(complete):
        return coarse
    solved = posit(points[four[complete]], (data.ideal[chosen[complete]] - centre_of(data.camera)) / data.camera.f)
    old, new, its = coarse[complete], solved.camera_from_object, matches[complete]
    better = solved.ok & (new[:, 2, 3] > 0) & (_error(new, points, its, data) < _error(old, points, its, data))
    poses = coarse.copy()
    poses[complete[better]] = new[better]
    return poses


def _sets_of_four(points: Floats, weights: Floats, matches: Indices) -> Indices:
    """(N, 4) feature indices, highest dv first, each next the farthest among the most distinctive matched ones."""
    value = np.where(matches >= 0, weights[None], -1.0)
    four = np.empty((len(matches), 4), dtype=np.intp)
    four[:, 0] = value.argmax(axis=1)
    gap = np.full(matches.shape, np.inf)
    for k in range(1, 4):
        gap = np.minimum(gap, np.linalg.norm(points[None] - points[four[:, k - 1]][:, None], axis=2))
        four[:, k] = np.where(value >= 0.0, gap * value, -1.0).argmax(axis=1)
    ordered = np.sort(four, axis=1)
    same = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    four[same] = matches[same].argmin(axis=1)[:, None]
    return four


def _error(poses: Floats, points: Floats, matches: Indices, data: Data) -> Floats:
    """(N,) median distance in pixels between matched features and their data."""
    off = np.linalg.norm(project_ideal(poses, points, data) - data.ideal[matches], axis=2)
    return np.asarray(np.nanmedian(np.where(matches >= 0, off, np.nan), axis=1))


def _refined(poses: Floats, points: Floats, matches: Indices, data: Data) -> Floats:
    """Least squares on all inliers; poses with fewer than four stay as they are."""
    enough = np.flatnonzero(_enough(matches))
    if not len(enough):
        return poses
    first = firsts(matches[enough] >= 0)
    its = np.take_along_axis(matches[enough], first, axis=1)
    better = poses.copy()
    better[enough] = refined_poses(
        poses[enough], points[first], data.uv[its], (its >= 0).astype(float), data.camera, STEPS, huber=ROBUST
    )
    return better


def firsts(used: Mask) -> Indices:
    """(N, M) in each row of (N, F) the ``used`` columns, in order, and then others, as many as the fullest row has.

    What is missing costs time.
    """
    return np.argsort(~used, axis=1, kind="stable")[:, : int(used.sum(axis=1).max(initial=0))]
