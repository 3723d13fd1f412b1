"""Begin with what is remembered: what Δp says should be here is looked at first, and a search is made only for what it leaves (§1, §7).

* ``Seed``: a type and the pose that it is expected at, ``Seed(of, camera_from_object)``
"""

from __future__ import annotations

from collections import Counter
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from plogic.base.clock import OutOfTimeError
from plogic.cycle.judging import judge, refusal
from plogic.cycle.stability import acceptance, accepted, kept
from plogic.cycle.state import State, Step, Task, free, step_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from geometry.arrays import Floats
    from kb.clouds.cloud import KnowledgeBase
    from plogic.cycle.attention import Attention
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.judged.type_models import TypeModel

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
        if why is not None:
            unheld.append(hypothesis.told(why=why))
            continue
        state = replace(state, accepted=(*state.accepted, accepted(hypothesis)))
        state = state.tells(step_of("recall", "stands where it is remembered", hypothesis), acceptance(hypothesis))
    return state, unheld


def more_to_see(
    task: Task, state: State, attention: Sequence[Attention], usual: Mapping[str, int]
) -> tuple[State, tuple[Attention, ...]]:
    """The types to search for: all, but none where what is remembered explains all but clutter, or what is ``usual``."""
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
