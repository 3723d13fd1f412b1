"""From observations to a cloud: what was seen at one place of the surface is one feature.

What looked alike, one lobe of it.

The hit rate of a lobe is measured over all pictures whose viewpoint it holds, also those in which nothing was seen;
over as many as a cone of its size holds on average, where it holds fewer: a lobe around the one direction that showed
it was not seen from beside it.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geometry.arrays import Floats, Ints, Mask
from geometry.cones import even_directions, spacing
from kb.clouds.learned import LearnedCloud
from kb.clouds.words import COLOURS
from kb.learning.again import LOOKS, STRETCH, VARIED, WIDE
from kb.learning.compounds import OF_SIZE, Pictures, compounds_of
from kb.learning.observations import PIXELS, Observations, distance

SAME_PLACE = 1.6
"""Pixels (of the coarser of two pictures), or ``OF_SIZE`` of the size, within which observations are of one place: what
is large has its middle less exactly, and the middle of what is round moves over it with the viewpoint. ORB's sizes are
those of its patches, and do not count."""
SAME_SIZE, SAME_UP = 0.3, 0.8
"""Greatest logarithm of the ratio of sizes, least cosine between directions, of one feature."""
ALIKE = {128: 200.0, 138: 210.0, 32: 45.0}
"""Distance of descriptors within one lobe, by their bytes."""
TOGETHER = 0.85
"""Least cosine between directions of view within one lobe."""
LEAST_SEEN = 3
"""Pictures that must show a feature."""
MOST, MOST_SIDES = 4000, 2000
"""Features of one type: keypoints, and sides of edges."""
TINTED = 25.0
"""The same of sides, by their colours."""
SIDES_SEEN = 0.25
"""Least hit rate of a side's lobe: what is seen more seldom is not worth the looking."""
PIXELS_WIDE = 1.5
"""Pixels across, where that is wider."""
SAME_WAY = 0.8
"""Least cosine between the directions of one stretch."""
BEYOND = 0.8
"""So much of the angle between neighbouring directions a lobe reaches beyond those that showed it."""
STEP, END, NEARER = 1.25, 1.5, 8.0
"""By this factor a lobe reaches nearer and farther than the pictures that showed it: about half way to the next; END
where there is none farther away. What is seen in the largest picture is seen NEARER as well, only larger: of 12
objects in the ``ycb`` photos made twice as large 11 are found so, 4 with END (``benchmarks/enlarged.py``)."""


class _Groups:
    """Observations in groups of one or more: sums over each."""

    def __init__(self, groups: Sequence[NDArray[np.intp]]) -> None:
        self.which = np.concatenate([*groups, np.zeros(0, np.intp)])
        self.count = np.array([len(group) for group in groups], np.int64)
        self.start = np.cumsum(self.count) - self.count
        self.owner = np.repeat(np.arange(len(groups)), self.count)

    def over(self, how: np.ufunc, values: NDArray[Any]) -> NDArray[Any]:
        """(G, ...) of values (N, ...), one of each of ``which``."""
        return np.asarray(how.reduceat(values, self.start, axis=0)) if len(self.start) else values[:0]

    def mean(self, values: NDArray[Any]) -> NDArray[Any]:
        """(G, ...) of values (N, ...)."""
        total = self.over(np.add, values)
        return np.asarray(total / self.count.astype(total.dtype).reshape(-1, *[1] * (values.ndim - 1)))


class _Lobes(NamedTuple):
    """L lobes: what was seen of each, their axes (L, 3), half angles, hit rates, and whether they are of sides."""

    groups: _Groups
    axis: Floats
    half_angle: Floats
    hit: Floats
    sided: Mask


def cloud_of(seen: Observations, diameter: float, f_ref: float, count: int, most: int = MOST) -> LearnedCloud:
    """The cloud of a type with its compounds from what was seen of it from ``even_directions(count)``.

    Its words are not assigned yet (all 0).
    """
    directions = even_directions(count)
    points = _chosen(seen, _places(seen, np.flatnonzero(~seen.sided)), most)
    sides = _chosen(seen, side_places(seen, np.flatnonzero(seen.sided), diameter), MOST_SIDES)
    groups = [*points, *sides]
    alike = [_alike(seen, group) for group in groups]
    feature = np.repeat(np.arange(len(groups)), [len(some) for some in alike])
    members = [one for some in alike for one in some]
    lobes = _lobes(seen, members, directions)
    good = np.flatnonzero(~lobes.sided | (lobes.hit >= SIDES_SEEN))
    which, feature = np.unique(feature[good], return_inverse=True)
    kept = _Groups([members[i] for i in good])
    lobes = _Lobes(kept, lobes.axis[good], lobes.half_angle[good], lobes.hit[good], lobes.sided[good])
    cloud = LearnedCloud(
        **_feature_arrays(seen, [groups[i] for i in which]), **_lobe_arrays(seen, lobes, feature, diameter, f_ref)
    )
    ends = np.cumsum(np.bincount(feature, lobes.groups.count, len(which)).astype(int))
    shown = np.split(lobes.groups.which, ends)[: len(which)]
    return replace(
        cloud, compound=compounds_of(cloud, seen, shown, Pictures(diameter, _ranges(diameter, f_ref), count))
    )


