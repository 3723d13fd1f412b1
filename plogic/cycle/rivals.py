"""Tell what is not accepted from the rivals of Δi: a rival would be accepted in the place of what it conflicts with."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from plogic.cycle.judging import FEWEST, believed, judged, refusal
from plogic.cycle.state import State, Step, Task, among, free, step_of
from plogic.match.judged.disjoint import moved_apart, pose_information
from plogic.match.judged.rivals import excludes, hidden_among

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from geometry.arrays import Floats
    from plogic.facts.hypothesis import Hypothesis


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


def set_aside(task: Task, state: State, hypothesis: Hypothesis, reason: str) -> State:
    """Keep as a rival what would be acceptable alone; reject the rest, which releases its data."""
    alone = _alone(task, state, hypothesis)
    if alone is not None:
        why = f"would be accepted in the place of what it conflicts with; beside that, {reason}"
        return replace(state, rivals=(*state.rivals, alone.told(status="rival", why=why)))
    rejected = (*state.rejected, hypothesis.told(status="rejected", why=reason))
    return replace(state, rejected=rejected).tells(step_of("reject", reason, hypothesis))


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

    None where it explains them worse by far.
    """
    replaced = [h for h in state.accepted if excludes(hypothesis, h)]
    if not replaced:
        return None
    others = [h for h in state.accepted if not any(h is one for one in replaced)]
    found = _beside(task, hypothesis, hypothesis.camera_from_object, others, rounds=1)
    if among(found, state.accepted):
        return None
    enough = int((found.expected(found.hidden) & found.detected).sum()) >= FEWEST
    near = found.worth > sum(h.worth for h in replaced) - task.models[hypothesis.type].significance(hypothesis)
    return found if enough and found.ev_reconsidered is not None and near else None


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
    return believed(task, posed, hidden_among(posed, others))
