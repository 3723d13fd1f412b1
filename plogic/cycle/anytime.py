"""Anytime: the cycle can be stopped between any two of its steps, and the heaviest stable Δi so far is then the answer.

* ``Stable``: what was accepted at one moment, made stable, as the cycle would end with it

The *weight* of Δi is the sum of the log-likelihood ratios of what it accepts, as the interpretation states them: ln of
how much likelier Γ is in its world than in the empty one. Law: more time never makes it less. A cycle with more time
comes to the same ones first, in the same order.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from plogic.cycle.beside import Beside, name_of, rounded
from plogic.cycle.trace import Step, Trace
from plogic.match.judged.disjoint import moved_apart, pose_information
from plogic.match.judged.rivals import apart_on_screen

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from plogic.facts.hypothesis import Hypothesis

HEAVIER = 1e-6
"""By how much a glance must be heavier than what is kept: two that only rounding tells apart are the same, whether
there is a deadline or not."""


class Stable(NamedTuple):
    """``of``: what was accepted; ``accepted``: what is left of it when it is stable; ``rejected``, ``steps``: what else came of that."""

    of: tuple[Hypothesis, ...] = ()
    accepted: tuple[Hypothesis, ...] = ()
    rejected: tuple[Hypothesis, ...] = ()
    steps: tuple[Step, ...] = ()

    @property
    def weight(self) -> float:
        """The sum of the log-likelihood ratios of what it accepts."""
        return sum(belief.worth for belief in self.accepted)


class Anytime(Beside):
    """Δi as it grows, and the heaviest stable one that it has been."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.trace = Trace()
        self.rejected: list[Hypothesis] = []
        self.reach = self.data.camera.f, 2.0 * self.kb.rates.match_tolerance
        self.best = self.last = Stable()
        self.reconsidered: dict[tuple[int, ...], tuple[tuple[Hypothesis, ...], Hypothesis]] = {}

    @property
    def unfinished(self) -> bool:
        """Whether the deadline stopped it."""
        return self.deadline.passed

    def _keep(self) -> None:
        """Make what is accepted now stable, and keep that if it is no lighter than what is kept."""
        self.last = self._stable()
        if self.last.weight >= self.best.weight:
            self.best = self.last

    def _dropped(self) -> bool:
        """Go on from the stable Δi where that is less than what was accepted; what does not hold in it is not accepted again."""
        if not self.last.rejected:
            return False
        self.accepted = list(self.last.accepted)
        self.rejected += self.last.rejected
        self.trace.steps += self.last.steps
        self.refused += self.last.rejected
        self._keep()
        return True

    def _glance(self, found: Sequence[tuple[float, Hypothesis]]) -> None:
        """Where there is a deadline keep what Δi is with the best of some poses, if that is heavier than what is kept.

        So there is an answer before a round is over.
        """
        if self.deadline.end is None or not found or self.last.weight + found[0][0] <= self.best.weight:
            return
        posed = self._judge(found[0][1], self.free(), rounds=0)
        self.deadline.check()
        belief = self._judge(posed, self.free(), rounds=2)
        if self._refusal(belief) is None:
            stable = self._stable(belief)
            self.best = stable if stable.weight > self.best.weight + HEAVIER else self.best

    def _conclude(self) -> None:
        """Δi is the heaviest stable one that there was; what was accepted else is rejected."""
        some, self.accepted = self.accepted, list(self.best.accepted)
        kept = [*self.best.of, *self.best.accepted]
        lost = [
            belief for belief in some if not any(belief.camera_from_object is one.camera_from_object for one in kept)
        ]
        self.rejected += [belief for belief in self.best.rejected if not any(belief is told for told in self.rejected)]
        self.trace.steps += self.best.steps
        for belief in lost:
            why = "a pose nearby explains more" if self._is_accepted(belief) else "Δi explains more without it"
            why = "the deadline came first" if self.unfinished else why
            self.rejected.append(belief.told(status="rejected", why=why))
            self.trace.add("release", f"{why}; its data are released", of_type=name_of(belief))

    def _stable(self, *more: Hypothesis) -> Stable:
        """What is accepted, and some ``more``, kept apart (A4) and reconsidered; nothing else changes."""
        before = self.accepted, self.rejected, self.trace
        self.accepted, self.rejected, self.trace = list(self.accepted), [], Trace()
        try:
            for belief in more:
                self._accept(belief)
            of = tuple(self.accepted)
            self._separate()
            self._stabilise()
            return Stable(of, tuple(self.accepted), tuple(self.rejected), tuple(self.trace.steps))
        finally:
            self.accepted, self.rejected, self.trace = before

    def _accept(self, belief: Hypothesis) -> None:
        self.accepted.append(belief.told(status="accepted", why="explains its data better than chance, ev above 0"))
        self.trace.add(
            "accept", f"log-likelihood ratio {belief.worth:.1f}", of_type=name_of(belief), ev=belief.ev_reconsidered
        )

    def _separate(self) -> None:
        """A4 to a millimetre: move apart, all together, what reaches into another; of two that cannot be, the one of less worth is rejected."""
        while True:
            self.deadline.check()
            poses, deep = moved_apart(self.accepted, lambda k: self._told_of(self.accepted[k]))
            if not deep:
                break
            worst = min({k for pair in deep for k in pair}, key=lambda k: self.accepted[k].worth)
            self.rejected.append(
                self.accepted.pop(worst).told(status="rejected", why="shares volume with an accepted object (A4)")
            )
            self.trace.add(
                "release",
                "no poses near keep it out of the others (A4); its data are released",
                of_type=name_of(self.rejected[-1]),
            )
        for k, (belief, pose) in enumerate(zip(list(self.accepted), poses, strict=True)):
            if pose is not belief.camera_from_object:
                posed = self.models[belief.type].settle(
                    pose,
                    self.data,
                    self.kb,
                    free=self.free(belief),
                    hidden=self._hidden(belief, belief),
                    rounds=0,
                )
                self.accepted[k] = posed.told(
                    worth=belief.worth,
                    surplus=belief.surplus,
                    ev=belief.ev,
                    ev_reconsidered=belief.ev_reconsidered,
                    status=belief.status,
                    why=belief.why,
                )
                self.trace.add(
                    "move", "a little, so that it does not reach into what it touches (A4)", of_type=name_of(belief)
                )

    def _told_of(self, posed: Hypothesis) -> NDArray[np.float64]:
        """(6, 6) what Γ tells of a pose (``plogic.match.judged.disjoint``)."""
        return pose_information(posed, self.data.camera, self.kb)

    def _stabilise(self) -> None:
        """Take every ev anew beside the others (reconsideration); drop what no longer holds, until Δi is stable. It only shrinks."""
        while True:
            self.accepted = [self._again(b) for b in self.accepted]
            bad = [b for b in self.accepted if b.ev_reconsidered is None or b.ev_reconsidered <= 0.0 or b.worth <= 0.0]
            if not bad:
                return
            worst = min(bad, key=lambda b: (b.ev_reconsidered is not None, b.ev_reconsidered or -1.0))
            self.accepted = [b for b in self.accepted if b is not worst]
            self.rejected.append(worst.told(status="rejected", why="ev or evidence is not above 0 beside the others"))
            self.trace.add(
                "release",
                "ev or evidence is not above 0 beside the others; its data are released",
                of_type=name_of(worst),
            )

    def _again(self, belief: Hypothesis) -> Hypothesis:
        """Ev of an accepted hypothesis with everything else that is accepted; as before where the same stand near it."""
        near = [b for b in self.accepted if b is not belief and not apart_on_screen(belief, b, *self.reach)]
        key = tuple(id(posed) for posed in (belief, *near))
        if key not in self.reconsidered:
            self.deadline.check()
            new = self._judge(belief, self.free(belief), rounds=0, skip=belief)
            self.reconsidered[key] = (belief, *near), new.told(status="accepted", why=belief.why)
        new = self.reconsidered[key][1]
        self.trace.add(
            "reconsider",
            f"ev {rounded(new.ev)} alone, {rounded(new.ev_reconsidered)} beside the others",
            of_type=name_of(belief),
            ev=new.ev_reconsidered,
        )
        return new
