"""What things stand on (formalism §9.9).

The factor graph is stock ProbLog's on the program text, and every world's weight by hand; its laws.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from enumeration import log_weights
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from lone_standing import by_chance, lone, on_plane, worlds_of
from situations import plane, random_situations, with_gravity, with_pixels, with_support
from stock_worlds import evaluated

from plogic.base.errors import InconsistentError, SituationError
from plogic.facts.situation import names_of
from plogic.facts.stances import Stance, Support
from plogic.scene.asking.live import LiveScene, scene_answers
from plogic.scene.asking.relevant import relevant
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds

QUICK = settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    phases=(Phase.explicit, Phase.generate),
    suppress_health_check=list(HealthCheck),
)
SEEDS = st.integers(0, 9999)


pytestmark = pytest.mark.usefixtures("served_here")


def stock(subject, goals):
    """What stock ProbLog says of goals, possible answers alone."""
    from plogic.logic.safety.mapping import shown

    text = "".join([program_text(subject), *(f"query({goal}).\n" for goal in goals)])
    return {shown(term, names_of(subject)): p for term, p in evaluated(text).items() if p > 0}


def by_hand(subject):
    """Each world and its probability, from the definition; {} where none is possible."""
    logs, ids = log_weights(subject), [h.id for h in subject.hypotheses]
    total = np.logaddexp.reduce(logs)
    rows = {tuple(h for bit, h in enumerate(ids) if i >> bit & 1): x for i, x in enumerate(logs) if x > -np.inf}
    return {world: math.exp(x - total) for world, x in rows.items()}


GOALS = "present(X)", "support_plane(S)", "stance(H, S, R)", "stands_on(H, S)", "rests_on(H, X)", "held(H)", "free(H)"


def assert_same_answers(subject, goals):
    """Stock ProbLog's answers to goals are the factor graph's, or neither knows a possible world."""
    from problog.errors import InconsistentEvidenceError

    try:
        theirs = stock(subject, goals)
    except InconsistentEvidenceError:
        with pytest.raises(InconsistentError):
            ranked_worlds(subject)
        return
    ours = {answer.goal: answer.probability for answers in scene_answers(subject, goals) for answer in answers}
    both = dict.fromkeys([*ours, *theirs], 0.0)
    assert both | ours == pytest.approx(both | theirs, abs=1e-9)


@pytest.mark.parametrize("reading", ["score", "posterior"])
@settings(QUICK, max_examples=200)
@given(random_situations(most=4), SEEDS)
def test_two_hundred_situations_equal_problog(reading, subject, seed):
    assert_same_answers(with_support(replace(subject, reading=reading), seed), GOALS)


@QUICK
@given(random_situations(most=3), SEEDS)
def test_gravity_and_support_together_equal_problog(subject, seed):
    """What floats and needs an excuse is what touches nothing; what is held may stand on a plane."""
    subject = with_gravity(with_support(subject, seed), seed)
    assert_same_answers(subject, ("present(X)", "floats(H)", "held(H)", "rests_on(H, X)"))
    assert worlds_of(subject) == pytest.approx(by_hand(subject), abs=1e-9)


RULES = (
    "constraint(nothing_hovers) :- free(H).",
    "evidence(steady).\nsteady :- stands_on(H, S).\nsteady :- \\+ present(h1).",
    "0.3::constraint_may_fail(same_plane).\nconstraint(same_plane) :- support_plane(s2).",
    "0.7::wobbly(H) :- rests_on(H, X), X \\= ground.\nconstraint(calm) :- wobbly(H), stance(H, _, 0).",
)


@pytest.mark.parametrize("rules", RULES)
@settings(QUICK, max_examples=15)
@given(random_situations(most=3), SEEDS)
def test_rules_of_the_author_speak_of_it_as_in_problog(rules, subject, seed):
    assert_same_answers(
        replace(with_support(subject, seed), rules=rules), ("present(X)", "support_plane(S)", "free(H)")
    )


@settings(QUICK, max_examples=150)
@given(random_situations(most=6), SEEDS)
def test_worlds_are_those_of_the_definition(subject, seed):
    subject = with_support(subject, seed)
    assert worlds_of(subject) == pytest.approx(by_hand(subject), abs=1e-9)


@QUICK
@given(random_situations(most=5, readings=("posterior",)), SEEDS)
def test_the_evidence_weighs_what_the_definition_says(subject, seed):
    subject = with_pixels(with_support(subject, seed), seed)
    if worlds_of(subject):
        whole = float(np.logaddexp.reduce(log_weights(subject)))
        assert ranked_worlds(subject).log_evidence == pytest.approx(whole, abs=1e-6)


@QUICK
@given(random_situations(most=5, readings=("score",)), SEEDS)
def test_in_the_score_reading_nobody_is_more_or_less_probable(subject, seed):
    told = with_support(subject, seed)
    assert worlds_of(told) == worlds_of(subject)
    if worlds_of(told):
        planes = {p.name: p.prior for p in told.support.planes if p.prior > 0.0}
        found = {a.goal: a.probability for a in scene_answers(told, ["support_plane(S)"])[0]}
        assert found == pytest.approx({f"support_plane({name})": p for name, p in planes.items()})


@QUICK
@given(random_situations(most=5), SEEDS)
def test_how_many_there_are_is_counted_with_it(subject, seed):
    subject = with_support(subject, seed)
    if worlds := by_hand(subject):
        found = {a.goal: a.probability for a in scene_answers(subject, ["number_of_objects(N)"])[0]}
        numbers = {len(world) for world in worlds}
        expected = {n: sum(p for world, p in worlds.items() if len(world) == n) for n in numbers}
        assert found == pytest.approx({f"number_of_objects({n})": p for n, p in expected.items() if p > 0}, abs=1e-9)


NOTHING_SAID = Support(0.9, 1.0, (plane("s1", 0.0),), (Stance("h1", "s1", 0, 0.9, 5.0),))
NOTHING_RESTS = Support(0.0, 0.1, (plane("s1", 0.6),), ())


@QUICK
@given(random_situations(most=5), st.sampled_from([NOTHING_SAID, NOTHING_RESTS]))
def test_where_nothing_says_it_or_nothing_rests_nothing_changes(subject, support):
    assert worlds_of(replace(subject, support=support)) == pytest.approx(worlds_of(subject), abs=1e-9)


def test_without_support_nothing_of_it_is_said():
    text = program_text(lone("h1", "h2"))
    for word in ("told_fits", "way_to_stand", "stands_right", "plane_prior"):
        assert word not in text
    for goal in ("support_plane(S)", "stands_on(H, S)", "free(H)", "stance(H, S, R)"):
        assert scene_answers(lone("h1", "h2"), [goal]) == [[]]
        assert stock(lone("h1", "h2"), [goal]) == {}


def renamed(subject, name):
    """The same with hypotheses and planes called otherwise, and in reverse order."""
    support = subject.support
    stances = tuple(replace(s, hypothesis=name(s.hypothesis), on=name(s.on)) for s in support.stances)
    by_chance = tuple((name(h), e) for h, e in support.by_chance)
    level = tuple((name(h), name(s), ratio) for h, s, ratio in support.level)
    planes = tuple(replace(p, name=name(p.name)) for p in support.planes)
    hypotheses = tuple(
        h.told(id=name(h.id), features=tuple(replace(f, hidden_by=tuple(map(name, f.hidden_by))) for f in h.features))
        for h in subject.hypotheses
    )
    pairs = {
        key: frozenset((name(x), name(y)) for x, y in getattr(subject, key))
        for key in ("overlaps", "rivals", "exclusive")
    }
    return replace(
        subject,
        hypotheses=hypotheses[::-1],
        support=replace(support, planes=planes[::-1], stances=stances[::-1], by_chance=by_chance[::-1], level=level),
        relations=(),
        **pairs,
    )


@QUICK
@given(random_situations(most=4), SEEDS)
def test_names_and_order_change_nothing(subject, seed):
    subject = with_support(subject, seed)
    other = renamed(subject, lambda name: f"The {name}")
    back = {tuple(sorted(h.removeprefix("The ") for h in world)): p for world, p in worlds_of(other).items()}
    assert back == pytest.approx(worlds_of(subject), abs=1e-9)
    if back:
        mine, theirs = (scene_answers(some, ["stance(H, S, R)", "free(H)"]) for some in (subject, other))
        for one, two in zip(mine, theirs, strict=True):
            assert {a.goal: a.probability for a in one} == pytest.approx(
                {a.goal.replace("The ", "").replace("'", ""): a.probability for a in two}, abs=1e-9
            )


def neutral(name, planes, rests, rng):
    """Ways to stand of which none + Σ prior · (1 - rests + chance · ρ) is 1, as of one object alone (§9.9)."""
    weights = {p.name: 0.05 + rng.random() for p in planes}
    told = sum(p.prior for p in planes)
    scale = 1.0 / sum(p.prior * weights[p.name] for p in planes)  # of the planes' own shares
    return [Stance(name, p.name, 0, rests, math.log(scale * told * weights[p.name])) for p in planes]


@QUICK
@given(st.randoms(use_true_random=False), st.integers(1, 4))
def test_one_alone_keeps_its_probability_and_of_several_the_others_count(rng, count):
    planes = tuple(plane(f"s{i}", 0.9 / count) for i in range(count))
    one = Support(0.9, 0.1, planes, tuple(neutral("h1", planes, 0.9, rng)))
    alone = lone("h1")
    for e in (0.0, 0.12, 0.7, 1.0):
        told = replace(one, by_chance=(("h1", e),))
        assert worlds_of(replace(alone, support=told)) == pytest.approx(worlds_of(alone), abs=1e-9)
    both = replace(one, stances=(*one.stances, *(replace(s, hypothesis="h2") for s in one.stances)))
    beside = worlds_of(replace(lone("h1", "h2"), support=both))
    before = worlds_of(lone("h1", "h2"))
    factors = [0.1 + 0.9 * math.exp(s.log_ratio) for s in one.stances]
    gained = 0.1 + sum(0.9 / count * f * f for f in factors)
    odds = (beside[("h1", "h2")] / beside[()]) / (before[("h1", "h2")] / before[()])
    assert odds == pytest.approx(gained)
    assert gained >= 1.0 - 1e-12


def answer(subject, goal):
    return scene_answers(subject, [goal])[0][0].probability


def test_far_from_every_plane_it_is_free():
    far = lone("h1", support=on_plane(-600.0))
    assert answer(far, "free(h1)") == pytest.approx(answer(far, "present(h1)"), abs=1e-12)
    before = answer(lone("h1"), "present(h1)")
    odds = answer(far, "present(h1)") / (1.0 - answer(far, "present(h1)")) / (before / (1.0 - before))
    assert odds == pytest.approx(0.1)  # nothing known holds it: 1 - rests
    near = lone("h1", support=on_plane(4.0))
    assert answer(near, "stands_on(h1, s1)") == pytest.approx(
        answer(near, "present(h1)") * 0.9 * math.exp(4.0) / (0.1 + 0.9 * math.exp(4.0))
    )
    assert answer(near, "rests_on(h1, ground)") == answer(near, "held(h1)") == answer(near, "stands_on(h1, s1)")


STACK = (Stance("h1", "s1", 0, 0.9, 3.0), Stance("h2", "h1", 0, 0.6, 5.0), Stance("h2", "s1", 0, 0.3, -20.0))


def test_what_stood_on_a_removed_one_is_free():
    for reading in ("score", "posterior"):
        live = LiveScene(lone("h1", "h2", reading=reading, support=Support(0.9, 0.0, (plane("s1", 1.0),), STACK)))
        live.observe("present(h2)")
        before = live.answers("rests_on(h2, h1)")[0].probability
        assert before > 0.2
        live.observe("\\+ present(h1)")
        assert live.answers("rests_on(h2, h1)")[0].probability == 0.0
        assert live.answers("free(h2)")[0].probability == pytest.approx(0.7 if reading == "score" else 1.0, abs=1e-6)
        live.unobserve("\\+ present(h1)")
        live.remove("h1")
        assert live.answers("free(h2)")[0].probability == pytest.approx(0.7 if reading == "score" else 1.0, abs=1e-6)


@QUICK
@given(random_situations(most=5), SEEDS)
def test_the_relevant_part_gives_the_same_answer(subject, seed):
    subject = with_support(subject, seed)
    if worlds_of(subject):
        goals = "present(h1)", "free(h1)", "stands_on(h1, S)", "stance(h1, S, R)", "rests_on(h1, X)"
        for goal, whole in zip(goals, scene_answers(subject, goals), strict=True):
            part = scene_answers(relevant(subject, [goal]), [goal])[0]
            assert {a.goal: a.probability for a in part} == pytest.approx({a.goal: a.probability for a in whole})


@pytest.mark.parametrize("e", [0.0, 0.12, 1.0])
def test_one_may_stand_on_very_many_others(e):
    """More than one factor looks at: its stance is a variable, and the worlds are those of the definition."""
    names = [f"h{i}" for i in range(9)]
    stances = tuple(Stance("h0", other, 0, 0.1, 0.5 * i) for i, other in enumerate(names[1:]))
    subject = by_chance(lone(*names, support=Support(0.9, 0.2, (plane("s1", 0.5),), stances)), e)
    assert worlds_of(subject) == pytest.approx(by_hand(subject), abs=1e-9)


@pytest.mark.parametrize("e", [0.0, 0.12])
def test_many_that_surely_stand_are_no_less_exact_in_problog(e):
    """Trap (g): each absent one weighs e^-12 and less of what it could, together far less than 1e-12."""
    names = [f"h{i}" for i in range(8)]
    stances = tuple(
        Stance(name, on, 0, 0.9, 12.0 + i if on == "s1" else -30.0)
        for i, name in enumerate(names)
        for on in ("s1", "s2")
    )
    subject = by_chance(lone(*names, support=Support(0.9, 0.1, (plane("s1", 0.5), plane("s2", 0.3)), stances)), e)
    theirs = stock(subject, [f"present({name})" for name in names] + ["support_plane(s1)"])
    ours = {goal: answer(subject, goal) for goal in theirs}
    assert len(ours) == 9
    assert ours == pytest.approx(theirs, abs=1e-9)


def test_who_edits_a_fact_changes_what_follows():
    subject = by_chance(lone("h1", support=on_plane(4.0)), 0.12)
    text = program_text(subject) + "query(present(h1)).\n"
    for old, new, support in (
        ("0.9, 4.0).", "0.9, -2.0).", on_plane(-2.0)),
        ("rests_chance(0.9)", "rests_chance(0.95)", replace(on_plane(4.0), rests=0.95)),
        ("plane_prior(s1, 1.0)", "plane_prior(s1, 0.6)", replace(on_plane(4.0), planes=(plane("s1", 0.6),))),
    ):
        assert text.count(old) == 1
        (found,) = evaluated(text.replace(old, new)).values()
        told = by_chance(lone("h1", support=support), 0.12)
        assert found == pytest.approx(answer(told, "present(h1)"), abs=1e-9)
    (found,) = evaluated(text.replace("0.12::by_chance(h1)", "0.5::by_chance(h1)")).values()
    assert found == pytest.approx(answer(by_chance(subject, 0.5), "present(h1)"), abs=1e-9)


TWO = Stance("h1", "s1", 0, 0.4, 1.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rests": 1.5}, "rests: 1.5 is not a number from 0.0 to 1.0"),
        ({"none": 0.6}, "sum to more than 1"),
        ({"planes": (plane("s1", 0.2), plane("s1", 0.2))}, "plane 's1' occurs twice"),
        ({"planes": (plane("h1", 0.2),)}, "'h1' is no name of a plane"),
        ({"planes": (plane("free", 0.2),)}, "'free' is no name of a plane"),
        ({"planes": (plane("s1", 0.2, normal=(0.0, 0.0, 2.0)),)}, "normal is 2.0 long, not 1"),
        ({"planes": (plane("s1", 0.2, offset=math.nan),)}, "s1: nan"),
        ({"stances": (replace(TWO, hypothesis="h9"),)}, "stance: 'h9' is unknown"),
        ({"stances": (replace(TWO, on="s9"),)}, "stance on: 's9' is unknown"),
        ({"stances": (replace(TWO, face=-1),)}, "face is below 0"),
        ({"stances": (TWO, TWO)}, "occurs twice"),
        ({"stances": (replace(TWO, log_ratio=math.inf),)}, "inf is not a number from -600.0 to 600.0"),
        ({"stances": (TWO, replace(TWO, on="h2", chance=0.51))}, "chances of h1 sum to 0.91"),
        ({"stances": (replace(TWO, on="h2"), Stance("h2", "h1", 0, 0.2, 0.0))}, "h1, h2 some stand on what stands"),
        ({"stances": (replace(TWO, on="h1"),)}, "of h1 some stand on what stands"),
        ({"by_chance": (("h9", 0.1),)}, "by_chance: 'h9' is unknown"),
        ({"level": (("h9", "s1", 0.1),)}, "level: 'h9' is unknown"),
        ({"level": (("h1", "s9", 0.1),)}, "level above: 's9' is unknown"),
        ({"level": (("h1", "s1", -0.1),)}, "level of h1 above s1: -0.1 is not a number from 0.0"),
        ({"by_chance": (("h1", 0.1), ("h1", 0.2))}, "by_chance 'h1' occurs twice"),
        ({"by_chance": (("h1", 1.5),)}, "by_chance of h1: 1.5 is not a number from 0.0 to 1.0"),
    ],
)
def test_what_contradicts_itself_is_refused(change, message):
    support = replace(Support(0.9, 0.1, (plane("s1", 0.5),), ()), **change)
    with pytest.raises(SituationError, match=message):
        ranked_worlds(lone("h1", "h2", support=support))


def test_no_hypothesis_has_the_name_of_a_stance():
    with pytest.raises(SituationError, match="hypothesis 'free' has the name of a stance"):
        ranked_worlds(lone("free", support=Support(0.9, 1.0, (), ())))
