"""Choose Δi and make it stable (figure 1, §7).

Objects kept apart (A4), every ev taken anew beside the others, what no longer holds released.

Which hypotheses are accepted is one function of what was judged, and another can take its place.

The *weight* of Δi is the sum of the log-likelihood ratios of what it accepts, as the interpretation states them: ln of
how much likelier Γ is in its world than in the empty one. The cycle can be stopped between any two of its steps, and
the heaviest stable Δi so far is then the answer. Law: more time never makes its weight less. A cycle with more time
comes to the same ones first, in the same order.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import TypeAlias

from plogic.cycle.judging import judge, may_be_accepted, refusal, rounded, set_aside, surplus_beside
from plogic.cycle.state import Stable, State, Step, Task, among, free, step_of
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.judged.evidence import pose_information
from plogic.match.judged.rivals import (
    EVEN,
    SHARED_CLAIMS,
    apart_on_screen,
    contacts,
    hidden_among,
    in_the_way,
    moved_apart,
    shared_claims,
)

HEAVIER = 1e-6
"""By how much a glance must be heavier than what is kept: two that only rounding tells apart are the same, whether
there is a deadline or not."""


def kept(task: Task, state: State) -> State:
    """Make what is accepted now stable, and keep that if it is no lighter than what is kept."""
    found = stable(task, state.accepted)
    task.heaviest.keep(found)
    return replace(state, stable=found)


def glance(task: Task, state: State, found: Sequence[tuple[float, Hypothesis]]) -> None:
    """Where there is a deadline keep what Δi is with the best of some poses, if that is heavier than what is kept.

    So there is an answer before a round is over. What was kept at a glance before stays, where Δi is part of it.
    """
    if task.end is None or not found:
        return
    kept_so_far = task.heaviest.stable
    further = all(among(hypothesis, kept_so_far.accepted) for hypothesis in state.accepted)
    beside, steps = (kept_so_far.accepted, kept_so_far.steps) if further else (state.accepted, ())
    if sum(h.worth for h in beside) + found[0][0] <= kept_so_far.weight:
        return
    anew = bool(beside) or not task.models[found[0][1].type].settled_when_found
    proposed = judge(task, beside, found[0][1], 0, anew=anew)
    task.deadline.check()
    hypothesis = judge(task, beside, proposed, 2)
    if refusal(task, replace(state, accepted=beside), hypothesis) is None:
        with_it = stable(task, (*beside, accepted(hypothesis)), (*steps, acceptance(hypothesis)))
        if with_it.weight > task.heaviest.stable.weight + HEAVIER:
            task.heaviest.stable = with_it


def accepted(hypothesis: Hypothesis) -> Hypothesis:
    """The hypothesis with that verdict."""
    return hypothesis.told(status="accepted", why="explains its data better than chance, ev above 0")


def acceptance(hypothesis: Hypothesis) -> Step:
    """The step that accepts it."""
    return step_of("accept", f"log-likelihood ratio {hypothesis.worth:.1f}", hypothesis)


FALL = 10.0
"""Evidence, logarithms: in a dozen rings of planks the right way out cost 4.2 at most, the wrong one 29 or more."""


def stable(task: Task, of: tuple[Hypothesis, ...], steps: tuple[Step, ...] = ()) -> Stable:
    """What is left of these when they are kept apart (A4) and reconsidered.

    Where they explain less by more than ``FALL`` for that, pairs leave each other by the far side, if that is better.
    """
    start, through = Stable(of, of, (), steps), frozenset[tuple[int, int]]()
    best = reconsidered(task, separated(task, start))
    if sum(h.worth for h in of) - best.weight <= FALL:
        return best
    for contact in contacts(of, [h.camera_from_object for h in of]):
        pair = contact.first, contact.second
        other = reconsidered(task, separated(task, start, through | {pair}))
        if other.weight > best.weight:
            best, through = other, through | {pair}
    return best


def separated(task: Task, start: Stable, through: Collection[tuple[int, int]] = ()) -> Stable:
    """A4 to a millimetre: move apart, all together, what reaches into another.

    The pairs ``through``, by number, leave each other by the far side. Of two that cannot be moved apart, the one of
    less worth is rejected.
    """
    some, rejected, steps = list(start.accepted), list(start.rejected), list(start.steps)
    while True:
        task.deadline.check()
        far = through if len(some) == len(start.accepted) else ()
        poses, deep = moved_apart(some, lambda k: pose_information(some[k], task.data.camera, task.kb), through=far)
        if not deep:
            break
        worst = some.pop(min({k for pair in deep for k in pair}, key=lambda k: some[k].worth))
        rejected.append(worst.told(status="rejected", why="shares volume with an accepted object (A4)"))
        steps.append(Step("release", "no poses near keep it out of the others (A4); its data are released", worst.type))
    for k, (hypothesis, pose) in enumerate(zip(list(some), poses, strict=True)):
        if pose is not hypothesis.camera_from_object:
            others = [other for other in some if other is not hypothesis]
            hidden, left = hidden_among(hypothesis, others), free(task, others)
            moved = task.models[hypothesis.type].settle(pose, task.data, task.kb, free=left, hidden=hidden, rounds=0)
            some[k] = moved.told(**hypothesis.verdict(), **hypothesis.beyond())
            steps.append(Step("move", "a little, so that it does not reach into what it touches (A4)", hypothesis.type))
    return Stable(start.of, tuple(some), tuple(rejected), tuple(steps))


def reconsidered(task: Task, start: Stable) -> Stable:
    """Take every ev anew beside the others (reconsideration); drop what no longer holds, until Δi is stable.

    It only shrinks.
    """
    some, rejected, steps = list(start.accepted), list(start.rejected), list(start.steps)
    while True:
        again = []
        for k, hypothesis in enumerate(some):
            new = _again(task, hypothesis, [*some[:k], *some[k + 1 :]])
            again.append(new)
            why = f"ev {rounded(new.ev)} alone, {rounded(new.ev_reconsidered)} beside the others"
            steps.append(step_of("reconsider", why, new))
        some = again
        bad = [h for h in some if _fails(task, h, [other for other in some if other is not h])]
        if not bad:
            return Stable(start.of, tuple(some), tuple(rejected), tuple(steps))
        worst = min(bad, key=lambda h: (h.ev_reconsidered is not None, h.ev_reconsidered or -1.0))
        some = [h for h in some if h is not worst]
        why = "ev or evidence is not above 0 beside the others"
        rejected.append(worst.told(status="rejected", why=why))
        steps.append(Step("release", f"{why}; its data are released", worst.type))


def _fails(task: Task, hypothesis: Hypothesis, others: Sequence[Hypothesis]) -> bool:
    """Whether an accepted hypothesis, judged beside the others, does not hold.

    One whose pixels were looked at rests on them, and others may have them now: it is asked for all that it was
    accepted for.
    """
    if hypothesis.ev_reconsidered is None or hypothesis.ev_reconsidered <= 0.0 or hypothesis.worth <= 0.0:
        return True
    demanded = task.demanded(hypothesis)
    return hypothesis.pixels is not None and surplus_beside(hypothesis, others) <= demanded


def _again(task: Task, hypothesis: Hypothesis, others: Sequence[Hypothesis]) -> Hypothesis:
    """An accepted hypothesis judged beside the others; as before where the same stand near it."""
    near = [other for other in others if not apart_on_screen(hypothesis, other, *task.reach)]
    key = tuple(id(one) for one in (hypothesis, *near))
    if key not in task.remembered:
        task.deadline.check()
        new = judge(task, others, hypothesis, 0).told(status="accepted", why=hypothesis.why)
        task.remembered[key] = (hypothesis, *near), new
    return task.remembered[key][1]


def concluded(task: Task, state: State) -> State:
    """Δi is the heaviest stable one that there was; what was accepted else is rejected."""
    best = task.heaviest.stable
    kept_poses = [one.camera_from_object for one in (*best.of, *best.accepted)]
    lost = [h for h in state.accepted if not any(h.camera_from_object is pose for pose in kept_poses)]
    told = [h for h in best.rejected if not any(h is other for other in state.rejected)]
    state = replace(state, accepted=best.accepted, rejected=(*state.rejected, *told)).tells(*best.steps)
    for hypothesis in lost:
        why = "a pose nearby explains more" if among(hypothesis, best.accepted) else "Δi explains more without it"
        why = "the deadline came first" if task.deadline.passed else why
        state = replace(state, rejected=(*state.rejected, hypothesis.told(status="rejected", why=why)))
        state = state.tells(Step("release", f"{why}; its data are released", hypothesis.type))
    return state


def exchanged(task: Task, state: State) -> State:
    """The state with the best rival in Δi, if Δi is heavier so by more than chance is worth.

    It stands beside the others, where all can be moved apart (A4), or in the place of what it excludes: what was
    accepted first may stand in the way of what explains more.
    """
    for rival in sorted(state.rivals, key=lambda h: -h.worth):
        excluded = [h for h in state.accepted if in_the_way(rival, h)]
        enough = state.stable.weight + task.demanded(rival)
        by_volume = all(shared_claims(rival, h)[1] <= SHARED_CLAIMS for h in excluded)
        for lost in ([], excluded) if by_volume and excluded else (excluded,):
            if state.stable.weight + rival.worth - sum(h.worth for h in lost) <= enough:
                continue
            task.deadline.check()
            others = (h for h in state.accepted if not any(h is one for one in lost))
            found = stable(task, (*others, accepted(rival)), (acceptance(rival),))
            if found.weight > enough:
                task.heaviest.keep(found)
                rivals = tuple(h for h in state.rivals if h is not rival)
                state = replace(state, accepted=found.of, stable=found, rivals=rivals, turns=state.turns + 1)
                for one in lost:
                    state = set_aside(task, state, one, "Δi explains more with another in its place")
                return state
    return state


POLISHED = 6
"""Poses of a round that are refined beside Δi before they are accepted or not, the best first."""
POLISH = 10.0
"""What refinement beside Δi may add to the evidence of a type that was refined when it was found: one that lacks more
is not refined."""

Choice: TypeAlias = Callable[[Task, State, Sequence[Hypothesis]], tuple[Hypothesis, ...]]
"""Of the state and of judged hypotheses, those that make up Δi from now on.

