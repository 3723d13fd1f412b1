"""Choose Δi: which hypotheses are accepted is one function of what was judged (figure 1), and another can take its place."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

from plogic.cycle.judging import judge, refusal
from plogic.cycle.stability import acceptance, accepted, kept
from plogic.cycle.state import State, Task, among, free

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data

POLISHED = 6
"""Poses of a round that are refined beside Δi before they are accepted or not, the best first."""
POLISH = 10.0
"""What refinement beside Δi may add to the evidence of a type that was refined when it was found: one that lacks more
is not refined."""

Choice: TypeAlias = "Callable[[Task, State, Sequence[Hypothesis]], tuple[Hypothesis, ...]]"
"""Of the state and of judged hypotheses, those that make up Δi from now on.

Those of ``State.accepted``, where nothing changes.
"""


def best_first(task: Task, state: State, judged: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Δi with the best of the judged that is acceptable, refined beside Δi."""
    left = task.data.only(free(task, state.accepted))
    for hypothesis in sorted(judged, key=lambda h: -h.worth)[:POLISHED]:
        task.deadline.check()
        whole = task.models[hypothesis.type].settled_when_found
        if whole and not _hopeful(task, hypothesis):
            continue
        better = _tilted(task, state, judge(task, state.accepted, hypothesis, 2), left)
        either = [better] if whole else [better, hypothesis]  # places alone may fit better and lose a match
        holds = next((h for h in either if refusal(task, state, h) is None), None)
        if holds is not None:
            return (*state.accepted, holds)
    return state.accepted


def chosen(task: Task, state: State, judged: Sequence[Hypothesis], choose: Choice) -> State:
    """The state with Δi chosen among what was judged, and made stable; what is accepted is no proposal any more."""
    among_all = choose(task, state, judged)
    new = [h for h in among_all if not any(h is old for old in state.accepted)]
    if not new and len(among_all) == len(state.accepted):
        return state
    held = tuple(accepted(h) if any(h is one for one in new) else h for h in among_all)
    state = replace(state, accepted=held, turns=state.turns + 1).tells(*map(acceptance, new))
    state = kept(task, state)
    return replace(state, proposals=tuple(p for p in state.proposals if not among(p.hypothesis, held)))


def _hopeful(task: Task, hypothesis: Hypothesis) -> bool:
    """Whether refinement may add to its evidence what it lacks."""
    return hypothesis.surplus >= task.models[hypothesis.type].significance(hypothesis) - POLISH


def _tilted(task: Task, state: State, hypothesis: Hypothesis, left: Data) -> Hypothesis:
    """The best of a hypothesis and of itself at other tilts: in one place it may fit in several ways."""
    search = task.search_for(hypothesis)
    if search is None or not _hopeful(task, hypothesis):
        return hypothesis
    data, model = free(task, state.accepted), task.models[hypothesis.type]
    poses = search.tilted(hypothesis, left)
    others = [model.settle(pose, task.data, task.kb, free=data, rounds=0) for pose in poses]
    return max([hypothesis, *(judge(task, state.accepted, other, 1) for other in others)], key=lambda h: h.worth)
