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

import numpy as np

from geometry.arrays import Floats, Mask
from kb.clouds.cloud import KnowledgeBase
from plogic.base.clock import OutOfTimeError
from plogic.cycle.choosing import Choice, acceptance, accepted, best_first, chosen, concluded, exchanged, glance, kept
from plogic.cycle.judging import (
    compared,
    judge,
    judged,
    left_over,
    making_way,
    may_be_accepted,
    may_replace,
    refusal,
    set_aside,
    sure,
)
from plogic.cycle.state import (
    JUDGING,
    Attention,
    Cycle,
    State,
    Step,
    Task,
    Trace,
    among,
    considered,
    free,
    of_types,
    step_of,
)
from plogic.cycle.support import leaning, settled_down, standing
from plogic.facts.caveats import UNWEIGHED
from plogic.facts.hypothesis import Hypothesis
from plogic.match.judged.rivals import EVEN, claims, hidden_among
from plogic.match.judged.type_models import Given, TypeModel

TELLING = 0.2
"""By how much a rank must exceed what clutter alone would give to tell anything: of 20 features or more, twice what
chance varies it by. What is there of 100 types known by places comes 2nd, 5th and 2nd in the median where 10, 30 and
100 appearance types are told apart, by rank alone 26th, 15th and 2nd (``plogic bench attention``)."""


def attend(
    models: Iterable[TypeModel], types: Sequence[str], kb: KnowledgeBase, votes: Mapping[str, float] | None = None
) -> list[Attention]:
    """All types, the most promising first: by rank, where it tells more than clutter would, and by votes, where known.

    Then by rank again, excess over chance, rank within one neighbourhood, and name. ``votes`` of types: how well at
    best some pose of it is voted for, a rank within the neighbourhood that this pose shows.
    """
    here, by_chance = Counter(types), Counter(chance_types(kb, len(types)))
    ranks = {model.object_type.name: model.ranks(here, by_chance) for model in models}
    rows = [
        Attention(name, row.rank, row.rank - row.by_chance, row.within_cell, (votes or {}).get(name, 0.0))
        for name, row in ranks.items()
    ]
    return sorted(rows, key=_turn)


def _turn(row: Attention) -> tuple[float | str, ...]:
    """What sorts the types."""
    rank, excess = round(row.rank, 9), round(row.excess, 9)
    return -rank * (excess > TELLING), -round(row.vote, 6), -rank, -excess, -round(row.within_cell, 9), row.type


def attended(task: Task) -> list[Attention]:
    """All types in the order in which they are tried in Γ: each search has voted for its types."""
    votes = {name: vote for _, search in task.searches for name, vote in search.votes().items()}
    return attend(task.models.values(), task.data.types, task.kb, votes)


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


def more_to_see(task: Task, state: State, unheld: Sequence[Hypothesis], usual: Mapping[str, int]) -> tuple[State, bool]:
    """Whether to search: not where what is remembered was found, and explains all but clutter, or what is ``usual``.

    What was not found where it is remembered may stand a little beside, as far as one view leaves its distance open.
    """
    if not state.accepted:
        return state, True
    if unheld:
        away = ", ".join(sorted({hypothesis.type for hypothesis in unheld}))
        return state.tells(Step("search", f"not found where it is remembered: {away}")), True
    with suppress(OutOfTimeError):  # what is remembered is accepted only when it is stable here
        state = kept(task, state)
    why = unexplained([task.data.types[i] for i in free(task, state.accepted).nonzero()[0]], task.kb, usual)
    if why is not None:
        return state.tells(Step("search", why)), True
    task.searches.clear()
    return state.tells(Step("no search", "what is left is no more than clutter")), False


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
    attention: Sequence[Attention] | None = None,
    seeds: Sequence[Seed] = (),
    usual: Mapping[str, int] | None = None,
    choose: Choice = best_first,
) -> Cycle:
    """Run the cycle over one Γ until nothing is acceptable, or the time is over.

    Each time Δi is made stable; the heaviest one of these is the answer, at the end or when the deadline comes.
    ``attention``: in which order types are tried, by default that of their ranks and votes (``attended``). ``seeds``
    are what is remembered, the surest first: of these is accepted what holds here, and more is searched for only where
    what is left is more than clutter, or than ``usual``.
    """
    state, unheld = recalled(task, State(), seeds)
    state, searching = more_to_see(task, state, unheld, usual or {})
    last, known = state, attention or attend(task.models.values(), task.data.types, task.kb)
    with suppress(OutOfTimeError):
        if searching:
            known = attention or attended(task)
            ranked = [Step("rank", f"rank {r.rank:.2f}, {r.excess:+.2f} against chance", r.type) for r in known]
            state = last = replace(state, attention=tuple(known)).tells(*ranked)
        for after in rounds(task, state, choose):
            last = after
    return _outcome(task, left_over(sure(task, settled_down(task, concluded(task, last)))), unheld, known)


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
    """Accept earlier proposals that can be accepted, before more is searched for."""
    yield (state := judged(task, state))
    proposed = [proposal.hypothesis for proposal in state.proposals]
    yield chosen(task, state, [h for h in proposed if may_be_accepted(task, state, h)], choose)


