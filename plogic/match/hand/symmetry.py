"""What a type's symmetries make of its features: of poses that are one, only one is sought."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

SAME = 1e-3
"""Metres, per metre of the cloud's extent, within which a feature is carried onto another."""


def permutations(points: NDArray[np.float64], symmetries: NDArray[np.float64]) -> NDArray[np.intp]:
    """(S, F) where each symmetry (S, 4, 4) carries each feature (F, 3); a symmetry that carries one onto none is left out."""
    extent = float(np.ptp(points, axis=0).max()) if len(points) else 1.0
    rows = []
    for motion in symmetries:
        moved = points @ motion[:3, :3].T + motion[:3, 3]
        gap = np.linalg.norm(moved[:, None] - points[None], axis=2)
        if (gap.min(axis=1, initial=np.inf) < SAME * extent).all():
            rows.append(gap.argmin(axis=1))
    return np.array(rows, dtype=np.intp).reshape(-1, len(points))


def unique_sets(rows: NDArray[np.intp], moves: NDArray[np.intp]) -> NDArray[np.bool_]:
    """(N,) one of each family of rows (N, k) of feature indices that the permutations (S, F) carry onto each other: the least."""
    if not len(rows):
        return np.zeros(0, dtype=bool)
    base = moves.shape[1] ** np.arange(rows.shape[1])[::-1]
    return np.asarray((moves[:, rows] @ base).min(axis=0) == rows @ base)