Those of ``State.accepted``, where nothing changes.
"""


def best_first(task: Task, state: State, judged: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Δi with the best of the judged that is acceptable, refined beside Δi."""
    left = task.data.only(free(task, state.accepted))
    for hypothesis in sorted(judged, key=lambda h: -round(h.worth, EVEN))[:POLISHED]:
        task.deadline.check()
        whole = task.models[hypothesis.type].settled_when_found
        if whole and not _hopeful(task, hypothesis):
            continue
        better = _tilted(task, state, judge(task, state.accepted, hypothesis, 2), left)
        either = [better] if whole else [better, hypothesis]  # places alone may fit better and lose a match
        holds = next((h for h in either if may_be_accepted(task, state, h)), None)
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
    return hypothesis.surplus >= task.demanded(hypothesis) - POLISH


def _tilted(task: Task, state: State, hypothesis: Hypothesis, left: Data) -> Hypothesis:
    """The best of a hypothesis and of itself at other tilts: in one place it may fit in several ways."""
    search = task.search_for(hypothesis)
    if search is None or not _hopeful(task, hypothesis):
        return hypothesis
    data, model = free(task, state.accepted), task.models[hypothesis.type]
    poses = search.tilted(hypothesis, left)
    others = [model.settle(pose, task.data, task.kb, free=data, rounds=0) for pose in poses]
    return max([hypothesis, *(judge(task, state.accepted, other, 1) for other in others)], key=lambda h: h.worth)
