"""Attention: in what order the types are tried (§5.3, §7).

rank saturates in clutter, so ties go by the excess over chance, then by the rank within one lobe-consistent
neighbourhood.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.learned.learned_index import LearnedIndex
from plogic.measures.valuation import compatible, rank, rank_of_kinds

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.hand.type_index import TypeIndex
    from plogic.match.indices import Index


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
    if isinstance(index, LearnedIndex):
        ranks = [rank_of_kinds(weights, index.kinds, some) for some in (here, by_chance)]
        return Attention(kind.name, ranks[0], ranks[0] - ranks[1], ranks[0])
    if index.in_line is not None:
        counted, chance = _counted(index, here), _counted(index, by_chance, neighbourhoods=1)
        return Attention(
            kind.name, float(counted[0]), float(counted[0] - chance[0]), float(counted[1:].max(initial=0.0))
        )
    looks = [frozenset(a.type for a in feature.appearances) for feature in kind.features]
    allowed, usual = (compatible(looks, list(some.elements())) for some in (here, by_chance))
    ranks = [rank(weights, allowed), rank(weights, usual)]
    within = max((rank(weights[seen], allowed[seen]) for seen in index.neighbourhoods[1:] if seen.any()), default=0.0)
    return Attention(kind.name, ranks[0], ranks[0] - ranks[1], within)


def _counted(index: TypeIndex, there: Counter[str], neighbourhoods: int | None = None) -> NDArray[np.float64]:
    """The rank within each of the first ``neighbourhoods`` where each feature has one appearance type: of a type the heaviest that are there."""
    assert index.in_line is not None  # noqa: S101 - the caller looks
    number, whole, names = index.in_line
    number, whole, shown = number[:neighbourhoods], whole[:neighbourhoods], index.neighbourhoods[:neighbourhoods]
    matched = shown & (number <= np.array([there.get(name, 0) for name in names]))
    return np.asarray(np.minimum(1.0, matched @ index.weights / np.where(whole > 0.0, whole, 1.0)))
