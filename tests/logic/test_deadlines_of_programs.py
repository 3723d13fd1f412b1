"""Intervals contain the exact probability at every deadline."""

from __future__ import annotations

import pytest
from drawn_programs import programs
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from plogic.logic.answers import intervals as bounding
from plogic.logic.answers.intervals import Bounds, answers_by
from plogic.logic.grounding.load import ground, request_from
from plogic.logic.served.engine import Text, run, run_until
from plogic.logic.served.program_worlds import program_worlds

ALARM = """0.1::burglary. 0.2::earthquake. 0.7::alarm(X) :- burglary, p(X). 0.3::alarm(X) :- earthquake, p(X).
0.05::noise(X) :- p(X). p(a). p(b). p(c). p(d). calls(X) :- alarm(X). calls(X) :- noise(X), \\+ alarm(X).
0.2::c(X,r); 0.3::c(X,g) :- p(X). evidence(calls(a)). evidence(\\+calls(b)).
query(burglary). query(earthquake). query(calls(X)). query(c(X,Y))."""


def document(text):
    return {"texts": [{"text": text, "file": "program"}]}


@settings(derandomize=True, deadline=None, max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(programs(), st.sampled_from([1, 3, 64]))
def test_bounds_contain_the_exact_value_at_every_step(monkeypatch, drawn, at_once):
    """Also where few decisions are taken further at a time, so that the steps are many."""
    monkeypatch.setattr(bounding, "DECISIONS_AT_ONCE", at_once)
    held = drawn.held()
    assume(held)
    mass = sum(p for p, _ in held)
    exact = [sum(p for p, true in held if atom in true) / mass for atom in drawn.queries]
    bounds, widths = Bounds(ground(request_from(document(drawn.text)))), []
    while True:
        intervals = bounds.intervals()
        assert all(low - 1e-12 <= p <= high + 1e-12 for p, (low, high) in zip(exact, intervals, strict=True))
        widths.append(max(high - low for low, high in intervals))
        if bounds.done:
            break
        bounds.refine()
    assert widths[-1] < 1e-9


def test_what_is_told_on_the_way_contains_what_is_told_at_the_end():
    told = []
    end = answers_by(document(ALARM), told.append)["answers"][0]
    exact = dict(end)
    assert told
    for reply in told:
        assert reply["partial"]
        assert [goal for goal, _, _ in reply["answers"][0]] == [goal for goal, _ in end]
        assert all(low <= exact[goal] <= high for goal, low, high in reply["answers"][0])


@pytest.mark.parametrize("seconds", [1e-6, 0.05, 0.3, 60.0])
def test_a_deadline_gives_intervals_that_contain_the_exact_value(seconds):
    goals = ["burglary", "calls(c)", "calls(X)"]
    exact = [{a.goal: a.probability for a in answers} for answers in run([Text(ALARM)], goals)]
    found, done = run_until([Text(ALARM)], goals, seconds=seconds)
    assert len(found) == len(goals)
    assert [a.goal for a in found[0]] == ["burglary"]
    for answers, expected in zip(found, exact, strict=True):
        assert all(
            a.interval[0] - 1e-12 <= expected[a.goal] <= a.interval[1] + 1e-12 for a in answers if a.goal in expected
        )
        assert done == all(a.interval[0] == a.interval[1] for a in answers) or not answers
    assert done or seconds < 60


@pytest.mark.parametrize("seconds", [1e-6, 60.0])
def test_worlds_by_a_deadline_state_the_mass_that_is_missing(seconds):
    ranking = program_worlds(Text(ALARM), 5, seconds=seconds)
    assert sum(w.probability for w in ranking.worlds) + ranking.unlisted[1] == pytest.approx(1.0)
    assert ranking.complete == (seconds == 60)
    assert len(ranking.worlds) == (5 if ranking.complete else 0)
