"""The perceptual cycle (§7): rank, match, pose, expect, judge; accept, or reject and release; until Γ has a coherent explanation."""

from __future__ import annotations

from contextlib import closing, suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.clock import OutOfTimeError
from plogic.cycle.anytime import Anytime
from plogic.cycle.belief import Cycle, considered
from plogic.cycle.beside import FEWEST, name_of
from plogic.cycle.covering import covered_by
from plogic.cycle.support import bodies, supported
from plogic.match.by_copies import searched
from plogic.match.indices import FAST, generate, generate_plainly, generate_together, settle, significant
from plogic.match.judged.disjoint import moved_apart
from plogic.match.judged.rivals import apart_on_screen, claims, excludes, hidden_among
from plogic.match.learned.learned_index import LearnedIndex

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.cycle.attention import Attention
    from plogic.cycle.belief import Belief
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.indices import Index
    from plogic.match.oriented.pair_index import PairIndex

POOL = 10
"""Poses that are carried from one round to the next, the best."""
POOL_OF_TYPE = 3
"""... and so many for each type of the knowledge base, where these are more."""
POLISHED = 6
"""Poses of a round that are refined beside Δi before they are accepted or not, the best first."""
POLISH = 10.0
"""What refinement beside Δi may add to the evidence of a learned type, which was refined when it was found: one that
lacks more is not refined."""
FEW_LEFT = 100
"""Matches of a feature and a datum that looks like it: where no more are left, single data are asked beside what is
accepted, too."""
AGAIN = 40
"""Poses of a learned type whose sides are looked at where it is searched for again, after one of it was accepted."""


