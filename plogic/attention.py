"""Attention: in what order the types are tried (§5.3, §7).

rank saturates in clutter, so ties go by the excess over chance, then by the rank within one lobe-consistent neighbourhood.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.measures.valuation import compatible, rank, rank_of_kinds
from plogic.search.learnt.index import LearntIndex

if TYPE_CHECKING:
    from collections.abc import Sequence

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
    here, by_chance = Counter(types), Counter(chance_types(kb, len(types)))
    rows = [_attention(index, here, by_chance) for index in indices]
    return sorted(
        rows, key=lambda row: (-round(row.rank, 9), -round(row.excess, 9), -round(row.within_cell, 9), row.type)
    )


def chance_types(kb: KnowledgeBase, number: int) -> list[str]:
    """What ``number`` appearances of clutter alone would be: each type in proportion to its clutter rate, rounded down."""
    rates = {name: kb.rates.clutter.get(name, 1.0) for name in kb.appearance_types}
    total = sum(rates.values()) or 1.0
    return [name for name, rate in rates.items() for _ in range(int(number * rate / total))]


def _attention(index: Index, here: Counter[str], by_chance: Counter[str]) -> Attention:
    """Of a type whose features have one appearance type each, as words are, counting finds the best θ; of others it is a matching."""
    kind, weights = index.object_type, index.weights
    if isinstance(index, LearntIndex):
        ranks = [rank_of_kinds(weights, [feature.type for feature in kind.features], some) for some in (here, by_chance)]
        return Attention(kind.name, ranks[0], ranks[0] - ranks[1], ranks[0])
    step = max(1, len(index.cells.visible) // CELLS_TRIED)
    shown = index.cells.visible[::step]
    if index.heavier is not None:
        everything = np.ones((1, len(weights)), bool)
        ranks = [float(_counted(index, everything, some)[0]) for some in (here, by_chance)]
        return Attention(kind.name, ranks[0], ranks[0] - ranks[1], float(_counted(index, shown, here).max(initial=0.0)))
    looks = [frozenset(a.type for a in feature.appearances) for feature in kind.features]
    allowed, usual = (compatible(looks, list(some.elements())) for some in (here, by_chance))
    ranks = [rank(weights, allowed), rank(weights, usual)]
    within = max((rank(weights[seen], allowed[seen]) for seen in shown if seen.any()), default=0.0)
    return Attention(kind.name, ranks[0], ranks[0] - ranks[1], within)


def _counted(index: TypeIndex, shown: NDArray[np.bool_], there: Counter[str]) -> NDArray[np.float64]:
    """(C,) the rank of the features that are shown (C, F) where each has one appearance type: of each type the heaviest, as many as there are."""
    assert index.heavier is not None  # noqa: S101 - the caller looks
    same, names = index.heavier
    some = shown.astype(np.float32)
    matched = shown & (some @ same.T <= np.array([there.get(name, 0) for name in names]))
    whole = shown @ index.weights
    return np.asarray(np.minimum(1.0, matched @ index.weights / np.where(whole > 0.0, whole, 1.0)))
