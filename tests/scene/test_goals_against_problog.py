"""Goals of the vocabulary on the scene's graph have the probabilities of stock ProbLog for the program text (§8)."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from situations import feature, hypothesis, random_situations, situation, towers
from stock_worlds import evaluated
from tangles import tangle

from plogic.base.errors import InconsistentError, OutsideError, UnknownPredicateError
from plogic.facts.situation import names_of
from plogic.logic.served.engine import Text, run
from plogic.scene.asking.live import LiveScene, scene_answers
from plogic.scene.asking.query import answers
from plogic.scene.text.program_text import program_text

QUICK = settings(max_examples=30, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
GOALS = (
    "cause(A, H, F)", "noise(A)", "case(H, F, C)", "expected(H, F)", "detected(H, F)", "behind(Y, X)", "ev(H, V)", "dr(X, Y)",
    "occludes(X, Y)", "roc(R, X, Y)", "object(H, T)", "near(X, Y, D)", "feature(H, F, T)", "violated(X)", "explained(A)", "context(X, C)",
    "number_of_objects(N)", "number_of(T, N)", "number_of_objects(2)", "number_of_objects(N), N > 1", "why(H, F, C)",
)  # fmt: skip
GIVEN = (
    (), ("present(h1)",), ("\\+ present(h1)",), ("noise(a0)",), ("\\+ noise(a1)",), ("case(h1, F, a)", "\\+ noise(a2)"), ("cause(a3, h1, F)",),
    ("present(h1) ; noise(a1)",), ("\\+ (present(h1), noise(a1))",),
)  # fmt: skip


pytestmark = pytest.mark.usefixtures("served_here")


def stock(subject, goals, evidence):
    """Goal, as users write it, → probability, where it is positive."""
    from plogic.logic.safety.mapping import shown

    names = names_of(subject)
    clauses = "".join(f"given({i}) :- {e}.\nevidence(given({i})).\n" for i, e in enumerate(evidence))
    asked = "".join(f"query({goal}).\n" for goal in goals)
    results = evaluated(f"{program_text(subject)}\n{clauses}{asked}")
    return {shown(term, names): p for term, p in results.items() if p > 0}


def assert_same(subject, goal, evidence):
    from problog.engine import UnknownClause
    from problog.errors import InconsistentEvidenceError

    try:
        theirs = stock(subject, [goal], evidence)
    except (
        InconsistentEvidenceError,
        UnknownClause,
    ) as error:  # explained/1 is a predicate of the posterior reading alone
        with pytest.raises(
            InconsistentError if isinstance(error, InconsistentEvidenceError) else UnknownPredicateError
        ):
            scene_answers(subject, [goal], evidence)
        return
    assert ours(subject, goal, evidence) == pytest.approx(theirs, abs=1e-9)


def ours(subject, goal, evidence):
    found = scene_answers(subject, [goal], evidence)[0]
    return {answer.goal: answer.probability for answer in found if answer.probability > 0}


@QUICK
@given(
    random_situations(most=3), st.sampled_from([g for g in GOALS if not g.startswith("near")]), st.sampled_from(GIVEN)
)
def test_answers_equal_problog(subject, goal, evidence):
    assert_same(subject, goal, evidence)


ASKED = ["cause(A, H, F)", "noise(A)", "case(H, F, C)", "roc(R, X, Y)", "ev(H, V)"]
TOLD = ("present(t1)", "noise(y_other_D110) ; \\+ present(t2_distorted)")


@cache
def of_the_towers(reading):
    """What stock ProbLog answers to all that is asked, in one run."""
    return stock(towers(reading, "reassign"), ASKED, TOLD)


@pytest.mark.parametrize("reading", ["score", "posterior"])
@pytest.mark.parametrize("goal", ASKED)
def test_the_towers_answers_equal_problog(reading, goal):
    theirs = {found: p for found, p in of_the_towers(reading).items() if found.startswith(goal[: goal.index("(") + 1])}
    assert ours(towers(reading, "reassign"), goal, TOLD) == pytest.approx(theirs, abs=1e-9)


@QUICK
@given(random_situations(most=4), st.sampled_from(GIVEN))
def test_observed_and_taken_back_restores_the_bytes(subject, evidence):
    try:
        live = LiveScene(subject)
        before = live.marginals(), live.worlds(8), live.answers("noise(A)")
        for goal in evidence:
            live.observe(goal)
    except InconsistentError:
        return
    for goal in evidence:
        live.unobserve(goal)
    assert (live.marginals(), live.worlds(8), live.answers("noise(A)")) == before


@settings(QUICK, max_examples=60)
@given(random_situations(most=4, readings=("posterior",)), st.sampled_from([e for e in GIVEN if len(e) == 1]))
def test_worlds_given_evidence_are_those_that_problog_has(subject, evidence):
    """Worlds weigh what they weigh under the evidence, and their causes are possible under it."""
    live = LiveScene(subject)
    try:
        live.observe(*evidence)
    except InconsistentError:
        return
    ranking = live.worlds(100)
    assert sum(w.probability for w in ranking.worlds) == pytest.approx(1.0)
    best = ranking.worlds[:3]
    here = [
        ", ".join(("" if h.id in w.present else "\\+ ") + f"present({h.id})" for h in subject.hypotheses) for w in best
    ]
    for w, (answer,) in zip(best, scene_answers(subject, here, evidence), strict=True):
        assert answer.probability == pytest.approx(w.probability)
        if evidence == ("noise(a0)",):
            assert w.causes["a0"] == "noise"
        if evidence == ("\\+ noise(a1)",):
            assert w.causes["a1"] != "noise"


def test_impossible_evidence_changes_nothing():
    live = LiveScene(towers("score", "drop"))
    with pytest.raises(InconsistentError):
        live.observe("\\+ present(t1)")
    assert live.given == ()
    assert live.marginals()["t1"] == (1.0, 1.0)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (["present(t2)", "present(t9)"], r"; present\(t9\) alone is impossible$"),
        (
            ["present(t2)", "present(t1)", "\\+ present(t2)"],
            r"; present\(t2\) and \\\+ present\(t2\) exclude each other$",
        ),
    ],
)
def test_which_evidence_is_impossible_is_told(given, told):
    *before, last = given
    live = LiveScene(towers("posterior"))
    for goal in before:
        live.observe(goal)
    for ask in (lambda: live.observe(last), lambda: scene_answers(towers("posterior"), ["present(H)"], given)):
        with pytest.raises(InconsistentError, match=told):
            ask()


@pytest.mark.parametrize("goal", ["hit(t1, F)", "present(t1), hit(t1, _)", "present(H), pick(H, F)"])
def test_what_the_graph_has_summed_out_is_outside(goal):
    with pytest.raises(OutsideError):
        scene_answers(towers("posterior"), [goal])


def test_a_rule_with_a_choice_of_its_own_has_its_probability():
    rules = Text("tall(H) :- object(H, t1). 0.25::lucky(H) :- present(H).", "mine.pl")
    subject = towers("posterior")
    (answer,) = scene_answers(replace(subject, own=rules), ["tall(H)"])[0]
    assert answer.goal == "tall(t1)"
    (there,), (lucky,) = scene_answers(replace(subject, own=rules), ["present(t2)", "lucky(t2)"])
    assert lucky.probability == pytest.approx(there.probability / 4, rel=1e-12)


@pytest.mark.parametrize(
    "body", ["subquery(present(t1), P), P > 0.7", "G =.. [subquery, present(t1), P], call(G), P > 0.7"]
)
def test_a_rule_that_asks_for_probabilities_is_outside_and_the_program_answers(body):
    rules = Text(f"sure :- {body}.", "mine.pl")
    subject = replace(towers("score"), own=rules)
    with pytest.raises(OutsideError):
        scene_answers(subject, ["sure"])
    assert [answer.probability for answer in answers(subject, "sure")] == [1.0]


def test_an_unknown_predicate_is_no_question_of_inside_and_outside():
    with pytest.raises(UnknownPredicateError):
        scene_answers(towers("posterior"), ["nonsense(H)"])


def several(count=4):
    """Pairs of rivals that have nothing to do with each other, no two pairs alike."""
    members = []
    for i in range(count):
        for j in (1, 2):
            own = [
                feature(f"p{i}f{k}", "A", match=f"p{i}a{k}", density=0.01 * (i + j + k), hit_rate=0.5 + 0.09 * j)
                for k in range(2)
            ]
            members.append(hypothesis(f"p{i}h{j}", own, group=f"p{i}"))
    return situation(members, "posterior", rivals=frozenset({(f"p{i}h1", f"p{i}h2") for i in range(count)}))


def low(live):
    return {h: interval[0] for h, interval in live.marginals().items()}


def test_only_what_is_touched_is_solved_anew():
    subject = several()
    live = LiveScene(subject)
    live.marginals()
    assert live.solved == 4
    live.observe("present(p2h1)")
    assert live.solved == 5, "one piece has evidence now"
    live.unobserve()
    live.marginals()
    assert live.solved == 5, "nothing is new"
    removed = subject.hypotheses[3]
    live.remove(removed.id)
    assert live.solved == 6
    live.add(removed, rivals=frozenset({("p1h1", "p1h2")}))
    assert low(live) == pytest.approx(low(LiveScene(subject)))
    assert live.solved <= 7, "at most the piece that it went back to, in another order"


@QUICK
@given(random_situations(), st.randoms(use_true_random=False))
def test_order_and_names_of_hypotheses_do_not_matter(subject, random):
    assume(subject.reconsider != "drop")  # which six occluders are looked at goes by name
    shuffled = list(subject.hypotheses)
    random.shuffle(shuffled)
    try:
        before = low(LiveScene(subject))
    except InconsistentError:
        return
    after = low(LiveScene(replace(subject, hypotheses=tuple(shuffled))))
    assert after == pytest.approx(before, abs=1e-12)


@pytest.mark.parametrize("given_", [(), ("\\+ present('My Box')",), ("present(t1).", "\\+present('My Box')")])
@pytest.mark.parametrize("goal", ["present(H)", "present('My Box')", "\\+ present( t1 )", "\\+ present('t1')"])
def test_what_is_said_of_presence_alone_is_answered_as_the_program_answers(goal, given_):
    plain = towers("posterior")
    subject = replace(
        plain, hypotheses=tuple(replace(h, id="My Box") if h.id == "t2_distorted" else h for h in plain.hypotheses)
    )
    subject = replace(subject, overlaps=frozenset({("t2", "My Box")}), rivals=frozenset({("t2", "My Box")}))
    ours = scene_answers(subject, [goal], given_)[0]
    theirs = run([Text(program_text(subject))], [goal], given_, names=names_of(subject))[0]
    assert [a.goal for a in ours] == [a.goal for a in theirs]
    assert [a.probability for a in ours] == pytest.approx([a.probability for a in theirs], abs=1e-9)


@cache
def of_a_tangle():
    """What is exact of a tangle of 15 in which h3 is there: of presence, of three goals, of all worlds."""
    exact = LiveScene(tangle(15))
    exact.observe("present(h3)")
    goals = "cause(a3, H, F)", "present(h1) ; \\+ present(h2)", "present(h1), \\+ present(h2)"
    known = {goal: {answer.goal: answer.probability for answer in exact.answers(goal)} for goal in goals}
    return low(exact), known, {w.present: w.probability for w in exact.worlds(2**14).worlds}


@pytest.mark.parametrize("seconds", [0.0, 0.01, 60.0])
def test_what_is_asked_by_a_deadline_contains_what_is_exact(seconds):
    hurried, (present, answers, worlds) = LiveScene(tangle(15)), of_a_tangle()
    hurried.observe("present(h3)", seconds=seconds)
    assert hurried.marginals(seconds=seconds).keys() == present.keys()
    for h, (least, most) in hurried.marginals(seconds=seconds).items():
        assert least - 1e-9 <= present[h] <= most + 1e-9
    for goal, known in answers.items():
        found = hurried.answers(goal, seconds=seconds)
        assert known.keys() <= {answer.goal for answer in found}
        for answer in found:
            assert answer.interval[0] - 1e-9 <= known.get(answer.goal, 0.0) <= answer.interval[1] + 1e-9
    for w in hurried.worlds(3, seconds=seconds).worlds:
        assert w.interval[0] - 1e-9 <= worlds[w.present] <= w.interval[1] + 1e-9
