"""Poses climb the evidence itself: what draws them moves them, again and again, and the last on the way that is as good as any is kept.

Sets of four (§6.3): of all that may draw a pose some is clutter; so each four of it draw it by themselves, as if the
rest were not there. Where few data are an object's own, a pose that is drawn to the middle of right and wrong ones
climbs to neither.

* ``climbed(asked, kind, poses, share, steps)``: any number of poses
* ``by_fours(asked, kind, poses, share)``: what comes of sets of four
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.oriented.angle_refinement import Held, refined
from plogic.match.oriented.drawn import drawn

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices
    from plogic.match.oriented.asked import Asked


BLOCK, PAIRS, LEAST = 2000, 4_000_000, 16
"""Poses at a time, and sights and data that are compared, about; a sight is as much as so many data at least."""
AS_GOOD = 3.0
"""Evidence, logarithms, that is less by so little is as good: of these the last, where the climb ends, whatever way it came.

A sight that is expected and missed costs up to so much, and at the edge of its lobe a pose that is moved by next to
nothing expects it or does not."""
STILL = 1e-8
"""Metres, and entries of the rotation, by which a pose moves that has arrived."""


def climbed(
    asked: Asked, kind: Indices, poses: Floats, share: float, steps: int, squares: int = 1
) -> tuple[Floats, Floats, Floats]:
    """Poses (N, 4, 4) of types ``kind`` (N,) after so many steps or fewer.

    Their evidence (N,), and how many sights are likely matched (N,).

    Their sights may be off by a ``share`` of the diameter. A step is so many ``squares``, steps of least squares,
    towards what draws the pose.
    """
    each = asked.index.sights.looks.shape[2] * max(LEAST, int(asked.typed.count.max(initial=0)))
    wide = max(1, min(BLOCK, PAIRS // max(1, each)))
    blocks = []
    for start in range(0, len(kind), wide):
        asked.check()
        blocks.append(_block(asked, kind[start : start + wide], poses[start : start + wide], share, steps, squares))
    if not blocks:
        return poses, np.zeros(0), np.zeros(0)
    moved, worth, likely = (np.concatenate(rows) for rows in zip(*blocks, strict=True))
    return moved, worth, likely


def _block(
    asked: Asked, kind: Indices, poses: Floats, share: float, steps: int, squares: int
) -> tuple[Floats, Floats, Floats]:
    best, worth, likely = poses.copy(), np.full(len(poses), -np.inf), np.zeros(len(poses))
    most, going = worth.copy(), np.arange(len(poses))
    for step in range(steps + 1):
        here = drawn(asked, kind[going], poses, share)
        better = here.worth > most[going] - AS_GOOD
        most[going] = np.maximum(most[going], here.worth)
        at = going[better]
        best[at], worth[at], likely[at] = poses[better], here.worth[better], here.likely[better]
        if step == steps:
            break
        moved = refined(poses, here.held, here.noise, asked.camera, steps=squares, sigma=here.sigma)
        further = np.abs(moved - poses).max(axis=(1, 2)) > STILL
        poses, going = moved[further], going[further]
        if not len(going):
            break
    return best, worth, likely


OF = 7
"""Fours are of so many sights of a pose, the likeliest."""
LIKELY = 0.005
"""How likely a sight is matched at least."""
STEPS = 6
"""Of least squares."""
FOURS_BLOCK = 500
"""Poses at a time."""
_FOURS = np.array(list(combinations(range(OF), 4)))


def by_fours(asked: Asked, kind: Indices, poses: Floats, share: float) -> tuple[Indices, Floats]:
    """Types (M,) and poses (M, 4, 4), M ≤ 35 N, of poses (N, 4, 4) of types ``kind`` (N,) whose sights may be off by a ``share`` of the diameter."""
    blocks = [
        _block_of_fours(asked, kind[start : start + FOURS_BLOCK], poses[start : start + FOURS_BLOCK], share)
        for start in range(0, len(kind), FOURS_BLOCK)
    ]
    if not blocks:
        return kind, poses
    return np.concatenate([kind for kind, _ in blocks]), np.concatenate([poses for _, poses in blocks])


def _block_of_fours(asked: Asked, kind: Indices, poses: Floats, share: float) -> tuple[Indices, Floats]:
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