def _ranges(diameter: float, f_ref: float) -> Floats:
    """(K,) metres from which the pictures of each size were taken."""
    return np.array([distance(pixels, diameter, f_ref) for pixels in PIXELS])


def _chosen(seen: Observations, groups: list[NDArray[np.intp]], most: int) -> list[NDArray[np.intp]]:
    """Those of the groups that become features."""
    groups = [group for group in groups if len(group) >= LEAST_SEEN]
    return [groups[i] for i in sorted(_best(seen, groups)[:most], key=lambda i: int(groups[i][0]))]


def _places(seen: Observations, which: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """The observations ``which`` in groups, each about one place, size and direction; the surest first."""
    if not len(which):
        return []
    tree, free = cKDTree(seen.at[which]), np.ones(len(seen), bool)
    reach = reaches(seen)
    groups = []
    for i in which[np.lexsort((which, reach[which], -seen.hit[which]))]:
        if not free[i]:
            continue
        near = which[tree.query_ball_point(seen.at[i], 2.0 * reach[i], return_sorted=True)]
        near = near[free[near]]
        apart = np.linalg.norm(seen.at[near] - seen.at[i], axis=1)
        one = (apart <= np.maximum(reach[near], reach[i])) & (
            np.abs(np.log(seen.size[near] / seen.size[i])) < SAME_SIZE
        )
        one &= (seen.up[near] @ seen.up[i] > SAME_UP) | (near == i)
        free[near[one]] = False
        groups.append(near[one])
    return groups


def reaches(seen: Observations) -> Floats:
    """(N,) metres within which others are of one place with each."""
    share = 0.0 if seen.descriptor.shape[1] == 32 else OF_SIZE
    return np.maximum(SAME_PLACE * seen.pixel, share * seen.size)


def _best(seen: Observations, groups: list[NDArray[np.intp]]) -> list[int]:
    """All groups, in turns: the best from each direction, then the second best from each, and so on.

    So no side is forgotten for another.

    Best is what was seen most often, in pictures of all sizes and from all sides.
    """
    weight = np.array([seen.hit[group].sum() for group in groups])
    pairs = {(view, i) for i, group in enumerate(groups) for view in seen.view[group].tolist()}
    view, which = np.array(sorted(pairs), np.intp).reshape(-1, 2).T
    which = which[np.lexsort((-weight[which], view))]
    turns = np.full(len(groups), len(groups))
    np.minimum.at(turns, which, np.arange(len(which)) - np.searchsorted(view, view))
    return [int(i) for i in np.lexsort((np.arange(len(groups)), -weight, turns))]


def side_places(seen: Observations, which: NDArray[np.intp], diameter: float) -> list[NDArray[np.intp]]:
    """Observations ``which`` of sides in groups, each of one stretch of an edge, of any colours; surest first."""
    if not len(which):
        return []
    at, up, pixel = seen.at[which], seen.up[which], seen.pixel[which]
    tree, free, groups = cKDTree(at), np.ones(len(which), bool), []
    for i in np.lexsort((np.arange(len(which)), pixel, -seen.hit[which])):
        if not free[i]:
            continue
        near = np.array(tree.query_ball_point(at[i], STRETCH * diameter, return_sorted=True), np.intp)
        near = near[free[near]]
        across = np.abs((at[near] - at[i]) @ up[i])
        one = (across < np.maximum(WIDE * diameter, PIXELS_WIDE * pixel[near])) & (up[near] @ up[i] > SAME_WAY)
        one |= near == i
        free[near[one]] = False
        groups.append(which[near[one]])
    return groups


def _alike(seen: Observations, group: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """One feature's observations by what they look like: those of each lobe."""
    found = []
    looks = seen.descriptor[:, LOOKS][:, :COLOURS] if seen.sided[group[0]] else seen.descriptor
    left = group[np.argsort(-seen.hit[group], kind="stable")]
    limit = TINTED if seen.sided[group[0]] else ALIKE[seen.descriptor.shape[1]]
    while len(left):
        direction = seen.direction[left]
        alike = _apart(looks[left], looks[left[0]]) < limit
        alike &= direction @ direction[0] > TOGETHER
        alike[0] = True
        found.append(left[alike])
        left = left[~alike]
    return found


def _lobes(seen: Observations, members: Sequence[NDArray[np.intp]], directions: Floats) -> _Lobes:
    """Lobes of observations, of at least one each, that were looked for from ``directions`` (V, 3).

    A picture that shows several points of one stretch of an edge shows that once.
    """
    some = _Groups(members)
    direction, level, view = seen.direction[some.which], seen.level[some.which], seen.view[some.which]
    axis = some.mean(direction)
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    widest = some.over(np.minimum, (direction * axis[some.owner]).sum(axis=1))
    half_angle = np.arccos(np.minimum(widest, 1.0)) + BEYOND * spacing(len(directions))
    reach = np.cos(half_angle)
    held = (axis @ directions.T >= reach[:, None]).sum(axis=1)
    levels = some.over(np.maximum, level) - some.over(np.minimum, level) + 1
    pictures = np.maximum(held, len(directions) * (1.0 - reach) / 2.0) * levels
    hit, sided = seen.hit[some.which], seen.sided[some.which]
    order = np.lexsort((-hit, view, level, some.owner))
    key = np.column_stack([some.owner, level, view])[order]
    again = np.r_[False, (key[1:] == key[:-1]).all(axis=1)][: len(order)] & sided[order]
    hits = np.bincount(some.owner[order][~again], hit[order][~again], len(members))
    return _Lobes(some, axis, half_angle, np.minimum(hits / np.maximum(pictures, 1.0), 1.0), sided[some.start])


def _apart(some: NDArray[np.float32], one: NDArray[np.float32]) -> Floats:
    """Distances of mean descriptors; those of ORB are compared as bytes of bits."""
    if some.shape[1] == 32:
        bits = np.unpackbits(np.rint(some).astype(np.uint8) ^ np.rint(one).astype(np.uint8), axis=1)
        return np.asarray(bits.sum(axis=1), np.float64)
    off = some - one
    return np.sqrt(np.einsum("nd,nd->n", off, off)).astype(np.float64)


def _feature_arrays(seen: Observations, groups: list[NDArray[np.intp]]) -> dict[str, Any]:
    some = _Groups(groups)
    place, weight = seen.at[some.which], seen.hit[some.which][:, None]
    at = some.over(np.add, place * weight) / some.over(np.add, weight)
    off = place - at[some.owner]
    across = np.sqrt(some.mean((off * seen.up[some.which]).sum(axis=1) ** 2))  # of a stretch of an edge across it alone
    spread = np.where(seen.sided[some.which][some.start], across, np.sqrt(some.mean((off**2).sum(axis=1)) / 2.0))
    normal, outward = some.mean(seen.normal[some.which]), some.mean(seen.direction[some.which])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    outward = outward / np.linalg.norm(outward, axis=1, keepdims=True)
    return {
        "at": at,
        "sigma": np.maximum(spread, 0.3 * some.over(np.minimum, seen.pixel[some.which])),
        "normal": np.where(length > 1e-6, normal / np.maximum(length, 1e-6), outward),
        "word": np.zeros(len(groups), np.int64),
    }


def _lobe_arrays(seen: Observations, lobes: _Lobes, feature: Ints, diameter: float, f_ref: float) -> dict[str, Any]:
    ranges, some = _ranges(diameter, f_ref), lobes.groups
    up = some.mean(seen.up[some.which])
    up -= (up * lobes.axis).sum(axis=1, keepdims=True) * lobes.axis
    up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-12)
    nearest, farthest = (some.over(how, seen.level[some.which]) for how in (np.minimum, np.maximum))
    size = np.where(seen.sided[some.which], 1.0, seen.size[some.which])
    return {
        "feature": feature.astype(np.int64),
        "lobe_word": np.zeros(len(feature), np.int64),
        "descriptor": np.rint(_means(seen, some)).astype(np.uint8),
        "axis": lobes.axis,
        "half_angle": lobes.half_angle,
        "r_min": ranges[nearest] / np.where(nearest == 0, NEARER, STEP),
        "r_max": ranges[farthest] * np.where(farthest == len(PIXELS) - 1, END, STEP),
        "hit": lobes.hit,
        "up": up,
        "size": np.where(lobes.sided, 0.0, np.exp(some.mean(np.log(size)))),
    }


def _means(seen: Observations, some: _Groups) -> NDArray[np.float32]:
    """(G, D) mean descriptors; of sides also how much their contrast varies."""
    mean = some.mean(seen.descriptor[some.which])
    sided = np.flatnonzero(seen.sided[some.which][some.start])
    if len(sided):
        contrast = LOOKS.stop - 1
        off = seen.descriptor[some.which, contrast] - mean[some.owner, contrast]
        mean[sided, VARIED] = np.minimum(np.sqrt(some.mean(off**2)), 255.0)[sided]
    return np.asarray(mean, np.float32)