class Perception(Anytime):
    """One run of the cycle over one Γ: the state that its steps share."""

    def __post_init__(self, shared: PairIndex | None) -> None:
        super().__post_init__(shared)
        self.rivals: list[Belief] = []
        self.searched: dict[str, int] = {}
        self.standing = 0
        self.known: dict[int, tuple[Belief, int]] = {}

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
        if self._accepts(
            [b for b in self._judged(pool) if self._search_for(b.posed) and self._refusal(b) is None], pool, left
        ):
            return True
        together = self._together(left)
        alone = [
            self.indices[row.type] for row in attention if row.type not in together and not self._exhausted(row.type)
        ]
        by_hand = any(not isinstance(index, LearnedIndex) for index in alone)
        taken = bodies(self.accepted)
        covered = covered_by([b.posed for b in self.accepted], self.data) if by_hand else None

        def search(index: Index) -> list[tuple[float, Hypothesis]]:
            if self.generator != FAST and not isinstance(index, LearnedIndex):
                return generate_plainly(self.generator, index, left, self.kb, self._hidden, self.deadline.check)
            return generate(index, left, self.kb, covered, taken, self.deadline.check, **self._fewer(index))

        with closing(searched(search, alone, left, self.processes)) as searches:
            for row in attention:
                self.deadline.check()
                if row.type in together:
                    pool += [posed for _, posed in together[row.type]]
                elif not self._exhausted(row.type):
                    found = next(searches)
                    self._glance(found)
                    pool += [posed for _, posed in found]
                    self.searched[row.type] = sum(name_of(b) == row.type for b in self.accepted)
        judged = sorted(self._judged(pool), key=lambda b: -b.worth)
        pool[:] = [b.posed for b in judged[: max(POOL, POOL_OF_TYPE * len(self.indices))]]
        return self._accepts(judged, pool, left)

    def _accepts(self, judged: Sequence[Belief], pool: list[Hypothesis], left: Data) -> bool:
        """Accept the best of some that is acceptable, refined beside Δi; the pool loses it. True where there is one."""
        for belief in sorted(judged, key=lambda b: -b.worth)[:POLISHED]:
            self.deadline.check()
            if isinstance(belief.index, LearnedIndex) and belief.surplus < significant(belief.posed) - POLISH:
                continue
            better = self._tilted(self._judge(belief.posed, self.free(), rounds=2), left)
            either = (
                [better] if isinstance(belief.index, LearnedIndex) else [better, belief]
            )  # places alone may fit better and lose a match
            holds = next((b for b in either if self._refusal(b) is None), None)
            if holds is not None:
                self._accept(holds)
                self._keep()
                pool[:] = [posed for posed in pool if not self._is_accepted(posed)]
                return True
        return False

    def _together(self, left: Data) -> dict[str, list[tuple[float, Hypothesis]]]:
        """By type, what is found of the types that are searched for together, if there are any."""
        if self.together is None:
            return {}
        known = self.together.unasked
        found = generate_together(self.together, left, self.kb, self._hidden, self._glance)
        if self.together.unasked > known:
            self.trace.add(
                "deepen",
                f"{self.together.unasked} types were left out, those that pairs vote for least: too many data look alike",
            )
        return found

    def _fewer(self, index: Index) -> dict[str, int]:
        """How far to search for a type: less far again, for what stood out most of it is claimed."""
        again = isinstance(index, LearnedIndex) and index.object_type.name in self.searched
        return {"refined": AGAIN} if again else {}

    def _rested(self, pool: list[Hypothesis]) -> bool:
        """Add to the pool what may stand where accepted objects do, where gravity holds and more were accepted since. True where something may."""
        if not self.kb.gravity or self.standing == len(self.accepted):
            return False
        self.standing = len(self.accepted)
        found, why = supported(
            self.accepted, self.indices, self.data.only(self.free()), self.kb, self.processes, self.deadline.check
        )
        if why is not None:
            self.trace.add("support", why)
        pool += found
        return bool(found)

    def _deepened(self) -> bool:
        """Ask single data for the types that are searched for together, once, where nothing at all was accepted, or little is left to ask."""
        if self.together is None or self.together.deepened or (self.accepted and not self._little_left()):
            return False
        self.together.deepen()
        why = "so little is left that it can be asked" if self.accepted else "nothing is acceptable"
        self.trace.add("deepen", f"{why}: every datum votes by itself")
        return True

    def _little_left(self) -> bool:
        """Whether all types written by hand together have at most ``FEW_LEFT`` matches of a feature and a free datum that looks like it."""
        left, matches = self.data.only(self.free()), 0
        for index in self.indices.values():
            matches += 0 if isinstance(index, LearnedIndex) else int(index.allowed(left).sum())
            if matches > FEW_LEFT:
                return False
        return True

    def _released(self) -> bool:
        """Drop from Δi, for good, what does not hold in it when it is stable, so that its data are searched again. True where there was any."""
        if not self._dropped():
            return False
        self.known, self.standing = {}, 0
        return True

    def _exhausted(self, name: str) -> bool:
        """Whether another search would find nothing new: of a learned type all poses are in the pool, unless one of it was accepted since."""
        return isinstance(self.indices[name], LearnedIndex) and self.searched.get(name) == sum(
            name_of(b) == name for b in self.accepted
        )

    def _judged(self, pool: Sequence[Hypothesis]) -> list[Belief]:
        """Each pose beside what is accepted: matched on free data, hidden features not expected; as before where nothing near was accepted."""
        free, judged = self.free(), []
        for posed in pool:
            self.deadline.check()
            known, accepted = self.known.get(id(posed), (None, 0))
            stale = known is None or any(
                not apart_on_screen(posed, b.posed, *self.reach) for b in self.accepted[accepted:]
            )
            judged.append(self._judge(posed, free, rounds=0) if known is None or stale else known)
        self.known = {id(belief.posed): (belief, len(self.accepted)) for belief in judged}
        return judged

    def _tilted(self, belief: Belief, left: Data) -> Belief:
        """The best of a hypothesis and of itself at other tilts, where it was searched for with others: in one place it may fit in several ways."""
        search = self._search_for(belief.posed)
        if search is None or belief.surplus < significant(belief.posed) - POLISH:
            return belief
        poses = search.tilted(name_of(belief), belief.posed.camera_from_object, left)
        others = [settle(belief.index, pose, self.data, self.kb, free=self.free(), rounds=0) for pose in poses]
        return max([belief, *(self._judge(posed, self.free(), rounds=1) for posed in others)], key=lambda b: b.worth)

    def _compare(self, pool: list[Hypothesis]) -> None:
        """Tell what is left in the pool from rivals of Δi; what is told leaves the pool."""
        judged = self._judged(pool)
        pool[:] = [belief.posed for belief in judged]
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
            self.rejected.append(replace(belief, status="rejected", why="the deadline came first"))

    def _set_aside(self, belief: Belief, reason: str) -> None:
        """Keep as a rival what would be acceptable alone; reject the rest, which releases its data."""
        alone = self._alone(belief)
        if alone is not None:
            self.rivals.append(
                replace(
                    alone,
                    status="rival",
                    why=f"would be accepted in the place of what it conflicts with; beside that, {reason}",
                )
            )
        else:
            self.rejected.append(replace(belief, status="rejected", why=reason))
            self.trace.add("reject", reason, of_type=name_of(belief), ev=belief.ev_reconsidered)

    def _alone(self, belief: Belief) -> Belief | None:
        """The hypothesis beside the other accepted ones, with the data of those that it would replace; None where it explains them worse by far."""
        replaced = [b for b in self.accepted if excludes(belief.posed, b.posed)]
        if not replaced:
            return None
        others = [b.posed for b in self.accepted if not any(b is other for other in replaced)]
        found = self._among(belief, belief.posed.camera_from_object, others, rounds=1)
        if self._is_accepted(found.posed):
            return None
        posed, hidden = found.posed, hidden_among(found.posed, others)
        enough = int((posed.candidate & posed.detected & ~hidden).sum()) >= FEWEST
        near = found.worth > sum(b.worth for b in replaced) - significant(belief.posed)
        return found if enough and found.ev_reconsidered is not None and near else None

    def _makes_way(self, rival: Belief) -> Belief:
        """A rival, moved out of the accepted that it leaves where they are (A4), if it can be and there is time."""
        if self.unfinished:
            return rival
        others = [b.posed for b in self.accepted if not excludes(rival.posed, b.posed)]
        beside = [*others, rival.posed]
        poses, deep = moved_apart(beside, lambda k: self._told_of(beside[k]), still=len(others))
        if deep or poses[-1] is rival.posed.camera_from_object:
            return rival
        self.trace.add(
            "move",
            "a little, so that it does not reach into an accepted object that it touches (A4)",
            of_type=name_of(rival),
        )
        return replace(self._among(rival, poses[-1], others, rounds=0), status=rival.status, why=rival.why)

    def _among(self, belief: Belief, pose: NDArray[np.float64], others: Sequence[Hypothesis], rounds: int) -> Belief:
        """The hypothesis near another pose (4, 4), beside these alone, and on the data that they leave."""
        free = np.ones(len(self.data.ids), dtype=bool)
        for other in others:
            free[list(claims(other))] = False
        hidden = hidden_among(belief.posed, others)
        posed = settle(belief.index, pose, self.data, self.kb, free=free, hidden=hidden, rounds=rounds)
        return self._believed(posed, belief.index, hidden_among(posed, others))
