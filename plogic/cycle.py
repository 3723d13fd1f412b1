"""The perceptual cycle (§7): rank, match, pose, expect, judge; accept, or reject and release; until Γ has a coherent explanation."""

from __future__ import annotations

from dataclasses import replace
from time import monotonic
from typing import TYPE_CHECKING

import cv2
import numpy as np

from plogic.belief import Belief, Cycle, same_hypothesis
from plogic.evidence import evidence
from plogic.expectation import hidden_by
from plogic.measures.explanatory import explanatory_value
from plogic.rivals import SHARED_CLAIMS, apart_on_screen, claims, overlap, shared_claims
from plogic.search.indices import generate, generate_together, settle, significant
from plogic.search.learnt.index import LearntIndex
from plogic.search.projection import project_ideal
from plogic.trace import Trace

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from kb.cloud import KnowledgeBase
    from plogic.attention import Attention
    from plogic.expectation import Posed
    from plogic.search.data import Data
    from plogic.search.indices import Index
    from plogic.search.oriented.pair_index import PairIndex

FEWEST = 4
"""Expected features that must be detected before a hypothesis counts: a phantom wholly out of sight has ev = +1 (§8, trap b)."""
POOL = 10
"""Poses that are carried from one round to the next, the best."""
POOL_OF_TYPE = 3
"""... and so many for each type of the knowledge base, where these are more."""
POLISHED = 6
"""Poses of a round that are refined beside Δi before they are accepted or not, the best first."""
POLISH = 10.0
"""What refinement beside Δi may add to the evidence of a learnt type, which was refined when it was found: one that lacks more is not refined."""
MOST_RIVALS = 2
"""Rivals of an accepted hypothesis that enter Δh with it."""


