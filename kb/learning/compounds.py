"""Compound features: features of one place that the learning pictures showed together (A1).

Two features qualify as parts of one compound where all of this was measured of them:

* they are near: within ``OF_SIZE`` of the larger one's width, as far as observations of one feature may be;
* they share viewing directions: of the pictures for which the lobes of either hold, those of both hold for at least
  ``OFTEN``;
* they were found together: of the pictures that showed either, at least ``OFTEN`` showed both, and no smaller share
  than the ``bar``.

What is seen from the same side is found together the more often for that alone, at any distance. So the bar is measured
on the object itself, by its pairs that share viewing directions and stand apart: so high that at most ``BY_CHANCE`` of
the pairs that qualify would reach it if to be near made no difference. Compounds are the groups of complete linkage:
every pair of a group qualifies, and the groups are disjoint.

Each learned feature belongs to the part of its type whose surface is nearest (A1, A3). Parts and pieces of
the mesh know each other by their places, so that an author may rename parts, nest them, or take some out.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

from geometry.arrays import Floats, Ints, Mask
from geometry.cones import even_directions
from kb.clouds.cloud import ObjectType
from kb.clouds.learned import LearnedCloud, numbered
from kb.clouds.lobes import object_nodes, place
from kb.learning.again import STRETCH
from kb.learning.observations import Observations
from kb.surfaces.nearness import Nearness
from kb.surfaces.pieces import Piece, pieces_of

Shares = NDArray[np.float32]


OF_SIZE = 0.25
"""Share of its size within which what is seen is of one place: the middle of what is large, or round, is not exact."""
OFTEN = 0.5
"""More often together than alone."""
BY_CHANCE = 0.1
"""Of the pairs that qualify, how many may be found together for no other reason than the viewpoint."""


class Pictures(NamedTuple):
    """What learning looked at: an object of a ``diameter`` (m), from ``directions``, at ``ranges`` (K,) m."""

    diameter: float
    ranges: Floats
    directions: int


def compounds_of(
    cloud: LearnedCloud, seen: Observations, groups: Sequence[NDArray[np.intp]], pictures: Pictures
) -> Ints:
    """(F,) the compound of each feature, counted from 1; 0 of those in none.

    Keypoints and sides of edges make compounds of their own.

    ``groups``: the observations in ``seen`` of each feature's lobes.
    """
    sizes = len(pictures.ranges)
    shown = np.zeros((len(cloud.at), pictures.directions * sizes), bool)
    for feature, group in enumerate(groups):
        shown[feature, seen.view[group] * sizes + seen.level[group]] = True
    held, width = pictures_held(cloud, pictures), widths(cloud, pictures.diameter)
    result, sided = np.zeros(len(cloud.at), np.int64), np.zeros(len(cloud.at), bool)
    sided[cloud.feature[cloud.sided]] = True
    for some in (np.flatnonzero(~sided), np.flatnonzero(sided)):
        found = grouped(shown[some], held[some], cloud.at[some], width[some])
        result[some] = np.where(found > 0, found + result.max(initial=0), 0)
    return numbered(result)


def pictures_held(cloud: LearnedCloud, pictures: Pictures) -> Mask:
    """(F, directions · K) the pictures, by direction and then by range, for which some lobe of a feature holds."""
    towards = cloud.axis @ even_directions(pictures.directions).T >= np.cos(cloud.half_angle)[:, None]
    within = (pictures.ranges >= cloud.r_min[:, None]) & (pictures.ranges <= cloud.r_max[:, None])
    held = np.zeros((len(cloud.at), pictures.directions, len(pictures.ranges)), bool)
    for lobe, feature in enumerate(cloud.feature.tolist()):
        held[feature] |= towards[lobe][:, None] & within[lobe]
    return held.reshape(len(cloud.at), pictures.directions * len(pictures.ranges))


def widths(cloud: LearnedCloud, diameter: float) -> Floats:
    """(F,) metres across what each feature is made of.

    A keypoint's diameter, of its widest lobe, or the stretch that a side stands for.
    """
    widest = np.zeros(len(cloud.at))
    np.maximum.at(widest, cloud.feature, np.where(cloud.sided, STRETCH * diameter, cloud.size))
    return widest


def grouped(shown: Mask, held: Mask, at: Floats, width: Floats) -> Ints:
    """(F,) the compound of each of F features of one kind, counted from 1; 0 of those in none.

    ``shown`` (F, N) which pictures showed each, and ``held`` (F, N) for which its lobes hold; ``at`` (F, 3) m;
    ``width`` (F,) m.
    """
    similar, apart = together(shown), cdist(at, at)
    shared = together(held) >= OFTEN
    np.fill_diagonal(shared, val=False)
    near = shared & (apart < OF_SIZE * np.maximum(width[:, None], width))
    qualify = near & (
        similar >= bar(similar[np.triu(near)], similar[np.triu(shared & (apart >= (width[:, None] + width) / 2.0))])
    )
    return linked(similar, apart, qualify)


def together(pictures: Mask) -> Shares:
    """(F, F) Jaccard's share: of the pictures (F, N) of at least one of two features, how many are of both.

    0 where there are none.
    """
    some = pictures.astype(np.float32)
    both, single = some @ some.T, some.sum(axis=1)
    return np.asarray(both / np.maximum(single[:, None] + single - both, 1.0), np.float32)


def bar(near: Shares, others: Shares) -> float:
    """The share to which pairs must be found together.

    The least of the ``near`` ones' (N,) that tells them from ``others`` (M,), or infinite.
    """
    shares, reach = np.unique(near[near >= OFTEN]), np.sort(others)
    by_chance = (len(others) - np.searchsorted(reach, shares) + 1.0) / (len(others) + 1.0) * len(near)
    qualify = len(near) - np.searchsorted(np.sort(near), shares)
    good = shares[by_chance <= BY_CHANCE * qualify]
    return float(good.min(initial=np.inf))


def within_parts(compound: Ints, part: Ints) -> Ints:
    """(F,) the compounds of features that belong to parts (F,) of a type.

    What of one is in another part is another, or none (A1).
    """
    return numbered(np.where(compound > 0, compound * (part.max(initial=0) + 1) + part, 0))


def linked(similar: Shares, apart: Floats, qualify: Mask) -> Ints:
    """(F,) groups of complete linkage, counted from 1, 0 of those that are alone.

    Those most often together first, of equals the nearest.

    All of a group ``qualify`` (F, F) with each other.
    """
    result = np.zeros(len(qualify), np.int64)
    count, component = connected_components(csr_array(qualify), directed=False) if len(qualify) else (0, result)
    order = np.argsort(component, kind="stable")
    for members in np.split(order, np.searchsorted(component[order], np.arange(1, count))):
        if len(members) < 2:
            continue
        rows, columns = np.triu_indices(len(members), 1)
        one, other = members[rows], members[columns]
        rank = np.empty(len(one))
        rank[np.lexsort((apart[one, other], -similar[one, other]))] = np.arange(len(one))
        never = float(len(one))
        tree = linkage(np.where(qualify[one, other], rank, never), "complete")
        result[members] = fcluster(tree, never - 0.5, "distance") + result.max()
    return numbered(result)


def with_parts(kind: ObjectType, cloud: LearnedCloud) -> LearnedCloud:
    """The cloud with its features and their compounds, given to the atomic parts of its type's tree.

    To the whole where there is no other.
    """
    part = _part_of(kind, cloud)
    return replace(cloud, part=part, compound=within_parts(cloud.compound, part))


def _part_of(kind: ObjectType, cloud: LearnedCloud) -> NDArray[np.int64]:
    """(F,) indices into the objects of the tree."""
    nodes = object_nodes(kind.tree)
    leaves = [index for index, node in enumerate(nodes) if not kind.tree.nodes[node].below]
    if kind.surface is None or len(nodes) == 1 or not len(cloud.at):
        return np.zeros(len(cloud.at), np.int64)
    places = np.array([place(kind.tree, nodes[index])[:3, 3] for index in leaves])
    pieces = pieces_of(kind.surface)
    if not pieces:  # nothing but the places tells the parts apart
        return np.array(leaves, np.int64)[_nearest(cloud.at, places)]
    far = [
        Nearness(kind.surface.vertices, kind.surface.triangles[piece.triangles]).distance(cloud.at) for piece in pieces
    ]
    return np.array(leaves, np.int64)[_owners(pieces, places)[np.argmin(far, axis=0)]]


def _nearest(points: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.intp]:
    return np.asarray(np.linalg.norm(points[:, None] - places[None], axis=2).argmin(axis=1), np.intp)


def _owners(pieces: Sequence[Piece], places: NDArray[np.float64]) -> NDArray[np.intp]:
    """(P,) which of the ``places`` (N, 3) of parts each piece is.

    One to one where they are as many, else the nearest.
    """
    middles = np.array([piece.at for piece in pieces])
    if len(pieces) != len(places):
        return _nearest(middles, places)
    far = np.linalg.norm(middles[:, None] - places[None], axis=2)
    order = np.abs(
        np.arange(len(pieces))[:, None] - np.arange(len(places))[None]
    )  # of pieces in one place the first is the first
    return np.asarray(linear_sum_assignment(far + 1e-9 * far.max() * order)[1], np.intp)
