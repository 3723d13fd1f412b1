"""Votes for whole poses, in true perspective, and the choice of the best that are not alike."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.ideal_projection import project_ideal, viewpoints_of
from plogic.match.hand.votes import ALL, LOOSE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data
    from plogic.match.hand.view_cells import ViewCells
    from plogic.match.hand.votes import DistanceMaps

SHARP = 4.0
LEAST_OPEN = 0.3
"""Share of the visible features' weight that votes are taken relative to at least, however much is covered."""
ALIKE = np.radians(12.0)
"""Two coarse poses are alike where they differ by less than this, by 8 % of the size in place, and by 15 % in size."""


def seen_cells(poses: NDArray[np.float64], cells: ViewCells) -> NDArray[np.intp]:
    """(N,) the cell nearest to the camera's direction under each pose (N, 4, 4)."""
    directions = viewpoints_of(poses) - cells.centre
    return cells.nearest(directions / np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-9))


def sizes(poses: NDArray[np.float64], cells: ViewCells, focal: float) -> NDArray[np.float64]:
    """(N,) projected diameter, pixels."""
    depth = poses[:, 2, :3] @ cells.centre + poses[:, 2, 3]
    return np.asarray(cells.diameter * focal / np.maximum(depth, 1e-6))


def pose_votes(
    poses: NDArray[np.float64],
    cells: ViewCells,
    points: NDArray[np.float64],
    weights: NDArray[np.float64],
    maps: DistanceMaps,
    data: Data,
    features: NDArray[np.intp] | slice = ALL,
) -> NDArray[np.float64]:
    """(N,) Σ weight of the visible ones of ``features``, each by how near its nearest datum is.

    In units of their whole weight, outside the image too.

    Half of a vote is for coming near, half for coming ``SHARP`` times nearer; covered features have no vote.
    """
    value = (cells.visible * weights).astype(np.float32)[:, features][seen_cells(poses, cells)]
    places = project_ideal(poses, points[features], data)
    most = value.sum(axis=1)
    distance, covered = maps.seen_at(places, features)
    value = value * ~covered
    loose = (LOOSE * sizes(poses, cells, data.camera.f)).astype(np.float32)
    share = distance / loose[:, None]
    near = 0.5 * np.maximum(0.0, 1.0 - share) + 0.5 * np.maximum(0.0, 1.0 - SHARP * share)
    whole = np.maximum(np.maximum(value.sum(axis=1), LEAST_OPEN * most), 1e-12)
    return np.asarray((value * near).sum(axis=1) / whole)


def best_apart(
    worth: NDArray[np.float64], poses: NDArray[np.float64], cells: ViewCells, data: Data, most: int
) -> NDArray[np.intp]:
    """Indices of at most ``most`` poses, best first, no two alike."""
    order = np.argsort(-worth, kind="stable")[: 15 * most]
    some = poses[order]
    centre = project_ideal(some, cells.centre[None], data)[:, 0]
    size = np.log(sizes(some, cells, data.camera.f))
    rotation = some[:, :3, :3].reshape(len(some), 9)
    alive, kept = np.ones(len(order), dtype=bool), []
    for i in range(len(order)):
        if alive[i]:
            kept.append(order[i])
            if len(kept) >= most:
                break
            near = np.abs(size - size[i]) < 0.15
            near &= rotation @ rotation[i] > 1.0 + 2.0 * np.cos(ALIKE)
            near &= ((centre - centre[i]) ** 2).sum(axis=1) < (0.08 * np.exp(size[i])) ** 2
            alive &= ~near
    return np.array(kept, dtype=np.intp)
