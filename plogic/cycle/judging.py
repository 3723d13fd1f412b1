"""Judge a hypothesis beside Δi.

Expected, Detected, the four cases, ev and evidence, on the data left free (§4, §5.5, §7).

What is not accepted is told from the rivals of Δi: a rival would be accepted in the place of what it conflicts with.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from geometry.arrays import Floats, Mask
from kb.clouds.cloud import KnowledgeBase
from plogic.cycle.state import Cycle, Proposal, State, Step, Task, among, best_of_each, free, step_of
from plogic.facts.hypothesis import Hypothesis
from plogic.match.judged.evidence import evidence, pose_information
from plogic.match.judged.evidence import judged as judged_alone
from plogic.match.judged.expectation import hidden_by
from plogic.match.judged.rivals import (
    SHARED_CLAIMS,
    apart_on_screen,
    excludes,
    hidden_among,
    hides_most,
    in_the_way,
    moved_apart,
    overlap,
    shared_claims,
)
from plogic.match.learned.convincing import SURE, THERE
from plogic.measures.distinctiveness import distinctiveness_over_delta
from plogic.measures.explanatory import explanatory_value

FEWEST = 4
"""Expected features that must be detected before a hypothesis counts: a phantom wholly out of sight has ev = +1 (§8,
trap b)."""


def judge(
    task: Task,
    beside: Sequence[Hypothesis],
    proposed: Hypothesis,
    rounds: int,
    *,
    left: Mask | None = None,
    anew: bool = True,
) -> Hypothesis:
    """A hypothesis beside these, matched on the data ``left`` (A,) that they do not claim, or refined in ``rounds``.

    The features that they hide are not expected; those that A4 excludes beside it are rivals and hide nothing (D7). Not
    ``anew``: it is matched so already.
    """
    hidden = hidden_among(proposed, beside)
    if rounds or anew:
        left = free(task, beside) if left is None else left
        start = proposed if rounds else proposed.camera_from_object
        beyond = proposed.beyond()
        proposed = task.models[proposed.type].settle(start, task.data, task.kb, free=left, hidden=hidden, rounds=rounds)
        proposed = task.models[proposed.type].beside(proposed.told(**beyond), beside, task.data)
    return judged_alone(proposed, task.data, task.kb, task.dv, hidden_among(proposed, beside) if rounds else hidden)


def judged(task: Task, state: State) -> State:
    """All proposals beside Δi: as before where nothing near was accepted since."""
    left, proposals = free(task, state.accepted), []
    for proposed, beside, most in state.proposals:
        task.deadline.check()
        near = beside is None or any(
            not apart_on_screen(proposed, other, *task.reach) for other in state.accepted[beside:]
        )
        anew = bool(state.accepted) or not task.models[proposed.type].settled_when_found
        again = judge(task, state.accepted, proposed, 0, left=left, anew=anew) if near else proposed
        proposals.append(Proposal(again, len(state.accepted), max(most, again.worth)))
    return replace(state, proposals=tuple(proposals))


def refusal(task: Task, state: State, hypothesis: Hypothesis) -> str | None:
    """Why a hypothesis, judged beside Δi, is not accepted, or None."""
    return _unsupported(task, state, hypothesis) or _excluded(state, hypothesis)


def _unsupported(task: Task, state: State, hypothesis: Hypothesis) -> str | None:
    """Why its own evidence, beside Δi, does not carry it: what is hidden there is not expected."""
    expected, model = hypothesis.expected(hypothesis.hidden), task.models[hypothesis.type]
    found = expected & hypothesis.detected
    number = int(found.sum())
    if number < FEWEST:
        return f"{f'only {number}' if number else 'none'} of its expected features detected; {FEWEST} are demanded"
    shown = hypothesis.axes is None and expected[model.anchors].any()  # where angles count, any features start it
    if shown and not found[model.anchors].any():
        return "none of its most distinctive features was detected"
    if hypothesis.ev_reconsidered is None or hypothesis.ev_reconsidered <= 0.0:
        return f"ev {rounded(hypothesis.ev_reconsidered)} is not above 0"
    surplus = surplus_beside(hypothesis, state.accepted) + _harm(task, state.accepted, hypothesis)
    demanded = task.demanded(hypothesis)
    if surplus <= demanded:
        return f"log-likelihood ratio {surplus:.1f} beyond what any pose has; {demanded:.1f} is demanded"
    return None


def surplus_beside(hypothesis: Hypothesis, others: Iterable[Hypothesis]) -> float:
    """What is left of its evidence besides what any pose has; standing counts where its own pixels tell its pose."""
    told = not any(_in_line(hypothesis, other) for other in others)
    return hypothesis.surplus if told else hypothesis.surplus - max(0.0, hypothesis.stance)


def _in_line(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two of a type are in one place of the picture: where the hinder one stands, hardly a pixel tells."""
    if one.type != other.type or one.object_type.surface is None:
        return False
    sight, there = (posed.middle / posed.middle[2] for posed in (one, other))
    nearer = min(one.middle[2], other.middle[2])
    return bool(np.linalg.norm(sight - there) * nearer < 0.5 * one.object_type.surface.diameter)


