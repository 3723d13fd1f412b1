"""Which estimate is which object's, in one image: BOP's targets, and its greedy matching.

Hodaň et al., BOP Challenge 2020 (§2.1): of each object so many of the best-scored estimates are taken as instances are
wanted; by decreasing score each goes to the truth of the lowest error below the threshold that is still free.

* ``View``, one image with what stands there and what was found: ``View(truths, estimates, camera, wanted={5: 1})``
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from plogic.run.bop.dataset import Truth
    from plogic.run.bop.results_file import Estimate

VISIBLE = 0.1
"""A truth less visible than this is no target where no list of targets says how many are wanted."""


@dataclass(frozen=True, eq=False)
class View:
    """One image.

    ``camera`` may be None where there is no estimate. ``wanted``: instances by object; None: all that are visible.
    """

    truths: tuple[Truth, ...]
    estimates: tuple[Estimate, ...]
    camera: Camera | None
    wanted: Mapping[int, int] | None = None


def targets_of(view: View) -> dict[int, list[Truth]]:
    """The truths to be found, by object: with ``wanted`` its number of the most visible, else those of which a tenth is visible.

    A truth of unknown visibility counts as visible.
    """
    chosen: dict[int, list[Truth]] = {}
    order = sorted(view.truths, key=lambda t: -(1.0 if t.visible is None else t.visible))
    for truth in order:
        mates = chosen.setdefault(truth.obj_id, [])
        seen = truth.visible is None or truth.visible >= VISIBLE
        if seen if view.wanted is None else len(mates) < view.wanted.get(truth.obj_id, 0):
            mates.append(truth)
    return {obj_id: mates for obj_id, mates in chosen.items() if mates}


def taken(view: View, obj_id: int, targets: int) -> list[Estimate]:
    """The estimates of an object that count: the best-scored, as many as instances are wanted.

    Among equals the first.
    """
    count = targets if view.wanted is None else view.wanted.get(obj_id, 0)
    return sorted((e for e in view.estimates if e.obj_id == obj_id), key=lambda e: -e.score)[:count]


def matched(errors: NDArray[np.float64] | Sequence[Sequence[float]], threshold: float) -> list[tuple[int, int]]:
    """(estimate, truth) pairs by ``errors`` (E, G), the estimates by decreasing score.

    An error must be below the threshold.
    """
    free = np.array(errors, dtype=np.float64)
    pairs = []
    for row in range(len(free)):
        best = int(np.argmin(free[row])) if free.shape[1] else -1
        if best >= 0 and free[row, best] < threshold:
            pairs.append((row, best))
            free[:, best] = np.inf
    return pairs
