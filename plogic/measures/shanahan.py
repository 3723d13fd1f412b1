"""Shanahan's explanatory value, for comparison (§5.7)."""

from __future__ import annotations

from math import exp, log
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


def shanahan_values(rivals: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """P(Qk) / Σj P(Qj) of each rival explanation Δk of the same Γ, Qk = Δk and no other.

    ``rivals`` gives each explanation the priors of its abducibles, all in (0, 1]; P(Qk) is their product. The values
    sum to 1 over the
    rivals (ev does not), adding a rival lowers the others, and listing every abducible k times multiplies log-odds by
    k. No rivals, no
    values. Products are taken in logarithms: thousands of abducibles do not underflow. Raises ValueError for a prior
        outside (0, 1].
    """
    if any(not 0.0 < prior <= 1.0 for priors in rivals.values() for prior in priors):
        raise ValueError("a prior lies outside (0, 1]")
    logs = {name: sum(log(prior) for prior in priors) for name, priors in rivals.items()}
    top = max(logs.values(), default=0.0)
    weights = {name: exp(value - top) for name, value in logs.items()}
    total = sum(weights.values())
    return {name: weight / total for name, weight in weights.items()}
