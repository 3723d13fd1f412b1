"""What a goal comes to in each world, as ``plogic query`` would say there: P(answer | w)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.base.errors import ProgramError, SituationError
from plogic.logic.safety.atoms import quoted
from plogic.scene.asking.live import LiveScene
from plogic.scene.asking.query import answers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geometry.arrays import Floats
    from plogic.facts.situation import Situation
    from plogic.logic.served.engine import Answer

DIGITS = 9
"""To which two worlds give a goal the same probability."""


def answers_in(situation: Situation, worlds: Sequence[Sequence[str]], goal: str) -> Floats:
    """(W, A) P(answer | w), each row summing to 1, of worlds that are told by who is present.

    Of a ground goal the answers are true and false. Of one with variables, which substitutions hold: worlds of which
    all have the same probabilities give the same answer. Raises ProgramError for what is no goal.
    """
    try:
        rows = _by_graph(situation, worlds, goal)
    except (ProgramError, SituationError):  # only the program text can say it, or what is wrong with it
        rows = [_rounded(answers(situation, goal, given=_told(situation, present))) for present in worlds]
    if all(len(row) == 1 for row in rows) and len({tuple(row) for row in rows}) == 1:
        true = np.array([next(iter(row.values())) for row in rows], dtype=float)
        return np.stack([true, 1.0 - true], axis=1)
    kinds = {key: i for i, key in enumerate(dict.fromkeys(tuple(sorted(row.items())) for row in rows))}
    return np.eye(len(kinds))[[kinds[tuple(sorted(row.items()))] for row in rows]]


def _by_graph(situation: Situation, worlds: Sequence[Sequence[str]], goal: str) -> list[dict[str, float]]:
    """The goal's answers in each world, from the factor graph: what the goal and each hypothesis' presence mean is worked out once."""
    scene, rows = LiveScene(situation), []
    for present in worlds:
        scene.given = tuple(_told(situation, present))
        rows.append(_rounded(scene.answers(goal)))
    return rows


def _told(situation: Situation, present: Sequence[str]) -> list[str]:
    """A world as evidence."""
    there = set(present)
    return [
        f"present({quoted(h.id)})" if h.id in there else f"\\+ present({quoted(h.id)})" for h in situation.hypotheses
    ]


def _rounded(found: Sequence[Answer]) -> dict[str, float]:
    return {a.goal: round(a.probability, DIGITS) for a in found}
