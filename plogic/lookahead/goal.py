"""What a goal comes to in each world, as ``plogic query`` would say there: P(answer | w)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.query import answers
from plogic.talk.tokens import quoted

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.situation import Situation

DIGITS = 9
"""To which two worlds give a goal the same probability."""


def answers_in(situation: Situation, worlds: Sequence[Sequence[str]], goal: str) -> NDArray[np.float64]:
    """(W, A) P(answer | w), each row summing to 1, of worlds that are told by who is present.

    Of a ground goal the answers are true and false. Of one with variables, which substitutions hold: worlds of which all have the same
    probabilities give the same answer. Raises ProgramError for what is no goal.
    """
    rows = [_in(situation, present, goal) for present in worlds]
    if all(len(row) == 1 for row in rows) and len({tuple(row) for row in rows}) == 1:
        true = np.array([next(iter(row.values())) for row in rows], dtype=float)
        return np.stack([true, 1.0 - true], axis=1)
    kinds = {key: i for i, key in enumerate(dict.fromkeys(tuple(sorted(row.items())) for row in rows))}
    return np.eye(len(kinds))[[kinds[tuple(sorted(row.items()))] for row in rows]]


def _in(situation: Situation, present: Sequence[str], goal: str) -> dict[str, float]:
    """The goal's answers in one world, with their probabilities."""
    there = set(present)
    given = [f"present({quoted(h.id)})" if h.id in there else f"\\+ present({quoted(h.id)})" for h in situation.hypotheses]
    return {a.goal: round(a.probability, DIGITS) for a in answers(situation, goal, given=given)}
