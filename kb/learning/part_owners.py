"""To which part of its type each learned feature belongs: the one whose surface is nearest (A1, A3).

Parts and pieces of the mesh know each other by their places, so that an author may rename parts, nest them, or take
some out.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kb.clouds.cloud import ObjectType
from kb.clouds.learned import LearnedCloud
from kb.clouds.tree import object_nodes, place
from kb.learning.compounds import within_parts
from kb.surfaces.nearness import Nearness
from kb.surfaces.pieces import Piece, pieces_of


def with_parts(kind: ObjectType, cloud: LearnedCloud) -> LearnedCloud:
    """The cloud with its features, and what of its compounds is in each, given to the parts of its type's tree that hold no parts.

    To the whole where there is no other.
    """
    part = _part_of(kind, cloud)
    return replace(cloud, part=part, compound=within_parts(cloud.compound, part))


def _part_of(kind: ObjectType, cloud: LearnedCloud) -> NDArray[np.int64]:
    """(F,) indices into the objects of the tree."""
    nodes = object_nodes(kind.tree)
    leaves = [index for index, node in enumerate(nodes) if not kind.tree.out_degree(node)]
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
    """(P,) which of the ``places`` (N, 3) of parts each piece is: one to one where they are as many, else the nearest."""
    from scipy.optimize import linear_sum_assignment

    middles = np.array([piece.at for piece in pieces])
    if len(pieces) != len(places):
        return _nearest(middles, places)
    far = np.linalg.norm(middles[:, None] - places[None], axis=2)
    order = np.abs(
        np.arange(len(pieces))[:, None] - np.arange(len(places))[None]
    )  # of pieces in one place the first is the first
    return np.asarray(linear_sum_assignment(far + 1e-9 * far.max() * order)[1], np.intp)
