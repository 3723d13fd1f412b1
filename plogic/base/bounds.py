"""Probabilities that ProbLog can read (§8, trap g).

ProbLog's log semiring turns a written label below 1e-9 into 0 and one above 1 − 1e-9 into 1. So what is possible but
very improbable is lifted to ``LEAST``, in the program text and in the exact worlds alike; what is impossible stays
impossible.
"""

from collections.abc import Sequence

LEAST = 1e-8
SLACK = 1e-10
"""An annotated disjunction whose written probabilities come this near to 1 leaves nothing out (ProbLog's own tolerance
of rounding)."""


def bounded(p: float) -> float:
    """``p`` itself if it is 0, 1 or at least ``LEAST`` away from both; else the nearest such value."""
    return min(max(p, 0.0), 1.0) if p <= 0.0 or p >= 1.0 else min(max(p, LEAST), 1.0 - LEAST)


def alternative(weights: Sequence[float]) -> list[float]:
    """Probabilities of one alternative: the weights over their sum, none of the positive ones below ``LEAST``.

    [] where all are 0.
    """
    total = sum(weights)
    if total <= 0.0:
        return []
    lifted = [s if (s := w / total) >= LEAST else LEAST if w > 0.0 else 0.0 for w in weights]
    whole = sum(lifted)
    return [p / whole for p in lifted]