class Perception:
    """One run of the cycle over one Γ: the state that its steps share."""

    def __init__(
        self,
        data: Data,
        kb: KnowledgeBase,
        indices: Mapping[str, Index],
        dv: Mapping[str, float],
        end: float | None = None,
        shared: PairIndex | None = None,
    ) -> None:
        self.data, self.kb, self.indices, self.dv = data, kb, indices, dv
        self.end, self.unfinished = end, False
        self.shared = shared
        self.trace = Trace()
        self.accepted: list[Belief] = []
        self.rivals: list[Belief] = []
        self.rejected: list[Belief] = []
        self.searched: dict[str, int] = {}
        self.known: dict[int, tuple[Belief | None, int]] = {}
        self.reach = data.camera.f, 2.0 * kb.rates.match_tolerance

    def run(self, attention: Sequence[Attention]) -> Cycle:
        """Search the free data, judge all poses beside Δi, accept the best, and again, until nothing is acceptable.

        Then Δi is made stable. Every round but the last claims data, so that the cycle ends on every finite Γ.
        """
        for row in attention:
            self.trace.add("rank", f"rank {row.rank:.2f}, {row.excess:+.2f} against chance", of_type=row.type)
        pool: list[Posed] = []
        while not self.late() and self._round(attention, pool):
            pass
        for belief in self._judged(pool):
            self._set_aside(belief, self._refusal(belief) or "the deadline came first")
        self._stabilise()
        self.trace.add("stable", f"{len(self.accepted)} accepted; {int(self.free().sum())} appearances left as noise")
        return Cycle(
            tuple(self.accepted), tuple(self._considered()), tuple(self.rejected), tuple(attention), self.trace
        )

    def late(self) -> bool:
        """Whether the deadline is past."""
        self.unfinished = self.unfinished or (self.end is not None and monotonic() >= self.end)
        return self.unfinished

    def free(self, without: Belief | None = None) -> NDArray[np.bool_]:
        """(A,) the data that no accepted hypothesis claims, ``without`` aside."""
        mask = np.ones(len(self.data.ids), dtype=bool)
        for belief in self.accepted:
            if belief is not without:
                mask[list(claims(belief.posed))] = False
        return mask

    def _round(self, attention: Sequence[Attention], pool: list[Posed]) -> bool:
        """Add to the pool what the free data give, then accept its best acceptable pose. True where something was accepted."""
        left, covered = self.data.only(self.free()), self._covered()
        together = {} if self.shared is None else generate_together(self.shared, left, self.kb, covered)
        for row in attention:
            if self.late():
                break
            if row.type in together:
                pool += [posed for _, posed in together[row.type]]
            elif not self._exhausted(row.type):
                pool += [posed for _, posed in generate(self.indices[row.type], left, self.kb, covered)]
                self.searched[row.type] = sum(_name(b) == row.type for b in self.accepted)
        judged = sorted(self._judged(pool), key=lambda b: -b.worth)
        pool[:] = [b.posed for b in judged[: max(POOL, POOL_OF_TYPE * len(self.indices))]]
        for belief in judged[:POLISHED]:
            if isinstance(belief.index, LearntIndex) and belief.surplus < significant(belief.index) - POLISH:
                continue
            better = self._judge(belief.posed, self.free(), rounds=2)
            if self._refusal(better) is None:
                self._accept(better)
                pool[:] = [posed for posed in pool if not self._is_accepted(posed)]
                return True
        return False

    def _exhausted(self, name: str) -> bool:
        """Whether another search would find nothing new: of a learnt type all poses are in the pool, unless one of it was accepted since."""
        return isinstance(self.indices[name], LearntIndex) and self.searched.get(name) == sum(_name(b) == name for b in self.accepted)

    def _covered(self) -> NDArray[np.bool_]:
        """(H, W) where accepted opaque objects stand in the ideal image."""
        camera = self.data.camera
        mask = np.zeros((camera.height, camera.width), dtype=np.uint8)
        for belief in self.accepted:
            surface = belief.posed.object_type.surface
            if surface is not None and belief.posed.object_type.opaque:
                corners = project_ideal(belief.posed.camera_from_object[None], surface.vertices, self.data)[0]
                for triangle in np.rint(corners[surface.triangles]).astype(np.int32):
                    cv2.fillConvexPoly(mask, triangle, 1)
        return mask.astype(bool)

    def _judged(self, pool: Sequence[Posed]) -> list[Belief]:
        """Each pose beside what is accepted: matched on free data, hidden features not expected; as before where nothing near was accepted."""
        free, judged = self.free(), []
        for posed in pool:
            known, accepted = self.known.get(id(posed), (None, 0))
            stale = known is None or any(not apart_on_screen(posed, b.posed, *self.reach) for b in self.accepted[accepted:])
            judged.append(self._judge(posed, free, rounds=0) if known is None or stale else known)
        self.known = {id(belief.posed): (belief, len(self.accepted)) for belief in judged}
        return judged

    def _is_accepted(self, posed: Posed) -> bool:
        return any(same_hypothesis(posed, belief.posed) for belief in self.accepted)

    def _judge(self, posed: Posed, free: NDArray[np.bool_], rounds: int, skip: Belief | None = None) -> Belief:
        """A hypothesis beside Δi, matched on ``free`` data; or, by that many ``rounds``, refined, if it is matched so already."""
        index = self.indices[posed.object_type.name]
        hidden = self._hidden(posed, skip)
        if rounds or self.accepted or not isinstance(index, LearntIndex):  # else it was matched so when it was found
            start = posed if rounds else posed.camera_from_object
            posed = settle(index, start, self.data, self.kb, free=free, hidden=hidden, rounds=rounds)
        hidden = self._hidden(posed, skip) if rounds else hidden
        ev = explanatory_value(posed.support(), self.dv)
        again = explanatory_value(posed.support(hidden), self.dv)
        found = evidence(posed, self.data, self.kb, hidden)
        return Belief(posed, index, found.ratio, found.surplus, ev, again)

    def _hidden(self, posed: Posed, skip: Belief | None = None) -> NDArray[np.bool_]:
        """(F,) what accepted opaque objects hide; those that A4 excludes beside it are rivals and hide nothing (D7)."""
        mask = np.zeros(len(posed.uv), dtype=bool)
        for belief in self.accepted:
            if belief is not skip and belief.posed.object_type.opaque and not overlap(posed, belief.posed):
                mask |= hidden_by(posed, belief.posed)
        return mask

    def _refusal(self, belief: Belief) -> str | None:
        """Why a hypothesis is not accepted beside Δi, or None."""
        return self._unsupported(belief) or self._excluded(belief.posed)

    def _unsupported(self, belief: Belief) -> str | None:
        """Why its own evidence, beside Δi, does not carry it: what is hidden there is not expected."""
        posed = belief.posed
        found = posed.candidate & posed.detected & ~self._hidden(posed)
        if found.sum() < FEWEST:
            return f"only {int(found.sum())} expected features were detected; {FEWEST} are demanded"
        if self.shared is None and not found[belief.index.anchors].any():  # pairs of any features start a search there
            return "none of its most distinctive features was detected"
        if belief.ev_reconsidered is None or belief.ev_reconsidered <= 0.0:
            return f"ev {_round(belief.ev_reconsidered)} is not above 0"
        surplus = belief.surplus + self._harm(posed)
        if surplus <= significant(belief.index):
            return f"log-likelihood ratio {surplus:.1f} beyond what any pose has; {significant(belief.index):.1f} is demanded"
        return None

    def _excluded(self, posed: Posed) -> str | None:
        """Which constraint keeps it out of Δi."""
        for other in self.accepted:
            if overlap(posed, other.posed):
                return "shares volume with an accepted object (A4)"
            if shared_claims(posed, other.posed)[1] > SHARED_CLAIMS:
                return "explains the same appearances as an accepted object"
        return None

    def _harm(self, posed: Posed) -> float:
        """What the accepted ones would lose if this stood before them: at most 0, for to hide a detected feature is counter-evidence."""
        if not posed.object_type.opaque:
            return 0.0
        change = 0.0
        for other in self.accepted:
            before = self._hidden(other.posed, other)
            after = before | hidden_by(other.posed, posed)
            if (after != before).any() and not overlap(posed, other.posed):
                change += (
                    evidence(other.posed, self.data, self.kb, after).ratio
                    - evidence(other.posed, self.data, self.kb, before).ratio
                )
        return min(0.0, change)

    def _accept(self, belief: Belief) -> None:
        self.accepted.append(replace(belief, status="accepted", why="explains its data better than chance, ev above 0"))
        self.trace.add(
            "accept", f"log-likelihood ratio {belief.worth:.1f}", of_type=_name(belief), ev=belief.ev_reconsidered
        )

    def _set_aside(self, belief: Belief, reason: str) -> None:
        """Keep as a rival what would be acceptable alone; reject the rest, which releases its data."""
        alone = self._alone(belief)
        if alone is not None:
            self.rivals.append(replace(alone, status="rival", why=reason))
        else:
            self.rejected.append(replace(belief, status="rejected", why=reason))
            self.trace.add("reject", reason, of_type=_name(belief), ev=belief.ev_reconsidered)

    def _alone(self, belief: Belief) -> Belief | None:
        """The hypothesis with the data of those that it would replace; None where it explains them worse by far."""
        replaced = [
            b
            for b in self.accepted
            if overlap(belief.posed, b.posed) or shared_claims(belief.posed, b.posed)[1] > SHARED_CLAIMS
        ]
        if not replaced:
            return None
        free = np.ones(len(self.data.ids), dtype=bool)
        for other in self.accepted:
            if not any(other is b for b in replaced):
                free[list(claims(other.posed))] = False
        posed = settle(belief.index, belief.posed.camera_from_object, self.data, self.kb, free=free, rounds=1)
        if self._is_accepted(posed):
            return None
        ev, found = explanatory_value(posed.support(), self.dv), evidence(posed, self.data, self.kb)
        enough = int((posed.candidate & posed.detected).sum()) >= FEWEST
        near = found.ratio > sum(b.worth for b in replaced) - significant(belief.index)
        return (
            Belief(posed, belief.index, found.ratio, found.surplus, ev, ev)
            if enough and ev is not None and near
            else None
        )

    def _stabilise(self) -> None:
        """Take every ev anew beside the others (reconsideration); drop what no longer holds, until Δi is stable. It only shrinks."""
        while True:
            self.accepted = [self._again(b) for b in self.accepted]
            bad = [b for b in self.accepted if b.ev_reconsidered is None or b.ev_reconsidered <= 0.0 or b.worth <= 0.0]
            if not bad:
                return
            worst = min(bad, key=lambda b: (b.ev_reconsidered is not None, b.ev_reconsidered or -1.0))
            self.accepted = [b for b in self.accepted if b is not worst]
            self.rejected.append(replace(worst, status="rejected", why="ev or evidence is not above 0 beside the others"))
            self.trace.add("release", "ev or evidence is not above 0 beside the others; its data are released", of_type=_name(worst))

    def _again(self, belief: Belief) -> Belief:
        """Ev of an accepted hypothesis with everything else that is accepted."""
        new = self._judge(belief.posed, self.free(belief), rounds=0, skip=belief)
        self.trace.add(
            "reconsider",
            f"ev {_round(new.ev)} alone, {_round(new.ev_reconsidered)} beside the others",
            of_type=_name(belief),
            ev=new.ev_reconsidered,
        )
        return replace(new, status="accepted", why=belief.why)

    def _considered(self) -> list[Belief]:
        """At most ``MOST_RIVALS`` rivals an accepted hypothesis, near-duplicates merged, best first."""
        kept: list[Belief] = []
        for rival in sorted(self.rivals, key=lambda b: -b.worth):
            twin = any(same_hypothesis(rival.posed, b.posed) for b in kept + self.accepted)
            if not twin and len(kept) < MOST_RIVALS * len(self.accepted):
                kept.append(rival)
        return kept


def _name(belief: Belief) -> str:
    return str(belief.posed.object_type.name)


def _round(value: float | None) -> float | None:
    return None if value is None else round(value, 3)
