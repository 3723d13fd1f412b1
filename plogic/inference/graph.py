"""A discrete factor graph: variables with a few states each, and factors that weigh their joint states.

Vocabulary, each with an example value:

* a *variable* is a number, 0, 1, 2, ...; ``cards[v]`` is how many states it has
* ``Factor((0, 2), table)``, log weights of the joint states of variables 0 and 2, shape ``(cards[0], cards[2])``; −inf
  is impossible
* ``FactorGraph((2, 3, 2), (Factor(...), ...))``; the weight of a joint state is the product of its factors' weights
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Factor:
    """``scope``: variables, strictly increasing; ``table``: natural logarithms, one axis a variable of the scope, no NaN, no +inf."""

    scope: tuple[int, ...]
    table: NDArray[np.float64]


@dataclass(frozen=True)
class FactorGraph:
    """The whole; ``constant`` is a log weight that every joint state has."""

    cards: tuple[int, ...]
    factors: tuple[Factor, ...]
    constant: float = 0.0

    def log_weight(self, states: Sequence[int]) -> float:
        """The log weight of one joint state, one state a variable."""
        return self.constant + sum(float(f.table[tuple(states[v] for v in f.scope)]) for f in self.factors)
