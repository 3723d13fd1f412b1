"""From coarse poses to refined ones: least squares on all inliers, batched over all candidates of all types (§6.3)."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from geometry.poses.refine import Steps, refined_poses
from plogic.match.gamma.data import Columns, Data, centre_of, viewpoints_of
from plogic.match.hand.distance_maps import DistanceMaps
from plogic.match.hand.place_index import PlaceIndex
from plogic.match.hand.place_votes import turn_z_to
from plogic.match.judged.expectation import FEWEST
from plogic.match.judged.rivals import EVEN

ROUNDS = ((0.06, 1.0), (0.035, 0.6), (0.02, 0.4), (0.0, 0.4))
"""Of the successive rounds, the match tolerance in projected diameters (never below the detector's own), and the share
of the first that goes on, the best."""
ROBUST = 1.0
"""Pixels beyond which a match weighs less: among near ones a wrong match must not pull the pose."""
STEPS = Steps(5)
"""Of least squares in a round."""
MISSED = 0.4
"""Weight of a missed feature against a matched one where candidates are thinned."""


@dataclass(frozen=True)
class Candidates(Columns):
    """N candidates of types ``kind`` (N,): ``poses`` (N, 4, 4); ``matches`` (N, F) datum indices, −1 for none.

    ``worth`` (N,): what was matched, less what should be seen and was not; −∞ below ``FEWEST`` matches.
    """

    kind: Indices
    poses: Floats
    matches: Indices
    worth: Floats


@dataclass(frozen=True)
class Shown(Columns):
    """Of N poses, ``places`` (N, F, 2) of the features, ideal px, and the nearest cell's ``visible`` ones (N, F).

    ``sets`` (N, F): as what they look; ``size`` (N,) projected diameters, px.
    """

    places: Floats
    visible: Mask
    sets: Indices
    size: Floats


def shown(index: PlaceIndex, kind: Indices, poses: Floats, data: Data) -> Shown:
    """Where the features of poses (N, 4, 4) are on the screen."""
    local = index.points[kind] @ np.swapaxes(poses[:, :3, :3], 1, 2) + poses[:, None, :3, 3]
    depth = np.where(local[..., 2] > 1e-6, local[..., 2], np.nan)
    places = local[..., :2] / depth[..., None] * data.camera.f + centre_of(data.camera)
    views = viewpoints_of(poses) - index.centres[kind]
    cell = index.cells_of(views.T)
    middle = np.einsum("nj,nj->n", poses[:, 2, :3], index.centres[kind]) + poses[:, 2, 3]
    size = index.diameters[kind] * data.camera.f / np.maximum(middle, 1e-6)
    return Shown(np.nan_to_num(places, nan=-1e6), index.visible[kind, cell], index.shown[kind], size)


def extend(index: PlaceIndex, start: Candidates, maps: DistanceMaps, data: Data, tolerance: float) -> Candidates:
    """Match, solve and refine all candidates together, with tolerances that shrink to the detector's, pixels.

    The best first.
    """
    found, seen = start, shown(index, start.kind, start.poses, data)
    for fraction, share in ROUNDS:
        matches = nearest(seen, maps, np.maximum(fraction * seen.size, tolerance))
        poses = refined(index, found.kind, found.poses, matches, data)
        seen = shown(index, found.kind, poses, data)
        found = Candidates(found.kind, poses, matches, worth(seen, matches, index.values[found.kind], maps))
        best = np.argsort(-np.round(found.worth, EVEN), kind="stable")[: round(share * len(start.kind)) or 1]
        found, seen = found.take(best), seen.take(best)
    return found


def worth(seen: Shown, matches: Indices, values: Floats, maps: DistanceMaps) -> Floats:
    """(N,) the ``values`` (N, F) of what was matched, less ``MISSED`` times those of what should be and was not."""
    missed = seen.visible & ~maps.is_covered(seen.places)
    total = np.where(matches >= 0, values, -MISSED * values * missed).sum(axis=1)
    return np.asarray(np.where((matches >= 0).sum(axis=1) >= FEWEST, total, -np.inf))


def nearest(seen: Shown, maps: DistanceMaps, tolerance: Floats) -> Indices:
    """(N, F) the datum of each visible feature within ``tolerance`` (N,) pixels, −1 for none.

    Each datum is given to the nearest of the features that want it.
    """
    distance, datum = maps.look_up(seen.places, seen.sets)
    wanted = seen.visible & (distance <= tolerance[:, None])
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


def refined(index: PlaceIndex, kind: Indices, poses: Floats, matches: Indices, data: Data) -> Floats:
    """Least squares on all inliers; poses with fewer than ``FEWEST`` stay as they are."""
    enough = np.flatnonzero((matches >= 0).sum(axis=1) >= FEWEST)
    if not len(enough):
        return poses
    first = firsts(matches[enough] >= 0)
    its = np.take_along_axis(matches[enough], first, axis=1)
    better = poses.copy()
    better[enough] = refined_poses(
        rigid(poses[enough]),
        index.points[kind[enough][:, None], first],
        data.uv[its],
        (its >= 0).astype(float),
        data.camera,
        STEPS,
        huber=ROBUST,
    )
    return better


def rigid(poses: Floats) -> Floats:
    """The nearest rigid motions (N, 4, 4): rounding adds up over many small turns."""
    left, _, right = np.linalg.svd(poses[:, :3, :3])
    turned = poses.copy()
    turned[:, :3, :3] = left @ right
    return turned


def firsts(used: Mask) -> Indices:
    """(N, M) in each row of (N, F) the ``used`` columns, in order, and then others, as many as the fullest row has.

    What is missing costs time.
    """
    return np.argsort(~used, axis=1, kind="stable")[:, : int(used.sum(axis=1).max(initial=0))]


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
