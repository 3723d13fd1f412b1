"""From observations to a cloud: what was seen at one place of the surface is one feature.

What looked alike, one lobe of it.

The hit rate of a lobe is measured over all pictures whose viewpoint it holds, also those in which nothing was seen;
over as many as a cone of its size holds on average, where it holds fewer: a lobe around the one direction that showed
it was not seen from beside it.
"""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geometry.arrays import Floats
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
STEP, END = 1.25, 1.5
"""By this factor a lobe reaches nearer and farther than the pictures that showed it: about half way to the next; END
where there is no next."""


class _Lobe(NamedTuple):
    members: NDArray[np.intp]
    axis: Floats
    half_angle: float
    hit: float


def cloud_of(seen: Observations, diameter: float, f_ref: float, count: int, most: int = MOST) -> LearnedCloud:
    """The cloud of a type with its compounds from what was seen of it from ``even_directions(count)``.

    Its words are not assigned yet (all 0).
    """
    directions = even_directions(count)
    points = _chosen(seen, _places(seen, np.flatnonzero(~seen.sided)), most)
    sides = _chosen(seen, side_places(seen, np.flatnonzero(seen.sided), diameter), MOST_SIDES)
    several = [(group, _lobes(seen, group, directions)) for group in points]
    several += [
        (group, [lobe for lobe in _lobes(seen, group, directions) if lobe.hit >= SIDES_SEEN]) for group in sides
    ]
    several = [(group, lobes) for group, lobes in several if lobes]
    cloud = LearnedCloud(
        **_feature_arrays(seen, [group for group, _ in several]),
        **_lobe_arrays(seen, [(f, lobe) for f, (_, lobes) in enumerate(several) for lobe in lobes], diameter, f_ref),
    )
    shown = [np.concatenate([lobe.members for lobe in lobes]) for _, lobes in several]
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


def _lobes(seen: Observations, group: NDArray[np.intp], directions: Floats) -> list[_Lobe]:
    """One feature's observations by what they look like; they were looked for from ``directions`` (V, 3)."""
    lobes = []
    looks = seen.descriptor[:, LOOKS][:, :COLOURS] if seen.sided[group[0]] else seen.descriptor
    left = group[np.argsort(-seen.hit[group], kind="stable")]
    limit = TINTED if seen.sided[group[0]] else ALIKE[seen.descriptor.shape[1]]
    while len(left):
        direction = seen.direction[left]
        alike = _apart(looks[left], looks[left[0]]) < limit
        alike &= direction @ direction[0] > TOGETHER
        alike[0] = True
        members, direction = left[alike], direction[alike]
        left = left[~alike]
        axis = np.add.reduce(direction)
        axis = axis / math.sqrt(axis @ axis)
        widest = math.acos(min(1.0, np.minimum.reduce(direction @ axis)))  # means take most of the time of few numbers
        half_angle = widest + BEYOND * spacing(len(directions))
        lobes.append(_Lobe(members, axis, half_angle, _hit(seen, members, axis, half_angle, directions)))
    return lobes


def _hit(seen: Observations, members: NDArray[np.intp], axis: Floats, half_angle: float, directions: Floats) -> float:
    """The hit rate of a lobe. A picture that shows several points of one stretch of an edge shows that once."""
    level, hit = seen.level[members].tolist(), seen.hit[members].tolist()
    reach = math.cos(half_angle)
    held = int(np.count_nonzero(directions @ axis >= reach))
    pictures = max(held, len(directions) * (1.0 - reach) / 2.0) * (max(level) - min(level) + 1)
    if seen.sided[members[0]]:
        best: dict[tuple[int, int], float] = {}
        for key, one in zip(zip(level, seen.view[members].tolist(), strict=True), hit, strict=True):
            best[key] = max(one, best.get(key, 0.0))
        hit = list(best.values())
    return min(sum(hit) / max(pictures, 1.0), 1.0)