def match_and_choose(task: Task, state: State, choose: Choice) -> Iterator[State]:
    """Match: distinctive data that are free afford hypotheses of types. Judge them beside Δi, and choose.

    The types are asked in waves, in the order of attention, until something of one is accepted.
    """
    for wave in waves(task, state):
        old, turns = {id(proposal.hypothesis) for proposal in state.proposals}, state.turns
        yield (state := leaning(task, judged(task, matched(task, state, wave))))
        best = sorted(state.proposals, key=lambda p: -round(p.hypothesis.worth, EVEN))
        most = max(POOL, POOL_OF_TYPE * len(task.models))
        kept, spared = best[:most], may_replace(task, state, best[most:])
        state = replace(state, proposals=(*kept, *spared))
        new = [proposal.hypothesis for proposal in best if id(proposal.hypothesis) not in old]
        yield (state := chosen(task, state, new, choose))
        if state.turns > turns:
            return


def waves(task: Task, state: State) -> Iterator[dict[str, Mask]]:
    """The types to search for now, so many at a time as their search takes together, each with the data (A,) for it.

    Those come first that were not tried yet, then those that were before Δi changed; both in the order of attention.
    """
    trying = worth_trying(task, state)
    due = [row.type for row in state.attention if row.type in trying and state.tried.get(row.type) != state.turns]
    wave: dict[str, Mask] = {}
    for name in sorted(due, key=lambda name: name in state.tried):
        wave[name] = trying[name]
        if any(len(models.keys() & wave.keys()) == search.at_once for models, search in task.searches):
            yield wave
            wave = {}
    if wave:
        yield wave


NEARLY = 0.5
"""Share of the votes of an accepted hypothesis's type that one needs whose hypothesis may take its place."""


def worth_trying(task: Task, state: State) -> dict[str, Mask]:
    """The types that could explain data better than what stands does, each with these data (A,).

    Of what is left all that it votes for; and, of a type that was not tried yet, what is claimed by one of a type of
    its kind that has not many more votes.
    """
    left = free(task, state.accepted)
    given, data, found = _given(task, state, []), task.data.only(left), dict[str, Mask]()
    votes = {row.type: row.vote for row in state.attention}
    for models, search in task.searches:
        names = [name for name in votes if name in models]
        found |= dict.fromkeys(search.promising(names, data, given), left)
        for held in (some for some in state.accepted if some.type in models):
            with_it = left.copy()
            with_it[list(claims(held))] = True
            for name in names:
                if name not in state.tried and name != held.type and votes[name] > NEARLY * votes.get(held.type, 0.0):
                    found[name] = found.get(name, left) | with_it
    return found


def stand_on_planes(task: Task, state: State, _: Choice) -> Iterator[State]:
    """Propose what may stand on likely planes, where things rest and more were accepted since."""
    if task.kb.rests is None or state.stood_on == len(state.accepted):
        return
    state = leaning(task, state)
    found, said = standing(task, state, task.data.only(free(task, state.accepted)), _given(task, state, []))
    state = replace(state.proposes(found), stood_on=len(state.accepted), turns=state.turns + bool(found))
    yield leaning(task, judged(task, state)).tells(*(Step("support", why) for why in said))


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
            stood_on=-1,
            turns=state.turns + 1,
        ).tells(*state.stable.steps)
        yield kept(task, state)


def matched(task: Task, state: State, wave: Mapping[str, Mask]) -> State:
    """The state with the proposals of some types that their data (A,) afford, in their order."""
    found, said = [], list[str]()
    given = _given(task, state, said)
    with ExitStack() as stack:
        proposals = {}
        for models, search in task.searches:
            names = [name for name in wave if name in models]
            data = task.data.only(np.any([wave[name] for name in names], axis=0)) if names else task.data
            some = stack.enter_context(closing(search.propose(names, data, given)))
            proposals.update(dict.fromkeys(names, some))
        for number, name in enumerate(wave):
            task.deadline.check()
            task.at(of_types(number, len(wave)))
            found += [hypothesis for _, hypothesis in next(proposals[name])]
    task.at(JUDGING)
    state = replace(state, tried={**state.tried, **dict.fromkeys(wave, state.turns)})
    return state.proposes(found).tells(*(Step("deepen", why) for why in said))


def _outcome(task: Task, state: State, unheld: Sequence[Hypothesis], attention: Sequence[Attention]) -> Cycle:
    """What the run came to: Δi, the rivals that it has, and what is remembered and did not hold, told from them."""
    noise = int(free(task, state.accepted).sum())
    state = state.tells(Step("stable", f"{len(state.accepted)} accepted; {noise} appearances left as noise"))
    weighed = considered(state.rivals, state.accepted)
    beyond = [h for h in state.rivals if not among(h, [*weighed, *state.accepted])]
    state = replace(state, rejected=(*state.rejected, *(h.told(status="unweighed", why=UNWEIGHED) for h in beyond)))
    state, rivals = making_way(task, state, weighed)
    told = len(state.rivals)
    for hypothesis in unheld:
        if not among(hypothesis, state.accepted):
            state = set_aside(task, state, hypothesis, f"remembered here, but: {hypothesis.why}")
    state, more = making_way(task, state, state.rivals[told:])
    late = task.deadline.passed
    if late:
        state = state.tells(Step("deadline", "the deadline was reached: the search is unfinished"))
    rest, trace = (*rivals, *more), Trace(list(state.steps))
    known = tuple(attention)
    return Cycle(state.accepted, rest, state.rejected, known, trace, unfinished=late, supported=state.supported)


def _given(task: Task, state: State, said: list[str]) -> Given:
    """What searches are given besides the free data; what they tell is ``said``."""
    return Given(
        state.accepted,
        lambda hypothesis: hidden_among(hypothesis, state.accepted),
        lambda found: glance(task, state, found),
        said.append,
    )
