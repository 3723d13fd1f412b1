"""A type that was written by hand, made ready for search.

* ``TypeIndex``: what is computed once a type: its view cells, its features' places and dv
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.measures.valuation import compatible
from plogic.search.links import feature_links
from plogic.search.symmetry import permutations, unique_sets
from plogic.search.triples import PlaneTriples, plane_triples
from plogic.search.view_cells import ViewCells, view_cells

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kb.cloud import ObjectType
    from plogic.search.data import Data

ANCHORS = 16
"""Features that seeds and pairs are made of: the most distinctive ones."""


@dataclass(frozen=True)
class TypeIndex:
    """One type made ready for search.

    ``points`` (F, 3) metres; ``weights`` (F,) dv; ``anchors`` feature indices, the most distinctive; ``links`` (N, 2) joined by edges;
    ``triples`` of neighbours on planes.
    """

    object_type: ObjectType
    cells: ViewCells
    points: NDArray[np.float64]
    weights: NDArray[np.float64]
    anchors: NDArray[np.intp]
    links: NDArray[np.intp]
    triples: PlaneTriples

    def allowed(self, data: Data) -> NDArray[np.bool_]:
        """(F, A) the data of a type that the feature has in any of its lobes."""
        types = [frozenset(a.type for a in feature.appearances) for feature in self.object_type.features]
        return compatible(types, data.types)


def type_index(object_type: ObjectType, dv: Mapping[str, float]) -> TypeIndex:
    """Build the index of one type; dv 0 throughout (one feature type in all of Σo) counts every feature alike."""
    features = object_type.features
    weights = np.array([dv[feature.type] for feature in features])
    if not weights.any():
        weights = np.ones(len(features))
    points = np.array([feature.at for feature in features]).reshape(-1, 3)
    links = feature_links(points, [feature.arms for feature in features])
    moves = permutations(points, object_type.symmetries)
    triples = plane_triples(features)
    return TypeIndex(
        object_type,
        view_cells(object_type),
        points,
        weights,
        _anchors(weights),
        links[unique_sets(links, moves)],
        triples.take(unique_sets(triples.features, moves)),
    )


def _anchors(weights: NDArray[np.float64]) -> NDArray[np.intp]:
    """The features at least half as distinctive as the best, or the ``ANCHORS`` most distinctive where those are fewer than four."""
    order = np.argsort(-weights, kind="stable")[:ANCHORS]
    top = order[weights[order] >= 0.5 * weights.max()]
    return np.sort(top if len(top) >= 4 else order)