def _apart(some: NDArray[np.float32], one: NDArray[np.float32]) -> Floats:
    """Distances of mean descriptors; those of ORB are compared as bytes of bits."""
    if some.shape[1] == 32:
        bits = np.unpackbits(np.rint(some).astype(np.uint8) ^ np.rint(one).astype(np.uint8), axis=1)
        return np.asarray(bits.sum(axis=1), np.float64)
    off = some - one
    return np.sqrt(np.einsum("nd,nd->n", off, off)).astype(np.float64)


def _feature_arrays(seen: Observations, groups: list[NDArray[np.intp]]) -> dict[str, Any]:
    at = np.array([np.average(seen.at[g], axis=0, weights=seen.hit[g]) for g in groups]).reshape(-1, 3)
    spread = [_spread(seen, g, middle) for g, middle in zip(groups, at, strict=True)]
    least = [0.3 * float(seen.pixel[g].min()) for g in groups]
    normal = np.array([seen.normal[g].mean(axis=0) for g in groups]).reshape(-1, 3)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    outward = np.array([seen.direction[g].mean(axis=0) for g in groups]).reshape(-1, 3)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return {
        "at": at,
        "sigma": np.maximum(spread, least),
        "normal": np.where(length > 1e-6, normal / np.maximum(length, 1e-6), outward),
        "word": np.zeros(len(groups), np.int64),
    }


def _spread(seen: Observations, group: NDArray[np.intp], middle: Floats) -> float:
    """Standard deviation of a place along one axis; of a stretch of an edge across it."""
    off = seen.at[group] - middle
    if not seen.sided[group[0]]:
        return float(np.sqrt((off**2).sum(axis=1).mean() / 2.0))
    return float(np.sqrt(((off * seen.up[group]).sum(axis=1) ** 2).mean()))


def _lobe_arrays(seen: Observations, lobes: list[tuple[int, _Lobe]], diameter: float, f_ref: float) -> dict[str, Any]:
    ranges = _ranges(diameter, f_ref)
    axis = np.array([lobe.axis for _, lobe in lobes]).reshape(-1, 3)
    half = np.array([lobe.half_angle for _, lobe in lobes])
    up = np.array([seen.up[lobe.members].mean(axis=0) for _, lobe in lobes]).reshape(-1, 3)
    up -= (up * axis).sum(axis=1, keepdims=True) * axis
    up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-12)
    nearest = np.array([seen.level[lobe.members].min() for _, lobe in lobes], int)
    farthest = np.array([seen.level[lobe.members].max() for _, lobe in lobes], int)
    descriptor = np.rint([_mean(seen, lobe.members) for _, lobe in lobes])
    return {
        "feature": np.array([f for f, _ in lobes], np.int64),
        "lobe_word": np.zeros(len(lobes), np.int64),
        "descriptor": descriptor.astype(np.uint8).reshape(len(lobes), seen.descriptor.shape[1]),
        "axis": axis,
        "half_angle": half,
        "r_min": ranges[nearest] / np.where(nearest == 0, END, STEP),
        "r_max": ranges[farthest] * np.where(farthest == len(PIXELS) - 1, END, STEP),
        "hit": np.array([lobe.hit for _, lobe in lobes]),
        "up": up,
        "size": np.array([_size(seen.size[lobe.members]) for _, lobe in lobes]),
    }


def _mean(seen: Observations, members: NDArray[np.intp]) -> NDArray[np.float32]:
    """The mean descriptor (D,); of sides also how much their contrast varies."""
    some = seen.descriptor[members]
    mean = np.add.reduce(some) / np.float32(len(some))
    if seen.sided[members[0]]:
        off = some[:, LOOKS.stop - 1] - mean[LOOKS.stop - 1]
        mean[VARIED] = min(math.sqrt(off @ off / len(off)), 255.0)
    return np.asarray(mean, np.float32)


def _size(sizes: Floats) -> float:
    """The geometric mean (N,); 0 of sides of edges."""
    return float(np.exp(np.log(sizes).mean())) if sizes[0] > 0.0 else 0.0