def _excluded(state: State, hypothesis: Hypothesis) -> str | None:
    """Which constraint keeps it out of Δi."""
    if among(hypothesis, state.refused):
        return "was accepted before, and did not hold beside the others"
    for other in state.accepted:
        if overlap(hypothesis, other):
            return "shares volume with an accepted object (A4)"
        if shared_claims(hypothesis, other)[1] > SHARED_CLAIMS:
            return "explains the same appearances as an accepted object"
    return None


TOUCHING = 0.15
"""Share of the smaller volume from which two are not beside each other, but in one place: assumed."""
SQUEEZED = 3.0
"""Standard deviations of its pose by which one that touches others may have to be moved, or they, to be accepted.

In a trace of two rendered scenes what was there had to be moved by 0.7 and 1.2, what was not by 5.9.
"""


def may_be_accepted(task: Task, state: State, hypothesis: Hypothesis) -> bool:
    """Whether nothing keeps it out of Δi, or volume alone that it shares with others, which little moves undo."""
    if _unsupported(task, state, hypothesis) is not None:
        return False
    return _excluded(state, hypothesis) is None or _touching(task, state, hypothesis)


def _touching(task: Task, state: State, hypothesis: Hypothesis) -> bool:
    if among(hypothesis, state.refused):
        return False
    for other in state.accepted:
        claimed = shared_claims(hypothesis, other)[1] > SHARED_CLAIMS
        in_one_place = _in_line(hypothesis, other) or overlap(hypothesis, other, TOUCHING)
        if claimed or in_one_place or hides_most(hypothesis, other):
            return False
    some = [*state.accepted, hypothesis]
    return not moved_apart(some, lambda k: pose_information(some[k], task.data.camera, task.kb), far=SQUEEZED)[1]


def _harm(task: Task, accepted: Sequence[Hypothesis], hypothesis: Hypothesis) -> float:
    """What the accepted ones would lose if this stood before them.

    At most 0, for to hide a detected feature is counter-evidence.
    """
    change = 0.0
    for other in accepted if hypothesis.opaque else ():
        before = hidden_among(other, accepted)
        after = before | hidden_by(other, hypothesis)
        if (after != before).any() and not overlap(hypothesis, other):
            with_it, without = (evidence(other, task.data, task.kb, mask).ratio for mask in (after, before))
            change += with_it - without
    return min(0.0, change)


def rounded(value: float | None) -> float | str:
    """An ev as the trace tells it."""
    return "undefined (0/0)" if value is None else round(value, 3)


def compared(task: Task, state: State) -> Iterator[State]:
    """Tell what is left of the proposals from rivals of Δi, one after the other.

    What is told is no proposal any more.
    """
    state = judged(task, state)
    yield state
    while state.proposals:
        task.deadline.check()
        hypothesis = state.proposals[0].hypothesis
        why = refusal(task, state, hypothesis) or "of less worth than what was refined, and not acceptable then"
        state = set_aside(task, replace(state, proposals=state.proposals[1:]), hypothesis, why)
        yield state


def may_replace(task: Task, state: State, proposals: Iterable[Proposal]) -> list[Proposal]:
    """Those that were once worth as much as an accepted one in whose place they stand, and may be its rivals.

    Beside it they are worth little, since it has their data; so they go by what they were worth at most.
    """
    near = []
    for proposal in proposals:
        hypothesis = proposal.hypothesis
        least = proposal.most + task.demanded(hypothesis)
        if any(h.worth < least and in_the_way(hypothesis, h) for h in state.accepted):
            near.append(proposal)
    best = best_of_each([(proposal.most, proposal.hypothesis) for proposal in near], state.accepted)
    return [proposal for proposal in near if any(proposal.hypothesis is one for one in best)]


def sure(task: Task, state: State) -> State:
    """The state without what its pixels and stance do not tell surely enough, now that nothing more is looked for."""
    more = float(np.log(SURE / THERE))
    kept, unsure = list[Hypothesis](), list[Hypothesis]()
    for one in state.accepted:
        others = [other for other in state.accepted if other is not one]
        surplus, demanded = surplus_beside(one, others), task.demanded(one) + more
        if one.pixels is None or surplus > demanded:
            kept.append(one)
            continue
        why = f"log-likelihood ratio {surplus:.1f} beyond what any pose has; in the end {demanded:.1f} is demanded"
        unsure.append(one.told(status="rejected", why=why))
    steps = (step_of("release", f"{one.why}; its data are released", one) for one in unsure)
    return replace(state, accepted=tuple(kept), rejected=(*state.rejected, *unsure)).tells(*steps)


def set_aside(task: Task, state: State, hypothesis: Hypothesis, reason: str) -> State:
    """Keep as a rival what would be acceptable alone; reject the rest, which releases its data."""
    alone = _alone(task, state, hypothesis)
    if alone is not None:
        why = f"would be accepted in the place of what it conflicts with; beside that, {reason}"
        return replace(state, rivals=(*state.rivals, alone.told(status="rival", why=why)))
    rejected = (*state.rejected, hypothesis.told(status="rejected", why=reason))
    return replace(state, rejected=rejected).tells(step_of("reject", reason, hypothesis))


