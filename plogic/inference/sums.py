"""Some variables summed out of a graph (Dechter's bucket elimination): what is left weighs the others as before."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.errors import WidthError
from plogic.inference.axes import log_sum, product
from plogic.inference.graph import Factor, FactorGraph
from plogic.inference.order import min_fill, neighbours

if TYPE_CHECKING:
    from collections.abc import Sequence


def eliminated(graph: FactorGraph, variables: Sequence[int], width: float) -> FactorGraph:
    """See ``plogic.inference.marginals.summed_out``."""
    cards = graph.cards
    sequence, _ = min_fill(neighbours(len(cards), [f.scope for f in graph.factors]), cards, variables)
    live: dict[int, Factor] = dict(enumerate(graph.factors))
    touching: dict[int, set[int]] = {v: set() for v in sequence}
    for number, factor in live.items():
        for v in touching.keys() & set(factor.scope):
            touching[v].add(number)
    constants = [graph.constant]
    for fresh, v in enumerate(sequence, len(live)):
        gone = [live.pop(number) for number in sorted(touching[v])]
        if not gone:
            constants.append(math.log(cards[v]))
            continue
        constant, told = _sum(gone, v, cards, width)
        constants.append(constant)
        done = touching.pop(v)
        for u in touching.keys() & {u for factor in gone for u in factor.scope}:
            touching[u] -= done
            touching[u].update([fresh] * (u in told.scope))
        if told.scope:
            live[fresh] = told
    left = set(variables)
    return FactorGraph(
        tuple(1 if v in left else card for v, card in enumerate(cards)), tuple(live.values()), math.fsum(constants)
    )


def _sum(factors: Sequence[Factor], v: int, cards: Sequence[int], width: float) -> tuple[float, Factor]:
    """(log scale, the factor over v's neighbours) of the product of the factors summed over v; v's axis goes last."""
    scope = sorted({u for factor in factors for u in factor.scope} - {v})
    size = sum(math.log2(cards[u]) for u in (*scope, v))
    if size > width:
        raise WidthError(
            f"summing out variable {v} needs a table of {size:.1f} bits; the limit is {width:g}: raise it, or keep the variable"
        )
    top, told = log_sum(product([(factor.scope, factor.table) for factor in factors], (*scope, v), cards))
    return top, Factor(tuple(scope), told) if top > -math.inf else Factor((), np.zeros(()))
