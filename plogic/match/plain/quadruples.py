"""The paper's search for one type: sets of four of its features, highest dv first, every assignment of data, POSIT, expected features (§6.1, §6.3).

Nothing is thinned before POSIT: no view cell votes, no angle and no neighbour is asked. Where all sets are no more than
``MOST`` it is exhaustive. A set is of features that one viewpoint sees, each with a datum that looks like it.

* ``every(...)``: all sets; ``drawn(...)``: some, at random, where they are too many
"""

from __future__ import annotations

from itertools import combinations, islice, pairwise, product
from typing import TYPE_CHECKING

import numpy as np

from geometry.poses.posit import posit
from plogic.base.clock import unhurried
from plogic.match.plain.extended import FEWEST, WIDENED, Scene, Typed, best, extended, scene_of, worth

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.gamma.data import Data
    from plogic.match.hand.hand_models import TypeIndex

    Sets = tuple[Indices, Indices]

BLOCK = 2000
"""Sets that are handed on at a time."""
DRAWN, POSED = 2000, 1000
"""Sets that are drawn at a time, and those of them, of highest dv, that are handed on."""


def how_many(pairs: Typed) -> int:
    """Sets of four different features, each with a datum that looks like it, whether one viewpoint sees them or not."""
    sums = [1, 0, 0, 0, 0]  # of the products of none, one, ... four of the features' counts so far
    for count in pairs.numbers.tolist():
        sums = [1, *(more + count * fewer for fewer, more in pairwise(sums))]
    return sums[4]


def every(pairs: Typed, seen: Mask, dv: Floats) -> Iterator[Sets]:
    """All sets, as features (N, 4) and different data (N, 4), by their sum of ``dv`` (F,), the greatest first.

    ``seen`` (V, F): what each viewpoint sees.
    """
    count = pairs.numbers
    first = np.cumsum(count) - count
    chosen = np.array(list(combinations(np.flatnonzero(count).tolist(), 4)), np.intp).reshape(-1, 4)
    chosen = chosen[_converging(chosen, seen)]
    chosen = chosen[np.argsort(-dv[chosen].sum(axis=1), kind="stable")]
    rows = (
        (four, data)
        for four in chosen.tolist()
        for data in product(*(pairs.datum[first[f] : first[f] + count[f]].tolist() for f in four))
        if len(set(data)) == 4
    )
    while block := list(islice(rows, BLOCK)):
        yield np.array([four for four, _ in block], np.intp), np.array([data for _, data in block], np.intp)


def _converging(chosen: Indices, seen: Mask) -> Mask:
    """(N,) which of the sets some viewpoint sees whole (*convergence*)."""
    result = np.zeros(len(chosen), bool)
    for view in np.unique(seen, axis=0):
        result |= view[chosen].all(axis=1)
    return result


def drawn(pairs: Typed, seen: Mask, dv: Floats, rng: np.random.Generator) -> Sets:
    """``POSED`` sets of ``DRAWN`` random ones, or fewer: features (N, 4) and different data (N, 4), highest dv first.

    ``seen`` (V, F): what each viewpoint sees; each is drawn as often.
    """
    count = pairs.numbers
    first = np.cumsum(count) - count
    some = seen & (count > 0)
    some = some[some.sum(axis=1) >= 4]
    if not len(some):
        return np.zeros((0, 4), np.intp), np.zeros((0, 4), np.intp)
    lots = np.where(some[rng.integers(len(some), size=DRAWN)], rng.random((DRAWN, len(count))), -1.0)
    feature = np.argpartition(-lots, 3, axis=1)[:, :4]
    datum = pairs.datum[first[feature] + rng.integers(count[feature])]
    ordered = np.sort(datum, axis=1)
    apart = np.flatnonzero((ordered[:, 1:] != ordered[:, :-1]).all(axis=1))
    chosen = apart[np.argsort(-dv[feature[apart]].sum(axis=1), kind="stable")[:POSED]]
    return feature[chosen], datum[chosen]


MOST = 300_000
"""Sets of four that are tried of a type: all of them where they are no more, else as many that are drawn at random."""
MOST_TURNED = np.pi
"""Radians by which the noise may turn a set's pose: of sets that are not coplanar none is refused for that."""
KEPT, PROPOSED = 120, 24
"""Poses that are extended, and those of them that are proposed: the best by their evidence, no two alike."""


def proposals(index: TypeIndex, data: Data, kb: KnowledgeBase, check: Callable[[], None] = unhurried) -> list[Floats]:
    """Poses (4, 4) of a type, best first; none where fewer than four of its features find data.

    ``check`` may raise to end the search.
    """
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
    """(N', 4, 4) what POSIT makes of sets of features (N, 4) at data (N, 4) of ``xy`` (A, 2) = x/z, y/z.

    Those it refuses are left out.

    ``noise`` of the data, in units of x/z; ``turned``: radians by which it may turn a set's pose.
    """
    found = posit(pairs.points[feature], xy[datum], noise=noise, max_turn=turned)
    return found.camera_from_object[found.ok]
