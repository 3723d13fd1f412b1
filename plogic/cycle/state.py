"""The state of the perceptual cycle (figure 1), and what a run works on.

Vocabulary, each with an example value:

* ``Task``: Γ, the models of Σo and the clock of one run, ``Task(data, kb, models, dv)``
* ``State``: Δh with Δi and the trace after one step, ``State(accepted=(h,), proposals=(Proposal(h, 1),), ...)``
* ``Proposal``: a proposed hypothesis, and beside how many accepted ones it was judged last
* ``Stable``: what is left of Δi when it is stable; of equal or greater weight than any before it is the answer
* ``Step``, ``Trace``: which hypotheses were tried, and why each was kept or dropped
* ``Cycle``: the outcome
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from geometry.arrays import Mask
from kb.clouds.cloud import KnowledgeBase
from plogic.base.clock import Deadline, unasked
from plogic.cycle.planes import Setting, Supported
from plogic.facts.document import StepRow
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.judged.rivals import EVEN, claims, in_the_way, same_place
from plogic.match.judged.type_models import Request, Search
from plogic.match.kinds import Models
from plogic.match.learned.convincing import THERE


@dataclass(frozen=True)
class Step:
    """One event, with its reason in one sentence; ``ev`` where it was decided by ev."""

    event: str
    why: str
    type: str | None = None
    hypothesis: str | None = None
    ev: float | None = None


def step_of(event: str, why: str, hypothesis: Hypothesis) -> Step:
    """An event of one hypothesis, decided by its ev."""
    return Step(event, why, hypothesis.type, ev=hypothesis.ev_reconsidered)


@dataclass
class Trace:
    """The steps in order."""

    steps: list[Step] = field(default_factory=list)

    def document(self) -> list[StepRow]:
        """As in ``interpretation.json``."""
        return [
            {"step": i, "event": s.event, "hypothesis": s.hypothesis, "type": s.type, "ev": s.ev, "why": s.why}
            for i, s in enumerate(self.steps, 1)
        ]


class Stable(NamedTuple):
    """``of``: what was accepted; ``accepted``: what is left of it when it is stable.

    ``rejected``, ``steps``: what else came of that.
    """

    of: tuple[Hypothesis, ...] = ()
    accepted: tuple[Hypothesis, ...] = ()
    rejected: tuple[Hypothesis, ...] = ()
    steps: tuple[Step, ...] = ()

    @property
    def weight(self) -> float:
        """The sum of the log-likelihood ratios of what it accepts."""
        return sum(hypothesis.worth for hypothesis in self.accepted)


@dataclass(eq=False)
class Heaviest:
    """The heaviest stable Δi so far. It outlives a deadline that comes within a step, and is the answer then."""

    stable: Stable = field(default_factory=Stable)

    def keep(self, stable: Stable) -> None:
        """Keep a stable Δi if it is no lighter."""
        if stable.weight >= self.stable.weight:
            self.stable = stable


JUDGING = "judging what was found"
"""How far a search has come where it counts no types."""


def of_types(number: int, total: int) -> str:
    """How far a search has come: ``3 of 8 types``."""
    return f"{number} of {total} type{'s' * (total != 1)}"


@dataclass(frozen=True, eq=False)
class Task:
    """What one run works on, the same in all its states.

    ``end``: a moment of ``time.monotonic`` at which a search stops, None for never; ``processes``: how many search,
    this one and copies of it; ``at`` is told how far it has come. ``heaviest`` and ``remembered`` are its memory: the
    answer if time were over now, and what was reconsidered before, by the hypotheses that stood near it.
    """

    data: Data
    kb: KnowledgeBase
    models: Models
    dv: Mapping[str, float]
    end: float | None = None
    processes: int = 1
    at: Callable[[str], None] = unasked
    heaviest: Heaviest = field(default_factory=Heaviest)
    remembered: dict[tuple[int, ...], tuple[tuple[Hypothesis, ...], Hypothesis]] = field(default_factory=dict)

    @cached_property
    def deadline(self) -> Deadline:
        """The clock of the run."""
        return Deadline(self.end)

    @cached_property
    def request(self) -> Request:
        """What every search is asked for."""
        return Request(self.data, self.kb, self.deadline.check, self.processes)

    @cached_property
    def searches(self) -> list[tuple[Mapping[str, object], Search]]:
        """By kind of type models: its types, and the search for them in this Γ."""
        return [(kind.models, kind.search(self.request)) for kind in self.models.kinds.values()]

    @property
    def setting(self) -> Setting:
        """What its poses are judged by."""
        return Setting(self.models, self.data.camera, self.kb, self.before)

    def before(self, hypothesis: Hypothesis) -> float:
        """The log-odds that it is there, before its pixels are looked at, as far as these were; else they count all."""
        return 0.0 if hypothesis.pixels is None else float(np.log(THERE)) - self.demanded(hypothesis)

    @property
    def reach(self) -> tuple[float, float]:
        """Focal length, and the pixels within which two bodies on the screen may concern each other."""
        return self.data.camera.f, 2.0 * self.kb.rates.match_tolerance

    def demanded(self, hypothesis: Hypothesis) -> float:
        """The log-likelihood ratio that a hypothesis must exceed, beyond what any pose has."""
        search, model = self.search_for(hypothesis), self.models[hypothesis.type]
        return model.significance(hypothesis) if search is None else search.demanded(model, hypothesis)

    def search_for(self, hypothesis: Hypothesis) -> Search | None:
        """The search for its type, while there is one."""
        return next((search for models, search in self.searches if hypothesis.type in models), None)


@dataclass(frozen=True)
class Attention:
    """rank(Type), its excess over what clutter alone would give, and the best rank within one view cell.

    All in [−1, 1]. ``vote``: how well its best pose is voted for, 0 where nothing votes.
    """

    type: str
    rank: float
    excess: float
    within_cell: float
    vote: float = 0.0


class Proposal(NamedTuple):
    """A proposed hypothesis.

    ``beside``: how many accepted ones, the first, it was judged beside, None where it was not yet; ``most``: what it
    was worth at best, before others claimed its data.
    """

    hypothesis: Hypothesis
    beside: int | None = None
    most: float = -inf


@dataclass(frozen=True, eq=False)
class State:
    """Where the cycle stands after a step.

    ``accepted`` is Δi in the order of acceptance. ``proposals`` are those of all types that are judged again each
    round; ``rivals``, ``rejected``: what
    was told of the others. ``refused`` was accepted once, and did not hold. ``stable`` is Δi made stable.
    ``supported``: the planes that things may stand on, where they rest; ``stood_on``: how many were accepted when it
    was asked last what else stands there. ``turns``: how often something
    gave reason to go round again; ``tried``: the types that were searched for, and after how many turns last.
    """

    attention: tuple[Attention, ...] = ()
    accepted: tuple[Hypothesis, ...] = ()
    proposals: tuple[Proposal, ...] = ()
    rivals: tuple[Hypothesis, ...] = ()
    rejected: tuple[Hypothesis, ...] = ()
    refused: tuple[Hypothesis, ...] = ()
    stable: Stable = field(default_factory=Stable)
    supported: Supported | None = None
    stood_on: int = -1
    turns: int = 0
    tried: Mapping[str, int] = field(default_factory=dict)
    steps: tuple[Step, ...] = ()

    def tells(self, *steps: Step) -> "State":
        """The same, with more of the trace."""
        return replace(self, steps=(*self.steps, *steps))

    def proposes(self, found: Iterable[Hypothesis]) -> "State":
        """The same, with more to judge."""
        return replace(self, proposals=(*self.proposals, *map(Proposal, found)))


@dataclass(frozen=True)
class Cycle:
    """``accepted`` is Δi in the order of acceptance; ``considered`` the rest of Δh.

    ``rejected`` what was tried and dropped; ``unweighed`` is the status of rivals among it that are too many.

    ``unfinished``: whether a deadline stopped it; ``supported``: the planes that its proposals told of.
    """

    accepted: tuple[Hypothesis, ...]
    considered: tuple[Hypothesis, ...]
    rejected: tuple[Hypothesis, ...]
    attention: tuple[Attention, ...]
    trace: Trace
    unfinished: bool = False
    supported: Supported | None = None


def free(task: Task, accepted: Iterable[Hypothesis]) -> Mask:
    """(A,) the data that none of these claims."""
    mask = np.ones(len(task.data.ids), dtype=bool)
    for hypothesis in accepted:
        mask[list(claims(hypothesis))] = False
    return mask


def same_hypothesis(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two hypotheses are near-duplicates: one type, one place up to symmetry (§8)."""
    return one.type == other.type and same_place(one.object_type, one.camera_from_object, other.camera_from_object)


