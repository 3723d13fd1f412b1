"""The perceptual cycle (§7): rank, match, pose, expect, judge; accept, or reject and release; until Γ has a coherent explanation."""

from __future__ import annotations

from contextlib import ExitStack, closing, suppress
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.clock import OutOfTimeError
from plogic.cycle.anytime import Anytime
from plogic.cycle.belief import Cycle, considered
from plogic.cycle.beside import FEWEST, name_of
from plogic.cycle.support import supported
from plogic.match.judged.disjoint import moved_apart
from plogic.match.judged.rivals import apart_on_screen, claims, excludes, hidden_among
from plogic.match.judged.type_models import Given

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.cycle.attention import Attention
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data

POOL = 10
"""Poses that are carried from one round to the next, the best."""
POOL_OF_TYPE = 3
"""... and so many for each type of the knowledge base, where these are more."""
POLISHED = 6
"""Poses of a round that are refined beside Δi before they are accepted or not, the best first."""
POLISH = 10.0
"""What refinement beside Δi may add to the evidence of a learned type, which was refined when it was found: one that
lacks more is not refined."""


class Perception(Anytime):
    """One run of the cycle over one Γ: the state that its steps share."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.rivals: list[Hypothesis] = []
        self.standing = 0
        self.known: dict[int, tuple[Hypothesis, int]] = {}

    def run(self, attention: Sequence[Attention]) -> Cycle:
        """Search the free data, judge all poses beside Δi, accept the best, and again, until nothing is acceptable.

        Each time Δi is made stable; the heaviest one of these is the answer, at the end or when the deadline comes.
        Every round but the last claims data, or comes after one in which something was dropped for good, so that the
        cycle ends on every finite Γ.
        """
        for row in attention:
            self.trace.add("rank", f"rank {row.rank:.2f}, {row.excess:+.2f} against chance", of_type=row.type)
        pool: list[Hypothesis] = []
        with suppress(OutOfTimeError):
            while self._round(attention, pool) or self._rested(pool) or self._deepened() or self._released():
                pass
            self._compare(pool)
        self._conclude()
        self._leave(pool)
        self.trace.add("stable", f"{len(self.accepted)} accepted; {int(self.free().sum())} appearances left as noise")
        rivals = map(self._makes_way, considered(self.rivals, self.accepted))
        return Cycle(tuple(self.accepted), tuple(rivals), tuple(self.rejected), tuple(attention), self.trace)

    def _round(self, attention: Sequence[Attention], pool: list[Hypothesis]) -> bool:
        """Accept the best acceptable pose of the pool; where it has none, add to it what the free data give first. True where one was accepted."""
        left = self.data.only(self.free())
        if self._accepts([b for b in self._judged(pool) if self._keeps(b) and self._refusal(b) is None], pool, left):
            return True
        given = self._given()
        with ExitStack() as stack:
            found = {}
            for models, search in self.searches:
                names = [row.type for row in attention if row.type in models]
                proposals = stack.enter_context(closing(search.propose(names, left, given)))
                found.update(dict.fromkeys(names, proposals))
            for row in attention:
                self.deadline.check()
                pool += [posed for _, posed in next(found[row.type])]
        judged = sorted(self._judged(pool), key=lambda b: -b.worth)
        pool[:] = judged[: max(POOL, POOL_OF_TYPE * len(self.models))]
        return self._accepts(judged, pool, left)

    def _accepts(self, judged: Sequence[Hypothesis], pool: list[Hypothesis], left: Data) -> bool:
        """Accept the best of some that is acceptable, refined beside Δi; the pool loses it. True where there is one."""
        for belief in sorted(judged, key=lambda b: -b.worth)[:POLISHED]:
            self.deadline.check()
            if self.models[belief.type].settled_when_found and not self._hopeful(belief):
                continue
            better = self._tilted(self._judge(belief, self.free(), rounds=2), left)
            either = (
                [better] if self.models[belief.type].settled_when_found else [better, belief]
            )  # places alone may fit better and lose a match
            holds = next((b for b in either if self._refusal(b) is None), None)
            if holds is not None:
                self._accept(holds)
                self._keep()
                pool[:] = [posed for posed in pool if not self._is_accepted(posed)]
                return True
        return False

    def _given(self) -> Given:
        """What searches are given besides the free data."""
        return Given(self.accepted, self._hidden, self._glance, lambda why: self.trace.add("deepen", why))

    def _keeps(self, posed: Hypothesis) -> bool:
        """Whether it is accepted, if it can be, before more is searched for."""
        search = self._search_for(posed)
        return search is not None and search.keeps

    def _hopeful(self, belief: Hypothesis) -> bool:
        """Whether refinement may add to its evidence what it lacks."""
        return belief.surplus >= self.models[belief.type].significance(belief) - POLISH

    def _rested(self, pool: list[Hypothesis]) -> bool:
        """Add to the pool what may stand where accepted objects do, where gravity holds and more were accepted since. True where something may."""
        if not self.kb.gravity or self.standing == len(self.accepted):
            return False
        self.standing = len(self.accepted)
        found, why = supported(self.accepted, self.models, self.data.only(self.free()), self._given(), self.request)
        if why is not None:
            self.trace.add("support", why)
        pool += found
        return bool(found)

    def _deepened(self) -> bool:
        """Search further the next time, for the types that can be. True where any can."""
        left = self.data.only(self.free())
        reasons = [search.deepen(left, accepted=bool(self.accepted)) for _, search in self.searches]
        for why in reasons:
            if why is not None:
                self.trace.add("deepen", why)
        return any(why is not None for why in reasons)

    def _released(self) -> bool:
        """Drop from Δi, for good, what does not hold in it when it is stable, so that its data are searched again. True where there was any."""
        if not self._dropped():
            return False
        self.known, self.standing = {}, 0
        return True

    def _judged(self, pool: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Each pose beside what is accepted: matched on free data, hidden features not expected; as before where nothing near was accepted."""
        free, judged = self.free(), []
        for posed in pool:
            self.deadline.check()
            known, accepted = self.known.get(id(posed), (None, 0))
            stale = known is None or any(not apart_on_screen(posed, b, *self.reach) for b in self.accepted[accepted:])
            judged.append(self._judge(posed, free, rounds=0) if known is None or stale else known)
        self.known = {id(belief): (belief, len(self.accepted)) for belief in judged}
        return judged

    def _tilted(self, belief: Hypothesis, left: Data) -> Hypothesis:
        """The best of a hypothesis and of itself at other tilts, where it was searched for with others: in one place it may fit in several ways."""
        search = self._search_for(belief)
        if search is None or not self._hopeful(belief):
            return belief
        poses = search.tilted(belief, left)
        others = [
            self.models[belief.type].settle(pose, self.data, self.kb, free=self.free(), rounds=0) for pose in poses
        ]
        return max([belief, *(self._judge(posed, self.free(), rounds=1) for posed in others)], key=lambda b: b.worth)

    def _compare(self, pool: list[Hypothesis]) -> None:
        """Tell what is left in the pool from rivals of Δi; what is told leaves the pool."""
        judged = self._judged(pool)
        pool[:] = judged
        for belief in judged:
            self.deadline.check()
            self._set_aside(
                belief, self._refusal(belief) or "of less worth than what was refined, and not acceptable then"
            )
            del pool[0]

    def _leave(self, pool: Sequence[Hypothesis]) -> None:
        """Reject what there was no time to tell."""
        for belief in (
            self.known[id(posed)][0] for posed in pool if id(posed) in self.known and not self._is_accepted(posed)
        ):
            self.rejected.append(belief.told(status="rejected", why="the deadline came first"))

    def _set_aside(self, belief: Hypothesis, reason: str) -> None:
        """Keep as a rival what would be acceptable alone; reject the rest, which releases its data."""
        alone = self._alone(belief)
        if alone is not None:
            self.rivals.append(
                alone.told(
                    status="rival",
                    why=f"would be accepted in the place of what it conflicts with; beside that, {reason}",
                )
            )
        else:
            self.rejected.append(belief.told(status="rejected", why=reason))
            self.trace.add("reject", reason, of_type=name_of(belief), ev=belief.ev_reconsidered)

    def _alone(self, belief: Hypothesis) -> Hypothesis | None:
        """The hypothesis beside the other accepted ones, with the data of those that it would replace; None where it explains them worse by far."""
        replaced = [b for b in self.accepted if excludes(belief, b)]
        if not replaced:
            return None
        others = [b for b in self.accepted if not any(b is other for other in replaced)]
        found = self._among(belief, belief.camera_from_object, others, rounds=1)
        if self._is_accepted(found):
            return None
        posed, hidden = found, hidden_among(found, others)
        enough = int((posed.candidate & posed.detected & ~hidden).sum()) >= FEWEST
        near = found.worth > sum(b.worth for b in replaced) - self.models[belief.type].significance(belief)
        return found if enough and found.ev_reconsidered is not None and near else None

    def _makes_way(self, rival: Hypothesis) -> Hypothesis:
        """A rival, moved out of the accepted that it leaves where they are (A4), if it can be and there is time."""
        if self.unfinished:
            return rival
        others = [b for b in self.accepted if not excludes(rival, b)]
        beside = [*others, rival]
        poses, deep = moved_apart(beside, lambda k: self._told_of(beside[k]), still=len(others))
        if deep or poses[-1] is rival.camera_from_object:
            return rival
        self.trace.add(
            "move",
            "a little, so that it does not reach into an accepted object that it touches (A4)",
            of_type=name_of(rival),
        )
        return self._among(rival, poses[-1], others, rounds=0).told(status=rival.status, why=rival.why)

    def _among(
        self, belief: Hypothesis, pose: NDArray[np.float64], others: Sequence[Hypothesis], rounds: int
    ) -> Hypothesis:
        """The hypothesis near another pose (4, 4), beside these alone, and on the data that they leave."""
        free = np.ones(len(self.data.ids), dtype=bool)
        for other in others:
            free[list(claims(other))] = False
        hidden = hidden_among(belief, others)
        posed = self.models[belief.type].settle(pose, self.data, self.kb, free=free, hidden=hidden, rounds=rounds)
        return self._believed(posed, hidden_among(posed, others))
