"""A type that was written by hand, made ready for search.

* ``TypeIndex``: what is computed once a type: its view cells, its features' places and dv
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.hand.links import feature_links
from plogic.match.hand.symmetry import permutations, unique_sets
from plogic.match.hand.triples import PlaneTriples, plane_triples
from plogic.match.hand.view_cells import ViewCells, view_cells
from plogic.measures.valuation import compatible

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType
    from plogic.match.gamma.data import Data

CELLS_TRIED = 24
"""View cells whose rank is taken for the tie-break of attention, about: every so many-th of them."""
ANCHORS = 16
"""Features that seeds and pairs are made of: the most distinctive ones."""


@dataclass(frozen=True)
class TypeIndex:
    """One type made ready for search.

    ``points`` (F, 3) metres; ``weights`` (F,) dv; ``anchors`` feature indices, the most distinctive; ``links`` (N, 2)
    joined by edges.
    """

    object_type: ObjectType
    cells: ViewCells
    points: NDArray[np.float64]
    weights: NDArray[np.float64]
    anchors: NDArray[np.intp]
    links: NDArray[np.intp]

    @cached_property
    def triples(self) -> PlaneTriples:
        """Triples of neighbours on planes."""
        found = plane_triples(self.object_type.features)
        return found.take(unique_sets(found.features, permutations(self.points, self.object_type.symmetries)))

    @cached_property
    def turns(self) -> NDArray[np.float64]:
        """(F, 3) x axes of the features' frames, object frame: what a datum's angle is on the screen."""
        return np.array([feature.rotation[:, 0] for feature in self.object_type.features]).reshape(-1, 3)

    @cached_property
    def neighbourhoods(self) -> NDArray[np.bool_]:
        """(1 + C, F) all features, and what each of some view cells shows, evenly over the sphere."""
        step = max(1, len(self.cells.visible) // CELLS_TRIED)
        return np.concatenate([np.ones((1, len(self.weights)), bool), self.cells.visible[::step]])

    @cached_property
    def in_line(self) -> tuple[NDArray[np.intp], NDArray[np.float64], tuple[str, ...]] | None:
        """Where each feature has one appearance type: (1 + C, F) the how many-th of its type it is in each neighbourhood, the heaviest the first.

        Then (1 + C,) what each neighbourhood weighs, and (F,) the types' names; None where a feature looks like several
        types, or none.
        """
        looks = [sorted({a.type for a in feature.appearances}) for feature in self.object_type.features]
        if any(len(names) != 1 for names in looks):
            return None
        flat = tuple(name for names in looks for name in names)
        codes = np.unique(np.array(flat), return_inverse=True)[1]
        place = np.argsort(np.argsort(-self.weights, kind="stable"), kind="stable")
        heavier = ((codes[:, None] == codes) & (place <= place[:, None])).astype(np.float32)
        return (
            (self.neighbourhoods.astype(np.float32) @ heavier.T).astype(np.intp),
            self.neighbourhoods @ self.weights,
            flat,
        )

    def allowed(self, data: Data) -> NDArray[np.bool_]:
        """(F, A) the data of a type that the feature has in any of its lobes."""
        names, which = data.by_look
        return self._looking(names)[:, which]

    def _looking(self, names: tuple[str, ...]) -> NDArray[np.bool_]:
        """(F, N) which features look like what is so named."""
        nobody = np.zeros(len(self.points), bool)
        return (
            np.array([self._features_by_look.get(name, nobody) for name in names], bool)
            .reshape(len(names), len(nobody))
            .T
        )

    @cached_property
    def _features_by_look(self) -> dict[str, NDArray[np.bool_]]:
        types = [frozenset(a.type for a in feature.appearances) for feature in self.object_type.features]
        names = sorted(frozenset().union(*types))
        return dict(zip(names, compatible(types, names).T, strict=True))


def type_index(object_type: ObjectType, dv: Mapping[str, float], cells: ViewCells | None = None) -> TypeIndex:
    """Build the index of one type; dv 0 throughout (one feature type in all of Σo) counts every feature alike. ``cells``, where they are known."""
    features = object_type.features
    weights = np.array([dv[feature.type] for feature in features])
    if not weights.any():
        weights = np.ones(len(features))
    points = np.array([feature.at for feature in features]).reshape(-1, 3)
    links = feature_links(points, [feature.arms for feature in features])
    moves = permutations(points, object_type.symmetries)
    return TypeIndex(
        object_type,
        cells or view_cells(object_type),
        points,
        weights,
        _anchors(weights),
        links[unique_sets(links, moves)],
    )


def _anchors(weights: NDArray[np.float64]) -> NDArray[np.intp]:
    """The features at least half as distinctive as the best, or the ``ANCHORS`` most distinctive where those are fewer than four."""
    order = np.argsort(-weights, kind="stable")[:ANCHORS]
    top = order[weights[order] >= 0.5 * weights.max()]
    return np.sort(top if len(top) >= 4 else order)