def among(hypothesis: Hypothesis, others: Iterable[Hypothesis]) -> bool:
    """Whether it is a near-duplicate of any of these."""
    return any(same_hypothesis(hypothesis, other) for other in others)


MOST_RIVALS = 2
"""Rivals that enter Δh for each accepted hypothesis that they conflict with, ..."""
MOST_EQUAL = 8
"""... and so many where more are as heavy as the last of these, such as the turns of a body that is even but for one
feature: to weigh some of them alone would give each of these the share of all."""


NOBODY = -1
"""The number of no accepted hypothesis: that of what conflicts with none."""


def considered(rivals: Sequence[Hypothesis], accepted: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The rivals that are weighed, best first, near-duplicates merged."""
    return best_of_each([(rival.worth, rival) for rival in rivals], accepted)


def best_of_each(found: Iterable[tuple[float, Hypothesis]], accepted: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The best by worth of what conflicts with each accepted hypothesis, and of what conflicts with none of them.

    So what stands elsewhere decides nothing. One that conflicts with several counts for all of them, and is kept where
    one of them has room. Near-duplicates of each other or of an accepted one are left out.
    """
    kept: list[Hypothesis] = []
    counted: dict[int, list[float]] = {}
    for worth, one in sorted(found, key=lambda pair: -round(pair[0], EVEN)):
        if among(one, [*kept, *accepted]):
            continue
        against = [k for k, other in enumerate(accepted) if in_the_way(one, other)] or [NOBODY]
        if any(_has_room(counted.get(k, []), worth) for k in against):
            kept.append(one)
            for k in against:
                counted.setdefault(k, []).append(worth)
    return kept


def _has_room(before: Sequence[float], worth: float) -> bool:
    """Whether one more is weighed beside those of these worths, best first."""
    if len(before) < MOST_RIVALS:
        return True
    return len(before) < MOST_EQUAL and round(before[MOST_RIVALS - 1], EVEN) == round(worth, EVEN)
