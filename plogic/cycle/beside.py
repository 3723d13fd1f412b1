"""How a hypothesis is judged beside Δi, what was accepted so far: on the data left free, with hidden features not expected (§5.5, §7)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.clock import Deadline
from plogic.cycle.belief import same_hypothesis
from plogic.match.judged.evidence import evidence, judged
from plogic.match.judged.expectation import hidden_by
from plogic.match.judged.rivals import SHARED_CLAIMS, claims, hidden_among, overlap, shared_claims
from plogic.match.judged.type_models import Request

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.judged.type_models import Search
    from plogic.match.kinds import Models

FEWEST = 4
"""Expected features that must be detected before a hypothesis counts: a phantom wholly out of sight has ev = +1 (§8,
trap b)."""


@dataclass(eq=False)
class Beside:
    """Δi over one Γ, and what can be said of a hypothesis beside it.

    ``end``: a moment of ``time.monotonic`` at which a search stops, None for never; ``processes``: how many search,
    this one and copies of it.
    """

    data: Data
    kb: KnowledgeBase
    models: Models
    dv: Mapping[str, float]
    end: float | None = None
    processes: int = 1

    def __post_init__(self) -> None:
        self.deadline = Deadline(self.end)
        self.request = Request(self.data, self.kb, self.deadline.check, self.processes)
        self.searches = [(kind.models, kind.search(self.request)) for kind in self.models.kinds.values()]
        self.accepted: list[Hypothesis] = []
        self.refused: list[Hypothesis] = []

    def free(self, without: Hypothesis | None = None) -> NDArray[np.bool_]:
        """(A,) the data that no accepted hypothesis claims, ``without`` aside."""
        mask = np.ones(len(self.data.ids), dtype=bool)
        for belief in self.accepted:
            if belief is not without:
                mask[list(claims(belief))] = False
        return mask

    def _search_for(self, posed: Hypothesis) -> Search | None:
        """The search for its type, while there is one."""
        return next((search for models, search in self.searches if posed.object_type.name in models), None)

    def _is_accepted(self, posed: Hypothesis) -> bool:
        return any(same_hypothesis(posed, belief) for belief in self.accepted)

    def _judge(
        self, posed: Hypothesis, free: NDArray[np.bool_], rounds: int, skip: Hypothesis | None = None
    ) -> Hypothesis:
        """A hypothesis beside Δi, matched on ``free`` data; or, by that many ``rounds``, refined, if it is matched so already."""
        index = self.models[posed.object_type.name]
        hidden = self._hidden(posed, skip)
        if rounds or self.accepted or not index.settled_when_found:  # else it was matched so when it was found
            start = posed if rounds else posed.camera_from_object
            posed = index.settle(start, self.data, self.kb, free=free, hidden=hidden, rounds=rounds)
        return self._believed(posed, self._hidden(posed, skip) if rounds else hidden)

    def _believed(self, posed: Hypothesis, hidden: NDArray[np.bool_]) -> Hypothesis:
        """What Γ says of a hypothesis of which the ``hidden`` features (F,) are not expected."""
        return judged(posed, self.data, self.kb, self.dv, hidden)

    def _hidden(self, posed: Hypothesis, skip: Hypothesis | None = None) -> NDArray[np.bool_]:
        """(F,) what accepted opaque objects hide; those that A4 excludes beside it are rivals and hide nothing (D7)."""
        return hidden_among(posed, [other for other in self.accepted if other is not skip])

    def _refusal(self, belief: Hypothesis) -> str | None:
        """Why a hypothesis is not accepted beside Δi, or None."""
        return self._unsupported(belief) or self._excluded(belief)

    def _unsupported(self, belief: Hypothesis) -> str | None:
        """Why its own evidence, beside Δi, does not carry it: what is hidden there is not expected."""
        posed = belief
        found = posed.candidate & posed.detected & ~self._hidden(posed)
        if found.sum() < FEWEST:
            number = int(found.sum())
            return f"{f'only {number}' if number else 'none'} of its expected features detected; {FEWEST} are demanded"
        if (
            posed.axes is None and not found[self.models[belief.type].anchors].any()
        ):  # where angles count, any features start it
            return "none of its most distinctive features was detected"
        if belief.ev_reconsidered is None or belief.ev_reconsidered <= 0.0:
            return f"ev {rounded(belief.ev_reconsidered)} is not above 0"
        surplus = belief.surplus + self._harm(posed)
        demanded = self.models[belief.type].significance(posed)
        if surplus <= demanded:
            return f"log-likelihood ratio {surplus:.1f} beyond what any pose has; {demanded:.1f} is demanded"
        return None

    def _excluded(self, posed: Hypothesis) -> str | None:
        """Which constraint keeps it out of Δi."""
        if any(same_hypothesis(posed, refused) for refused in self.refused):
            return "was accepted before, and did not hold beside the others"
        for other in self.accepted:
            if overlap(posed, other):
                return "shares volume with an accepted object (A4)"
            if shared_claims(posed, other)[1] > SHARED_CLAIMS:
                return "explains the same appearances as an accepted object"
        return None

    def _harm(self, posed: Hypothesis) -> float:
        """What the accepted ones would lose if this stood before them: at most 0, for to hide a detected feature is counter-evidence."""
        if not posed.object_type.opaque:
            return 0.0
        change = 0.0
        for other in self.accepted:
            before = self._hidden(other, other)
            after = before | hidden_by(other, posed)
            if (after != before).any() and not overlap(posed, other):
                change += (
                    evidence(other, self.data, self.kb, after).ratio - evidence(other, self.data, self.kb, before).ratio
                )
        return min(0.0, change)


def name_of(belief: Hypothesis) -> str:
    """Of its type."""
    return belief.type


def rounded(value: float | None) -> float | None:
    """An ev as the trace tells it."""
    return None if value is None else round(value, 3)
