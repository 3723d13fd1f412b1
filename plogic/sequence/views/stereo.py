"""What both cameras of a stereo pair say of a pose (§3.3): the left image, with its depths, decides what is there, both together how it stands."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import inverse
from plogic.match.gamma.data import Data, data_of
from plogic.match.judged.evidence import judged
from plogic.match.judged.rivals import hidden_among
from plogic.sequence.views.standing import Seen, Standing, refined, seen_alone, seen_beside
from plogic.sequence.views.view import View

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.cycle.state import Cycle
    from plogic.facts.hypothesis import Hypothesis
    from plogic.run.perceive import Perceiver
    from sensing.appearance import Gamma
    from sensing.files.stereo import Pair

ROUNDS = 2
"""Times that each pose is refined on what both show, and matched again."""


def sharpened(cycle: Cycle, left: Gamma, data: Data, right: Gamma, pair: Pair, perceiver: Perceiver) -> Cycle:
    """The outcome of a cycle over the left image, what it accepted refined on both: features are matched in the right one where they project.

    ``data``: the left Γ as arrays. What is present, and its rivals, stay.
    """
    kb = perceiver.kb
    near = Seen(View("left", left, np.eye(4)), data)
    aside = Seen(
        View("right", right, inverse(pair.right_from_left)), data_of(right.appearances, right.camera, perceiver.width)
    )
    standing = [Standing(perceiver.models[b.type], b.camera_from_object) for b in cycle.accepted]
    for _ in range(ROUNDS):
        posed = [_posed(standing, seen, perceiver) for seen in (near, aside)]
        standing = [
            refined(some, mine, (near, aside), kb)
            for some, mine in zip(standing, zip(*posed, strict=True), strict=True)
        ]
    final = _posed(standing, near, perceiver)
    return replace(
        cycle,
        accepted=tuple(_judged(b, one, final, data, perceiver) for b, one in zip(cycle.accepted, final, strict=True)),
    )


def _posed(standing: Sequence[Standing], seen: Seen, perceiver: Perceiver) -> list[Hypothesis]:
    """All of them in one image, beside each other."""
    alone = [seen_alone(some, seen, perceiver.kb) for some in standing]
    return seen_beside(standing, alone, len(standing), seen, perceiver.kb)


def _judged(
    belief: Hypothesis, posed: Hypothesis, others: Sequence[Hypothesis], data: Data, perceiver: Perceiver
) -> Hypothesis:
    again = judged(posed, data, perceiver.kb, perceiver.dv, hidden_among(posed, others))
    return again.told(status=belief.status, why=belief.why)
