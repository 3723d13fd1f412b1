"""The perceptual cycle (figure 1, §7): attend, match, judge, choose, release; until Γ has a coherent explanation.

Types are tried in the order of attention (§5.3, §7): rank saturates in clutter, so ties go by the excess over chance,
then by the rank within one lobe-consistent neighbourhood. Where something is remembered, Δp, it is looked at first, and
a search is made only for what it leaves (§1, §7).

* ``Seed``: a type and the pose that it is expected at, ``Seed(of, camera_from_object)``
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import replace
from typing import NamedTuple

from geometry.arrays import Floats
from kb.clouds.cloud import KnowledgeBase
from plogic.base.clock import OutOfTimeError
from plogic.cycle.choosing import Choice, acceptance, accepted, best_first, chosen, concluded, exchanged, glance, kept
from plogic.cycle.judging import compared, judge, judged, left_over, making_way, refusal, set_aside
from plogic.cycle.state import Attention, Cycle, State, Step, Task, Trace, among, considered, free, step_of
from plogic.cycle.support import supported
from plogic.facts.hypothesis import Hypothesis
from plogic.match.judged.rivals import hidden_among
from plogic.match.judged.type_models import Given, TypeModel


def attend(models: Iterable[TypeModel], types: Sequence[str], kb: KnowledgeBase) -> list[Attention]:
    """All types, the most promising first: by rank, then excess, then rank within one neighbourhood, then name."""
    here, by_chance = Counter(types), Counter(chance_types(kb, len(types)))
    ranks = {model.object_type.name: model.ranks(here, by_chance) for model in models}
    rows = [Attention(name, row.rank, row.rank - row.by_chance, row.within_cell) for name, row in ranks.items()]
    return sorted(
        rows, key=lambda row: (-round(row.rank, 9), -round(row.excess, 9), -round(row.within_cell, 9), row.type)
    )


def chance_types(kb: KnowledgeBase, number: int) -> list[str]:
    """What ``number`` appearances of clutter alone would be.

    Each type in proportion to its clutter rate, rounded down.
    """
    rates = {name: kb.rates.clutter.get(name, 1.0) for name in kb.appearance_types}
    total = sum(rates.values()) or 1.0
    return [name for name, rate in rates.items() for _ in range(int(number * rate / total))]


RARE = 0.001
"""Data that nobody explains are searched where clutter alone gives so many, of a type or of all, in less than this
share of images."""


class Seed(NamedTuple):
    """A type, by its index, and ``camera_from_object`` (4, 4), where it is expected."""

    of: TypeModel
    camera_from_object: Floats


def recalled(task: Task, state: State, seeds: Sequence[Seed]) -> tuple[State, list[Hypothesis]]:
    """Accept of the seeds, in their order, what holds here; and those that do not, each with the reason why."""
    unheld = []
    for seed in seeds:
        left = free(task, state.accepted)
        proposed = seed.of.settle(seed.camera_from_object, task.data, task.kb, free=left, rounds=0)
        hypothesis = judge(task, state.accepted, proposed, 2)
        why = refusal(task, state, hypothesis)
        if why is None:
            stands = step_of("recall", "stands where it is remembered", hypothesis)
            state = replace(state, accepted=(*state.accepted, accepted(hypothesis)))
            state = state.tells(stands, acceptance(hypothesis))
        else:
            unheld.append(hypothesis.told(why=why))
    return state, unheld


def more_to_see(
    task: Task, state: State, attention: Sequence[Attention], usual: Mapping[str, int]
) -> tuple[State, tuple[Attention, ...]]:
    """The types to search for: all, or none where what is remembered, or ``usual``, explains all but clutter."""
    if not state.accepted:
        return state, tuple(attention)
    with suppress(OutOfTimeError):  # what is remembered is accepted only when it is stable here
        state = kept(task, state)
    why = unexplained([task.data.types[i] for i in free(task, state.accepted).nonzero()[0]], task.kb, usual)
    if why is not None:
        return state.tells(Step("search", why)), tuple(attention)
    task.searches.clear()
    return state.tells(Step("no search", "what is left is no more than clutter")), ()


def unexplained(types: Sequence[str], kb: KnowledgeBase, usual: Mapping[str, int]) -> str | None:
    """Of what data of these ``types`` there are more than clutter gives, in words; None where there are no more.

    ``usual``: how many of each type were left where a search found no more: where that is above the KB's clutter rate,
    this place has so much.
    """
    from scipy.stats import poisson

    rates = {name: kb.rates.clutter.get(name, 1.0) for name in kb.appearance_types}
    most = max(sum(rates.values()), sum(usual.values()))
    if poisson.sf(len(types) - 1, most) < RARE:
        return f"{len(types)} data are left, where clutter gives {most:.0f}"
    for name, number in sorted(Counter(types).items()):
        expected = max(rates.get(name, 1.0), usual.get(name, 0))
        if poisson.sf(number - 1, expected) < RARE / len(rates):
            return f"{number} of {name} are left, where clutter gives {expected:.1f}"
    return None


POOL = 10
"""Proposals that are judged again in the next round, the best."""
POOL_OF_TYPE = 3
"""... and so many for each type of the knowledge base, where these are more."""


def perceive(
    task: Task,
    attention: Sequence[Attention],
    seeds: Sequence[Seed] = (),
    usual: Mapping[str, int] | None = None,
    choose: Choice = best_first,
) -> Cycle:
    """Run the cycle over one Γ until nothing is acceptable, or the time is over.

    Each time Δi is made stable; the heaviest one of these is the answer, at the end or when the deadline comes.
    ``seeds`` are what is remembered, the surest first: of these is accepted what holds here, and more is searched for
    only where what is left is more than clutter, or than ``usual``.
    """
    state, unheld = recalled(task, State(), seeds)
    state, attended = more_to_see(task, state, attention, usual or {})
    ranked = [Step("rank", f"rank {r.rank:.2f}, {r.excess:+.2f} against chance", r.type) for r in attended]
    state = last = replace(state, attention=attended).tells(*ranked)
    with suppress(OutOfTimeError):
        for after in rounds(task, state, choose):
            last = after
    return _outcome(task, left_over(concluded(task, last)), unheld, attention)


def rounds(task: Task, state: State, choose: Choice = best_first) -> Iterator[State]:
    """Figure 1. Yield every state, so that the last one stands whenever the time is over.

    A round begins again as soon as something was accepted, or there is more to judge. Every round but the last claims
    data, or comes after one in which something was released for good, so that the cycle ends on every finite Γ.
    """
    turns = -1
    while turns < state.turns:
        turns = state.turns
        for step in (choose_of_before, match_and_choose, stand_on_planes, deepen, release):
            for after in step(task, state, choose):
                yield (state := after)
            if turns < state.turns:
                break
    for after in compared(task, state):
        yield (state := after)
    turns, state = state.turns, exchanged(task, state)
    yield state
    if turns < state.turns:
        yield from rounds(task, state, choose)


def choose_of_before(task: Task, state: State, choose: Choice) -> Iterator[State]:
    """Accept earlier proposals that can be accepted, of types whose search would rather keep one than search again."""
    yield (state := judged(task, state))
    proposed = [proposal.hypothesis for proposal in state.proposals]
    ready = [h for h in proposed if _keeps(task, h) and refusal(task, state, h) is None]
    yield chosen(task, state, ready, choose)


def match_and_choose(task: Task, state: State, choose: Choice) -> Iterator[State]:
    """Match: distinctive data that are free afford hypotheses of all types. Judge them beside Δi, and choose."""
    yield (state := judged(task, matched(task, state)))
    best = sorted(state.proposals, key=lambda p: -p.hypothesis.worth)
    most = max(POOL, POOL_OF_TYPE * len(task.models))
    passed = tuple(proposal.hypothesis.bare() for proposal in best[most:])
    state = replace(state, proposals=tuple(best[:most]), passed=(*state.passed, *passed))
    yield chosen(task, state, [proposal.hypothesis for proposal in best], choose)


def stand_on_planes(task: Task, state: State, _: Choice) -> Iterator[State]:
    """Propose what may stand where accepted objects do, where gravity holds and more were accepted since."""
    if not task.kb.gravity or state.stood_on == len(state.accepted):
        return
    given, left = _given(task, state, []), task.data.only(free(task, state.accepted))
    found, why = supported(state.accepted, task.models, left, given, task.request)
    state = replace(state.proposes(found), stood_on=len(state.accepted), turns=state.turns + bool(found))
    yield state if why is None else state.tells(Step("support", why))


def deepen(task: Task, state: State, _: Choice) -> Iterator[State]:
    """Search further the next time, for the types that can be."""
    left = task.data.only(free(task, state.accepted))
    reasons = [search.deepen(left, accepted=bool(state.accepted)) for _, search in task.searches]
    steps = [Step("deepen", why) for why in reasons if why is not None]
    yield replace(state, turns=state.turns + bool(steps)).tells(*steps)


def release(task: Task, state: State, _: Choice) -> Iterator[State]:
    """Drop from Δi, for good, what does not hold in it when it is stable: its data are free again."""
    lost = state.stable.rejected
    if lost:
        state = replace(
            state,
            accepted=state.stable.accepted,
            rejected=(*state.rejected, *lost),
            refused=(*state.refused, *lost),
            proposals=tuple(proposal._replace(beside=None) for proposal in state.proposals),
            stood_on=0,
            turns=state.turns + 1,
        ).tells(*state.stable.steps)
        yield kept(task, state)


def matched(task: Task, state: State) -> State:
    """The state with the proposals of all types that the free data afford, in the order of attention."""
    left, found, said = task.data.only(free(task, state.accepted)), [], list[str]()
    given = _given(task, state, said)
    with ExitStack() as stack:
        proposals = {}
        for models, search in task.searches:
            names = [row.type for row in state.attention if row.type in models]
            some = stack.enter_context(closing(search.propose(names, left, given)))
            proposals.update(dict.fromkeys(names, some))
        for row in state.attention:
            task.deadline.check()
            found += [hypothesis for _, hypothesis in next(proposals[row.type])]
    return state.proposes(found).tells(*(Step("deepen", why) for why in said))


def _outcome(task: Task, state: State, unheld: Sequence[Hypothesis], attention: Sequence[Attention]) -> Cycle:
    """What the run came to: Δi, the rivals that it has, and what is remembered and did not hold, told from them."""
    noise = int(free(task, state.accepted).sum())
    state = state.tells(Step("stable", f"{len(state.accepted)} accepted; {noise} appearances left as noise"))
    state, rivals = making_way(task, state, considered(state.rivals, state.accepted))
    told = len(state.rivals)
    for hypothesis in unheld:
        if not among(hypothesis, state.accepted):
            state = set_aside(task, state, hypothesis, f"remembered here, but: {hypothesis.why}")
    state, more = making_way(task, state, state.rivals[told:])
    late = task.deadline.passed
    if late:
        state = state.tells(Step("deadline", "the deadline was reached: the search is unfinished"))
    rest, trace = (*rivals, *more), Trace(list(state.steps))
    return Cycle(state.accepted, rest, state.rejected, tuple(attention), trace, unfinished=late)


def _given(task: Task, state: State, said: list[str]) -> Given:
    """What searches are given besides the free data; what they tell is ``said``."""
    return Given(
        state.accepted,
        lambda hypothesis: hidden_among(hypothesis, state.accepted),
        lambda found: glance(task, state, found),
        said.append,
    )


def _keeps(task: Task, hypothesis: Hypothesis) -> bool:
    """Whether it is accepted, if it can be, before more is searched for."""
    search = task.search_for(hypothesis)
    return search is not None and search.keeps
