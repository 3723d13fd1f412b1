"""Attention: in what order the types are tried (§5.3, §7).

rank saturates in clutter, so ties go by the excess over chance, then by the rank within one lobe-consistent
neighbourhood.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.judged.type_models import TypeModel


@dataclass(frozen=True)
class Attention:
    """rank(Type), its excess over what clutter alone would give, and the best rank within one view cell.

    All in [−1, 1].
    """

    type: str
    rank: float
    excess: float
    within_cell: float


def attend(models: Iterable[TypeModel], types: Sequence[str], kb: KnowledgeBase) -> list[Attention]:
    """All types, the most promising first: by rank, then excess, then rank within one neighbourhood, then name."""
    here, by_chance = Counter(types), Counter(chance_types(kb, len(types)))
    rows = [_attention(model, here, by_chance) for model in models]
    return sorted(
        rows, key=lambda row: (-round(row.rank, 9), -round(row.excess, 9), -round(row.within_cell, 9), row.type)
    )


def chance_types(kb: KnowledgeBase, number: int) -> list[str]:
    """What ``number`` appearances of clutter alone would be: each type in proportion to its clutter rate, rounded down."""
    rates = {name: kb.rates.clutter.get(name, 1.0) for name in kb.appearance_types}
    total = sum(rates.values()) or 1.0
    return [name for name, rate in rates.items() for _ in range(int(number * rate / total))]


def _attention(model: TypeModel, here: Counter[str], by_chance: Counter[str]) -> Attention:
    ranks = model.ranks(here, by_chance)
    return Attention(model.object_type.name, ranks.rank, ranks.rank - ranks.by_chance, ranks.within_cell)
