"""Soft assignment of model points to image points, with slack: Sinkhorn's normalisation, for many starts at once.

Source: Sinkhorn 1964; with a slack row and column, Gold et al. 1998 and David et al. 2004 (SoftPOSIT, formalism §6.2).
    Given positive
affinities k_ij and the slack value s, the rows and the columns of the matrix that s borders are scaled in turn until
each row i but the slack
row, and each column j but the slack column, sums to 1. The result has the form m_ij = r_i k_ij c_j, with slack r_i s
and s c_j, and is unique:
r and c minimise the strictly convex  sum r k c + s sum r + s sum c - sum log r - sum log c. So neither the order of the
two scalings nor where c starts (here: where the last step of an annealing left it) changes what is reached, only how
soon.

Only pairs that may correspond are kept, as a list: with 300 types, 100 model points and 1000 image points, 333 of
100,000.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Ints
from geometry.errors import GeometryError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

TOLERANCE = 1e-3  # how far from 1 a row may sum at the end
ROUNDS = 60  # scalings of rows and columns at most


@dataclass(frozen=True, eq=False)
class Pairs:
    """P pairs (model point, image point) that may correspond, of N and M points, ordered by both."""

    model: Ints  # (P,) 0..N-1
    image: Ints  # (P,) 0..M-1
    shape: tuple[int, int]  # N, M

    def __len__(self) -> int:
        return len(self.model)


class Assignment(NamedTuple):
    """Soft assignments of K starts: rows and columns sum to 1 together with their slack."""

    weights: Floats  # (K, P) m_ij of each pair
    model_slack: Floats  # (K, N) how far a model point is matched to nothing
    image_slack: Floats  # (K, M) how far an image point is
    scale: Floats  # (K, M) the c_j, from which the next normalisation may start


def pairs_of(allowed: ArrayLike) -> Pairs:
    """The pairs where `allowed` (N, M) bool is true.

    Raises:
        GeometryError: where `allowed` is no matrix.
    """
    mask = np.asarray(allowed, dtype=np.bool_)
    if mask.ndim != 2:
        raise GeometryError(f"allowed must have the shape (N, M), not {mask.shape}")
    model, image = np.nonzero(mask)
    return Pairs(model.astype(np.int64), image.astype(np.int64), (mask.shape[0], mask.shape[1]))


def sinkhorn(
    affinities: Floats,
    pairs: Pairs,
    slack: float,
    start: Floats | None = None,
    *,
    tolerance: float = TOLERANCE,
    rounds: int = ROUNDS,
) -> Assignment:
    """The assignments of K matrices of `affinities` (K, P), not negative, each bordered by the value `slack` > 0.

    `start` (K, M) are the c_j to begin with, 1 if not given. Each start ends by itself, when its rows sum to 1 within
    `tolerance` or after `rounds`; none depends on the others, and columns sum to 1 exactly whichever ended it. A point
    without any pair goes wholly to slack.
    """
    count, (models, images) = len(affinities), pairs.shape
    per_model, per_image = _sums(affinities, pairs)
    c = np.ones((count, images)) if start is None else start
    r = wanted = 1.0 / (per_model(c) + slack)
    open_ = np.ones((count, 1), dtype=np.bool_)
    for _ in range(rounds):
        r = np.where(open_, wanted, r)  # a start that has ended keeps its r, and so its c
        c = 1.0 / (per_image(r) + slack)
        wanted = 1.0 / (per_model(c) + slack)
        open_ &= (np.abs(r / wanted - 1.0) > tolerance).any(axis=1, keepdims=True)
        if not open_.any():
            break
    weights = affinities * r[:, pairs.model] * c[:, pairs.image]
    return Assignment(weights, slack * r.reshape(count, models), slack * c.reshape(count, images), c)


def sums_per_model(weights: Floats, pairs: Pairs, values: Floats) -> Floats:
    """The sums (K, N, D) over j of m_ij v_j, for `weights` (K, P) and the image points' `values` (M, D)."""
    matrix = _stacked(weights, pairs)
    return np.asarray(matrix @ np.tile(values, (len(weights), 1))).reshape(
        len(weights), pairs.shape[0], values.shape[1]
    )


def _sums(affinities: Floats, pairs: Pairs) -> tuple[Callable[[Floats], Floats], Callable[[Floats], Floats]]:
    """The sums (K, N) of k_ij c_j over j, of c (K, M); and (K, M) of r_i k_ij over i, of r (K, N)."""
    matrix, count, (models, images) = _stacked(affinities, pairs), len(affinities), pairs.shape
    back = matrix.T
    return (lambda c: (matrix @ c.ravel()).reshape(count, models)), (
        lambda r: (back @ r.ravel()).reshape(count, images)
    )


def _stacked(values: Floats, pairs: Pairs) -> "csr_array":
    """The (K, P) `values` as one sparse matrix (K N, K M), its K blocks on the diagonal."""
    from scipy.sparse import csr_array

    count, (models, images) = len(values), pairs.shape
    step = np.arange(count, dtype=np.int64)[:, None]
    ends = np.searchsorted(pairs.model, np.arange(models + 1))
    starts = np.append((ends[:-1] + step * len(pairs)).ravel(), count * len(pairs))
    return csr_array(
        (values.ravel(), (pairs.image + step * images).ravel(), starts), shape=(count * models, count * images)
    )
