"""Sets of four (§6.3): of all that may draw a pose some is clutter; so each four of it draw it by themselves, as if the rest were not there.

Where few data are an object's own, a pose that is drawn to the middle of right and wrong ones climbs to neither.

* ``by_fours(asked, kind, poses, share)``: what comes of that, of any number of poses
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.oriented.angle_refinement import Held, refined
from plogic.match.oriented.drawn import drawn

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.oriented.asked import Asked

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

OF = 7
"""Fours are of so many sights of a pose, the likeliest."""
LIKELY = 0.005
"""How likely a sight is matched at least."""
STEPS = 6
"""Of least squares."""
BLOCK = 500
"""Poses at a time."""
_FOURS = np.array(list(combinations(range(OF), 4)))


def by_fours(asked: Asked, kind: Indices, poses: Floats, share: float) -> tuple[Indices, Floats]:
    """Types (M,) and poses (M, 4, 4), M ≤ 35 N, of poses (N, 4, 4) of types ``kind`` (N,) whose sights may be off by a ``share`` of the diameter."""
    blocks = [
        _block(asked, kind[start : start + BLOCK], poses[start : start + BLOCK], share)
        for start in range(0, len(kind), BLOCK)
    ]
    if not blocks:
        return kind, poses
    return np.concatenate([kind for kind, _ in blocks]), np.concatenate([poses for _, poses in blocks])


def _block(asked: Asked, kind: Indices, poses: Floats, share: float) -> tuple[Indices, Floats]:
    asked.check()
    held = drawn(asked, kind, poses, share).held
    lacking = max(0, OF - held.weight.shape[1])
    weight = np.pad(held.weight, ((0, 0), (0, lacking)))
    column = np.argsort(-weight, axis=1, kind="stable")[:, _FOURS]  # (N, 35, 4)
    row = np.arange(len(kind))[:, None, None]
    some = (weight[row, column] > LIKELY).all(axis=2)
    of, four = np.nonzero(some)[0], column[some]
    if not len(of):
        return kind[:0], poses[:0]
    rows = of[:, None], four
    alone = Held(held.points[rows], held.turns[rows], held.uv[rows], held.angle[rows], np.ones(four.shape))
    return kind[of], refined(poses[of], alone, asked.noise, asked.camera, steps=STEPS)
