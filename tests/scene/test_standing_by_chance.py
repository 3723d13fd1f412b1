"""What is not there may stand all the same (formalism §9.9): standing is worth the less, the more often that is so.

That stock ProbLog and the definition agree with it is tested with all else of support, of which half has it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from lone_standing import by_chance, lone, on_plane, worlds_of
from situations import random_situations, with_support
from stock_worlds import evaluated

from plogic.scene.asking.live import scene_answers
from plogic.scene.text.program_text import program_text

QUICK = settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    phases=(Phase.explicit, Phase.generate),
    suppress_health_check=list(HealthCheck),
)
SEEDS = st.integers(0, 9999)


pytestmark = pytest.mark.usefixtures("served_here")


ANSWERED = {"present": "", "free": "", "held": "", "stands_on": ", S", "stance": ", S, R"}


@QUICK
@given(random_situations(most=4, readings=("posterior",)), SEEDS)
def test_whose_pose_stands_either_way_is_no_likelier_by_it(subject, seed):
    """Where nobody may stand on another, whose presence would tell of that, and none excludes another."""
    subject = replace(subject, overlaps=frozenset(), exclusive=frozenset())
    told = with_support(subject, seed)
    ids = {h.id for h in subject.hypotheses}
    support = replace(told.support, rests=min(told.support.rests, 0.9))  # some world is left in each state
    stances = tuple(replace(s, chance=0.9 * s.chance) for s in support.stances if s.on not in ids)
    told = by_chance(replace(told, support=replace(support, stances=stances)), 1.0)
    assert worlds_of(told) == pytest.approx(worlds_of(subject), abs=1e-9)


@pytest.mark.parametrize("pairs", ["overlaps", "exclusive"])
@QUICK
@given(st.integers(2, 5), st.sampled_from([0.0, 0.03, 0.12, 0.5, 1.0]), st.floats(-9.0, 12.0))
def test_of_those_that_exclude_each_other_none_gains_by_whose_chance_is_told(pairs, count, e, ratio):
    """One find, with as many readings: they are as probable as each other, and it may stand by chance once."""
    names, alone = [f"h{i}" for i in range(count)], on_plane(ratio)
    stances = tuple(replace(s, hypothesis=name) for s in alone.stances for name in names)
    apart = frozenset((x, y) for x in names for y in names if x < y)
    subject = lone(*names, support=replace(alone, stances=stances, by_chance=(("h0", e),)))
    subject = replace(subject, **{"rivals": apart, pairs: apart})
    before, after = worlds_of(replace(subject, support=None)), worlds_of(subject)
    f = 0.1 + 0.9 * math.exp(ratio)
    odds = [(after[(name,)] / after[()]) / (before[(name,)] / before[()]) for name in names]
    assert odds == pytest.approx([f / (1.0 - e + e * f)] * count)


@QUICK
@given(random_situations(most=4), SEEDS)
def test_by_chance_at_no_chance_is_nothing(subject, seed):
    told = with_support(subject, seed)
    assert worlds_of(by_chance(told, 0.0)) == worlds_of(replace(told, support=replace(told.support, by_chance=())))


@QUICK
@given(random_situations(most=4), SEEDS)
def test_who_stands_or_is_free_is_present(subject, seed):
    told = with_support(subject, seed)
    assert told.hypotheses
    if worlds_of(told):
        for h in told.hypotheses:
            there, *answers = scene_answers(told, [f"{goal}({h.id}{rest})" for goal, rest in ANSWERED.items()])
            assert max((a.probability for some in answers for a in some), default=0.0) <= there[0].probability + 1e-9


@pytest.mark.parametrize("e", [0.0, 0.12, 0.5, 1.0])
@pytest.mark.parametrize("ratio", [-9.0, 0.0, 2.0, 9.0])
def test_standing_is_worth_less_the_more_stands_by_chance(e, ratio):
    subject, f = by_chance(lone("h1", support=on_plane(ratio)), e), 0.1 + 0.9 * math.exp(ratio)
    before, after = worlds_of(lone("h1")), worlds_of(subject)
    odds = (after[("h1",)] / after[()]) / (before[("h1",)] / before[()])
    assert odds == pytest.approx(f / (1.0 - e + e * f))
    if e > 0.0:
        (told,) = evaluated(program_text(subject) + "query(by_chance(h1)).\n").values()
        absent = after[()] * e * f / (1.0 - e + e * f)
        assert told == pytest.approx(after[("h1",)] * e + absent, abs=1e-9)
