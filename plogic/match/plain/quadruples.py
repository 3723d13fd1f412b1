"""The paper's search for one type: sets of four of its features, highest dv first, every assignment of data, POSIT, expected features (§6.1, §6.3).

Nothing is thinned before POSIT: no view cell votes, no angle and no neighbour is asked. Where all sets are no more than
``MOST`` it is exhaustive.
"""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from geometry.poses.posit import posit
from plogic.base.clock import unhurried
from plogic.match.plain.extended import WIDENED, best, extended, scene_of, worth
from plogic.match.plain.sets_of_four import POSED, drawn, every, how_many
from plogic.match.plain.typed_pairs import FEWEST

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.gamma.data import Data
    from plogic.match.hand.type_index import TypeIndex
    from plogic.match.plain.extended import Scene
    from plogic.match.plain.sets_of_four import Sets
    from plogic.match.plain.typed_pairs import Typed

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

MOST = 300_000
"""Sets of four that are tried of a type: all of them where they are no more, else as many that are drawn at random."""
MOST_TURNED = np.pi
"""Radians by which the noise may turn a set's pose: of sets that are not coplanar none is refused for that."""
KEPT, PROPOSED = 120, 24
"""Poses that are extended, and those of them that are proposed: the best by their evidence, no two alike."""


def proposals(index: TypeIndex, data: Data, kb: KnowledgeBase, check: Callable[[], None] = unhurried) -> list[Floats]:
    """Poses (4, 4) of a type, best first; none where fewer than four of its features find data. ``check`` may raise to end the search."""
    scene = scene_of(index, data, kb)
    poses, values = np.zeros((0, 4, 4)), np.zeros(0)
    for feature, datum in sets(scene):
        check()
        more = posed(scene.pairs, data.camera.normalised(data.uv), feature, datum, kb.rates.sigma / data.camera.f)
        poses, values = np.concatenate([poses, more]), np.concatenate([values, worth(scene, more, WIDENED[0])])
        kept = best(scene, poses, values, KEPT)
        poses, values = poses[kept], values[kept]
    check()
    return extended(scene, poses, PROPOSED)


def sets(scene: Scene) -> Iterator[Sets]:
    """All sets of what one view cell shows, or ``MOST`` random ones of them where all would be more."""
    index, pairs = scene.of, scene.pairs
    if (pairs.numbers > 0).sum() < FEWEST:
        return
    if how_many(pairs) <= MOST:
        yield from every(pairs, index.cells.visible, index.weights)
        return
    rng = np.random.default_rng(0)
    yield from islice(iter(lambda: drawn(pairs, index.cells.visible, index.weights, rng), None), MOST // POSED)


def posed(
    pairs: Typed, xy: Floats, feature: Indices, datum: Indices, noise: float, turned: float = MOST_TURNED
) -> Floats:
    """(N', 4, 4) what POSIT makes of sets of features (N, 4) at data (N, 4) of ``xy`` (A, 2) = x/z, y/z; those it refuses are left out.

    ``noise`` of the data, in units of x/z; ``turned``: radians by which it may turn a set's pose.
    """
    found = posit(pairs.points[feature], xy[datum], noise=noise, max_turn=turned)
    return found.camera_from_object[found.ok]
