"""Attention: in what order the types are tried (§5.3, §7).

rank saturates in clutter, so ties go by the excess over chance, then by the rank within one lobe-consistent neighbourhood.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from plogic.measures.valuation import compatible, rank, rank_of_kinds
from plogic.search.learnt.index import LearntIndex

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from kb.cloud import KnowledgeBase
    from plogic.search.indices import Index
    from plogic.search.type_index import TypeIndex

CELLS_TRIED = 24
"""View cells whose rank is taken for the tie-break, evenly over the sphere."""


@dataclass(frozen=True)
class Attention:
    """rank(Type), its excess over what clutter alone would give, and the best rank within one view cell; all in [−1, 1]."""

    type: str
    rank: float
    excess: float
    within_cell: float


def attend(indices: Sequence[Index], types: Sequence[str], kb: KnowledgeBase) -> list[Attention]:
    """All types, the most promising first: by rank, then excess, then rank within one neighbourhood, then name."""
    rows = [_attention(index, types, kb) for index in indices]
    return sorted(
        rows, key=lambda row: (-round(row.rank, 9), -round(row.excess, 9), -round(row.within_cell, 9), row.type)
    )


def chance_types(kb: KnowledgeBase, number: int) -> list[str]:
    """What ``number`` appearances of clutter alone would be: each type in proportion to its clutter rate, rounded down."""
    rates = {name: kb.rates.clutter.get(name, 1.0) for name in kb.appearance_types}
    total = sum(rates.values()) or 1.0
    return [name for name, rate in rates.items() for _ in range(int(number * rate / total))]


def _attention(index: Index, types: Sequence[str], kb: KnowledgeBase) -> Attention:
    if isinstance(index, LearntIndex):
        return _of_words(index, types, kb)
    features = [frozenset(a.type for a in feature.appearances) for feature in index.object_type.features]
    here = rank(index.weights, compatible(features, types))
    by_chance = rank(index.weights, compatible(features, chance_types(kb, len(types))))
    return Attention(index.object_type.name, here, here - by_chance, _within_cell(index, compatible(features, types)))


def _of_words(index: Index, types: Sequence[str], kb: KnowledgeBase) -> Attention:
    """The same of a learnt type, by the dominant words of its features: one type a feature, so that counting finds the best θ."""
    words = [feature.type for feature in index.object_type.features]
    here, by_chance = (rank_of_kinds(index.weights, words, some) for some in (types, chance_types(kb, len(types))))
    return Attention(index.object_type.name, here, here - by_chance, here)


def _within_cell(index: TypeIndex, allowed: NDArray[np.bool_]) -> float:
    """The greatest rank over view cells, counting only the features that one cell shows together."""
    step = max(1, len(index.cells.visible) // CELLS_TRIED)
    values = [rank(index.weights[seen], allowed[seen]) for seen in index.cells.visible[::step] if seen.any()]
    return max(values, default=0.0)
