"""The paper's search for one type.

Sets of four of its features, highest dv first, every assignment of data, POSIT, expected features (§6.1, §6.3).

Nothing is thinned before POSIT: no view cell votes, no angle and no neighbour is asked. Where all sets are no more than
``MOST`` it is exhaustive. A set is of features that one viewpoint sees, each with a datum that looks like it. Coarse
poses are extended by the features that they expect: matched with what is near, refined, and again, ever more tightly
(§6.3, §7).

* ``Typed``: the typed correspondences that the plain generators start from: every feature of a type with every datum
  that looks like it
* ``every(...)``: all sets; ``drawn(...)``: some, at random, where they are too many
"""

from collections.abc import Callable, Iterator
from itertools import combinations, islice, pairwise, product
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices, Mask, lengths
from geometry.camera import Camera
from geometry.frames import inverse, transform_points
from geometry.poses.posit import posit
from geometry.poses.refine import refined_poses
from kb.clouds.cloud import KnowledgeBase, ObjectType
from plogic.base.clock import unhurried
from plogic.match.gamma.data import Data
from plogic.match.hand.hand_models import TypeIndex
from plogic.match.judged.evidence import clutter_density, density
from plogic.match.judged.expectation import FEWEST
from plogic.match.judged.rivals import apart

Sets = tuple[Indices, Indices]


class Typed(NamedTuple):
    """``points`` (F, 3) m: the features' places.

    P pairs, by feature and then by datum: ``feature`` (P,) and ``datum`` (P,).
    """

    kind: ObjectType
    points: Floats
    feature: Indices
    datum: Indices

    @property
    def numbers(self) -> Indices:
        """(F,) how many data look like each feature."""
        return np.bincount(self.feature, minlength=len(self.points))

    def mask(self, data: int) -> Mask:
        """(F, A) which of so many data looks like which feature."""
        mask = np.zeros((len(self.points), data), bool)
        mask[self.feature, self.datum] = True
        return mask


def pairs_of(index: TypeIndex, data: Data) -> Typed:
    """All pairs of one type's features and data that look like them."""
    return Typed(index.object_type, index.points, *np.nonzero(index.allowed(data)))


def off(poses: Floats, pairs: Typed, uv: Floats, camera: Camera) -> Floats:
    """(N, P) pixels from where N poses show the pairs' features to their data, ``uv`` (A, 2) undistorted.

    Infinite behind the camera.
    """
    at = transform_points(poses, pairs.points)
    shown = camera.to_pixels(at[..., :2] / np.where(at[..., 2] > 0.0, at[..., 2], np.nan)[..., None])
    return np.nan_to_num(lengths(shown[:, pairs.feature] - uv[pairs.datum]), nan=np.inf)


WIDENED = 4.0, 2.0, 1.0
"""Of the rounds, how many times wider than the detector's noise places may be: four points fix a pose badly."""
ALIKE = float(np.radians(3.0)), 0.03
"""Radians, and share of the distance, by less than which poses differ of which one is extended."""


class Scene(NamedTuple):
    """One type and Γ: its typed pairs, and ``uv`` (A, 2), the data's undistorted pixels."""

    of: TypeIndex
    pairs: Typed
    data: Data
    kb: KnowledgeBase
    uv: Floats


def scene_of(index: TypeIndex, data: Data, kb: KnowledgeBase) -> Scene:
    """What the plain generators ask for."""
    camera = data.camera
    return Scene(index, pairs_of(index, data), data, kb, camera.to_pixels(camera.normalised(data.uv)))


def worth(scene: Scene, poses: Floats, wider: float) -> Floats:
    """(N,) the evidence (§8) for poses (N, 4, 4) by the nearest datum of each feature shown by the nearest view cell.

    Noise is so many times wider.

    A datum may serve several features: what is left is verified.
    """
    index, pairs, kb = scene.of, scene.pairs, scene.kb
    features = index.object_type.seen_features
    hit = np.array([kb.rates.hit.get(feature.type, 0.8) for feature in features])
    sigma = wider * np.array([kb.rates.sigma_of(feature.type) for feature in features])
    apart_by = off(poses, pairs, scene.uv, scene.data.camera)
    clutter = clutter_density(kb, scene.data)[pairs.datum]
    gain = np.log1p(hit[pairs.feature] * (density(apart_by, sigma[pairs.feature]) / clutter - 1.0))
    missed = np.log(1.0 - hit)
    total = np.tile(missed, (len(poses), 1))
    held, first = np.unique(pairs.feature, return_index=True)
    total[:, held] = np.maximum(np.maximum.reduceat(gain, first, axis=1), missed[held])
    return np.asarray(np.where(_shown(scene, poses), total, 0.0).sum(axis=1))


def _shown(scene: Scene, poses: Floats) -> Mask:
    """(N, F) what the nearest view cell of each pose shows."""
    cells = scene.of.cells
    viewpoints = np.array([inverse(pose)[:3, 3] for pose in poses]).reshape(-1, 3) - cells.centre
    return np.asarray(cells.visible[cells.nearest(viewpoints / np.linalg.norm(viewpoints, axis=1, keepdims=True))])


def best(scene: Scene, poses: Floats, values: Floats, most: int) -> Indices:
    """The best of poses (N, 4, 4) by their ``values`` (N,), no two alike."""
    middles = poses[:, :3, :3] @ scene.of.cells.centre + poses[:, :3, 3]
    return np.array(apart(poses, middles, values, most, ALIKE), np.intp)


def extended(scene: Scene, poses: Floats, most: int) -> list[Floats]:
    """At most so many refined poses (4, 4), no two alike, by their evidence, the best first."""
    for wider in WIDENED:
        poses = np.array([_refined(scene, pose, wider) for pose in poses]).reshape(-1, 4, 4)
    return [poses[i] for i in best(scene, poses, worth(scene, poses, WIDENED[-1]), most)]


def _refined(scene: Scene, pose: Floats, wider: float) -> Floats:
    """Least squares on the features that the pose expects and that have a datum near.

    As it was where those are too few.
    """
    pairs, sigma = scene.pairs, scene.kb.rates.sigma
    reach = wider * scene.kb.rates.match_tolerance
    apart_by = off(pose[None], pairs, scene.uv, scene.data.camera)[0]
    near = np.flatnonzero((apart_by <= reach) & _shown(scene, pose[None])[0, pairs.feature])
    near = near[np.argsort(apart_by[near], kind="stable")]
    chosen: list[int] = []
    features, data = set(), set()
    for pair in near.tolist():
        feature, datum = pairs.feature[pair], pairs.datum[pair]
        if feature not in features and datum not in data:
            chosen.append(pair)
            features.add(feature)
            data.add(datum)
    if len(chosen) < FEWEST:
        return pose
    points, uv = pairs.points[pairs.feature[chosen]], scene.data.uv[pairs.datum[chosen]]
    weights = np.ones((1, len(chosen)))
    return np.asarray(
        refined_poses(pose[None], points[None], uv[None], weights, scene.data.camera, huber=wider * sigma)[0]
    )


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