def over_instances(cycle: Cycle, kb: KnowledgeBase) -> tuple[Cycle, dict[str, float]]:
    """The cycle with every ev weighed by dv over the instances in Δi, and that dv (§5.1, the paper's variant of §9).

    What is accepted and has no ev above 0 by it is rejected, and dv taken anew. It is that over Σo where Δi is empty,
    or has one feature type alone, whose dv would be 0.
    """
    while True:
        kinds = [h.object_type for h in cycle.accepted]
        dv = distinctiveness_over_delta(kinds, kb.types)
        if not any(dv[f.type] for kind in kinds for f in kind.all_features):
            dv = distinctiveness_over_delta((), kb.types)
        accepted, considered, rejected = (
            tuple(_weighed(h, dv) for h in some) for some in (cycle.accepted, cycle.considered, cycle.rejected)
        )
        low = [h for h in accepted if h.ev_reconsidered is None or h.ev_reconsidered <= 0.0]
        for h in low:
            why = f"ev {rounded(h.ev_reconsidered)} is not above 0 by dv over the instances in Δ"
            rejected = (h.told(status="rejected", why=why), *rejected)
            cycle.trace.steps.append(step_of("reject", why, h))
        kept = tuple(h for h in accepted if h not in low)
        cycle = replace(cycle, accepted=kept, considered=considered, rejected=rejected)
        if not low:
            return cycle, dv


def _weighed(h: Hypothesis, dv: Mapping[str, float]) -> Hypothesis:
    """The hypothesis with its ev by another dv; one without arrays keeps its own."""
    ev = (explanatory_value(h.support(hidden), dv) for hidden in (None, h.hidden))
    return h.told(ev=next(ev), ev_reconsidered=next(ev)) if len(h.uv) else h


def left_over(state: State) -> State:
    """Reject what was judged, and what there was no time to tell."""
    late = [
        proposal.hypothesis.told(status="rejected", why="the deadline came first")
        for proposal in state.proposals
        if proposal.beside is not None and not among(proposal.hypothesis, state.accepted)
    ]
    return replace(state, rejected=(*state.rejected, *late))


def making_way(task: Task, state: State, rivals: Sequence[Hypothesis]) -> tuple[State, tuple[Hypothesis, ...]]:
    """The rivals, each moved out of the accepted that it leaves where they are (A4), if it can be and there is time."""
    moved = []
    for rival in rivals:
        found = None if task.deadline.passed else _makes_way(task, state, rival)
        moved.append(found or rival)
        if found is not None:
            why = "a little, so that it does not reach into an accepted object that it touches (A4)"
            state = state.tells(Step("move", why, rival.type))
    return state, tuple(moved)


def _alone(task: Task, state: State, hypothesis: Hypothesis) -> Hypothesis | None:
    """The hypothesis beside the other accepted ones, with the data of those that it would replace.

    None where it explains them worse by far; of those that only hide it, where it does not explain more by far; and
    where its pixels would not be enough for it.
    """
    replaced = [h for h in state.accepted if in_the_way(hypothesis, h)]
    if not replaced:
        return None
    least = task.demanded(hypothesis)
    least *= -1.0 if any(excludes(hypothesis, h) for h in replaced) else 1.0
    others = [h for h in state.accepted if not any(h is one for one in replaced)]
    found = _beside(task, hypothesis, hypothesis.camera_from_object, others, rounds=1)
    if among(found, state.accepted):
        return None
    enough = (found.expected(found.hidden) & found.detected).sum() >= FEWEST
    near = found.worth > sum(h.worth for h in replaced) + least
    shown = found.pixels is None or surplus_beside(found, others) > task.demanded(found)
    return found if enough and found.ev_reconsidered is not None and near and shown else None


def _makes_way(task: Task, state: State, rival: Hypothesis) -> Hypothesis | None:
    """The rival where it reaches into nobody; None where it stands so already, or cannot."""
    others = [h for h in state.accepted if not excludes(rival, h)]
    beside = [*others, rival]
    poses, deep = moved_apart(
        beside, lambda k: pose_information(beside[k], task.data.camera, task.kb), still=len(others)
    )
    if deep or poses[-1] is rival.camera_from_object:
        return None
    return _beside(task, rival, poses[-1], others, rounds=0).told(status=rival.status, why=rival.why)


def _beside(task: Task, hypothesis: Hypothesis, pose: Floats, others: Sequence[Hypothesis], rounds: int) -> Hypothesis:
    """The hypothesis near another pose (4, 4), beside these alone, and on the data that they leave."""
    hidden = hidden_among(hypothesis, others)
    posed = task.models[hypothesis.type].settle(
        pose, task.data, task.kb, free=free(task, others), hidden=hidden, rounds=rounds
    )
    posed = task.models[posed.type].beside(posed.told(**hypothesis.beyond()), others, task.data)
    return judged_alone(posed, task.data, task.kb, task.dv, hidden_among(posed, others))
