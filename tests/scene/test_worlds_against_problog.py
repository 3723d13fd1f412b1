"""The exact worlds equal the program text, run by stock ProbLog (§8: the text is the definition)."""

from __future__ import annotations

import math

import pytest
from hypothesis import HealthCheck, given, settings
from situations import random_situations, situation, towers
from stock_worlds import assert_same_worlds, stock, worlds_program

from plogic.base.errors import InconsistentError
from plogic.facts.situation import names_of
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds

QUICK = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


@QUICK
@given(random_situations(readings=("score",)))
def test_score_worlds_equal_problog(subject):
    try:
        assert_same_worlds(subject)
    except InconsistentError:
        assert_problog_finds_none(subject)


@QUICK
@given(random_situations(readings=("posterior",)))
def test_posterior_worlds_equal_problog(subject):
    assert_same_worlds(subject)


def assert_problog_finds_none(subject):
    from problog.errors import InconsistentEvidenceError

    with pytest.raises(InconsistentEvidenceError):
        stock(worlds_program(subject))


@settings(QUICK, max_examples=25)
@given(random_situations(most=4))
def test_marginals_and_causes_equal_problog(subject):
    try:
        ranking = ranked_worlds(subject, 10**6)
    except InconsistentError:
        return
    names = names_of(subject)
    text = (
        program_text(subject) + "\nquery(present(_)). query(cause(_, _, _)). query(noise(_)). query(case(_, _, _)).\n"
    )
    theirs = stock(text)
    assert set(ranking.marginals) == {h.id for h in subject.hypotheses}
    for h in subject.hypotheses:
        assert theirs.get(f"present({names.atom(h.id)})", 0.0) == pytest.approx(ranking.marginals[h.id], abs=1e-9)
    for a in subject.appearances:
        noise = theirs[f"noise({a.id})"]
        caused = [p for goal, p in theirs.items() if goal.startswith(f"cause({a.id},")]
        assert noise + math.fsum(caused) == pytest.approx(1.0, abs=1e-8), "exactly one cause per appearance (trap a)"
        if subject.reading == "score":
            assert noise == pytest.approx(
                sum(w.probability for w in ranking.worlds if w.causes[a.id] == "noise"), abs=1e-9
            )
    assert_one_case_per_feature(subject, names, theirs, ranking)


def assert_one_case_per_feature(subject, names, theirs, ranking):
    """A present feature in the image is in exactly one of the four cases (§4).

    One that projects outside it is in none.
    """
    totals, due = {}, {}
    for h in subject.hypotheses:
        for f in h.features:
            case = f"case({names.atom(h.id)},{names.atom(f.id)},"
            totals[h.id, f.id] = math.fsum(p for goal, p in theirs.items() if goal.startswith(case))
            due[h.id, f.id] = ranking.marginals[h.id] if f.in_image else 0.0
    assert totals == pytest.approx(due, abs=1e-8)


@pytest.mark.parametrize(
    ("reading", "mode"), [("score", "drop"), ("score", "to_B"), ("score", "reassign"), ("posterior", "to_B")]
)
def test_two_towers_equal_problog(reading, mode):
    assert_same_worlds(towers(reading, mode))


def test_no_hypothesis_is_one_empty_world():
    empty = ranked_worlds(situation(()))
    assert [(w.probability, w.present) for w in empty.worlds] == [(1.0, ())]
    assert list(stock(program_text(situation(())) + "query(noise(a1)).").values()) == [0.0]
