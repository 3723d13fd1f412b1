"""Intervals contain the exact value wherever a deadline falls: scenes, live scenes and programs.

In wide pieces above all.
"""

from __future__ import annotations

import copy
import json
import math
from itertools import pairwise
from threading import Event

import pytest
from crowds import crowd
from drawn_programs import programs
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from situations import random_situations
from stopping import LONG, stopped
from tangles import tangle

from plogic.base.errors import InconsistentError
from plogic.logic.answers import intervals as anytime
from plogic.logic.answers import intervals as bounds
from plogic.logic.answers import state_ranking as ranking
from plogic.scene.asking.live import LiveScene
from plogic.scene.worlds.ranked_worlds import ranked_worlds

QUICK = settings(max_examples=80, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
ROUNDING = 1e-10


pytestmark = pytest.mark.usefixtures("served_here")


def holds(interval, exact):
    low, high = interval
    return low <= high and low - ROUNDING <= exact <= high + ROUNDING


def assert_contains(hurried, exact):
    """Every number of a ranking; ``exact`` lists every world."""
    every = {w.present: w.probability for w in exact.worlds}
    assert holds(hurried.log_evidence_interval, exact.log_evidence)
    assert hurried.intervals.keys() == exact.marginals.keys()
    assert all(holds(interval, exact.marginals[h]) for h, interval in hurried.intervals.items())
    assert all(holds(w.interval, every[w.present]) for w in hurried.worlds)
    assert all(w.interval[0] <= w.probability <= w.interval[1] for w in hurried.worlds)
    assert holds(hurried.unlisted, 1.0 - math.fsum(every[w.present] for w in hurried.worlds))
    order = [w.interval for w in hurried.worlds]
    assert all(a[0] >= b[0] - ROUNDING and a[1] >= b[1] - ROUNDING for a, b in pairwise(order))


@QUICK
@given(random_situations(), st.integers(0, 150), st.sampled_from([0.0, 1.0, 2.5]), st.integers(0, 5))
def test_scenes_wherever_inference_stops(subject, checks, width, n):
    try:
        exact = ranked_worlds(subject, 10**6)
    except InconsistentError:
        return
    with stopped(checks, width):
        hurried = ranked_worlds(subject, n, seconds=LONG)
    assert_contains(hurried, exact)


@pytest.fixture(scope="module")
def wide():
    """(situation, all its worlds) of pieces that hang together closely, both readings."""
    subjects = [tangle(11), crowd(12, 1), crowd(12, 2, "score", "to_B")]
    return [(subject, ranked_worlds(subject, 2**12)) for subject in subjects]


@pytest.mark.parametrize("checks", [0, 40, 150, 200, 300, 400, 600, 1000, 10**9])
@pytest.mark.parametrize("width", [2.0, 4.0])
def test_wide_scenes_wherever_inference_stops(wide, checks, width):
    assert len(wide) > 0
    for subject, exact in wide:
        with stopped(checks, width):
            hurried = ranked_worlds(subject, 7, seconds=LONG)
        assert_contains(hurried, exact)
        assert len(hurried.worlds) == 7
        assert hurried.exact or checks < 10**9


def test_the_stops_fall_inside_the_wide_path(wide):
    """Neither all before the first case nor all after the last.

    Some intervals are strictly between [0, 1] and a number.
    """
    subject, _ = wide[0]
    widths = set()
    for checks in (0, 400, 800, 1600, 10**9):
        with stopped(checks, 2.0):
            found = ranked_worlds(subject, 1, seconds=LONG).intervals
        widths.add(round(max(high - low for low, high in found.values()), 3))
    assert {0.0, 1.0} < widths
    assert len(widths) == 5


GIVEN = ("present(h3)", "\\+ noise(a2)")
GOALS = ("cause(a3, H, F)", "present(h1) ; \\+ present(h2)", "present(h1), \\+ noise(a4)")


@pytest.fixture(scope="module")
def known():
    """Of a live scene that was given time enough: its worlds, its marginals, and the answers to each goal."""
    exact = LiveScene(tangle(9))
    for goal in GIVEN:
        exact.observe(goal)
    answers = [{a.goal: a.probability for a in exact.answers(goal)} for goal in GOALS]
    assert all(answers)
    return exact.worlds(2**9), exact.marginals(), answers


@pytest.mark.parametrize("checks", [0, 300, 500, 800])
def test_live_scenes_wherever_inference_stops(known, checks):
    worlds, marginals, told = known
    hurried = LiveScene(tangle(9))
    with stopped(checks, 2.0):
        for goal in GIVEN:
            hurried.observe(goal, seconds=LONG)
        assert_contains(hurried.worlds(5, seconds=LONG), worlds)
        found = hurried.marginals(seconds=LONG)
        assert all(holds(found[h], p) for h, (p, _) in marginals.items())
        for goal, answers in zip(GOALS, told, strict=True):
            intervals = {a.goal: a.interval for a in hurried.answers(goal, seconds=LONG)}
            assert answers.keys() <= intervals.keys()
            assert all(holds(interval, answers.get(text, 0.0)) for text, interval in intervals.items())


def test_an_interval_of_a_live_scene_is_forgotten_when_there_is_time():
    live = LiveScene(tangle(9))
    with stopped(400, 2.0):
        assert any(low < high for low, high in live.marginals(seconds=LONG).values())
    with stopped(10**9, 2.0):
        assert live.marginals() == live.marginals(seconds=LONG) == LiveScene(tangle(9)).marginals()


@QUICK
@given(programs(), st.integers(0, 30))
def test_programs_whatever_was_told_when_the_deadline_came(drawn, patience):
    """The compiler takes its time.

    ``patience`` refinements of the bounds are told first, each of which a deadline may leave as the answer.
    """
    held = drawn.held()
    assume(held)
    mass = math.fsum(p for p, _ in held)
    exact = {atom: math.fsum(p for p, true in held if atom in true) / mass for atom in drawn.queries}
    told = slowly_told(drawn.text, patience)
    assert told
    for reply in told:
        ((*answers,),) = reply["answers"]
        assert {goal for goal, *_ in answers} == set(drawn.queries)
        assert all(holds((low, high), exact[goal]) for goal, low, high in answers)


def slowly_told(text, patience):
    """The answers of ``answers_by`` where the compiler is ready after so many looks at the bounds (or soon after)."""
    ready, told, looks = Event(), [], []
    exactly, refine = anytime.probabilities, anytime.Bounds.refine

    def late(found):
        ready.wait(0.02)
        return exactly(found)

    def counted(found):
        looks.append(found)
        if len(looks) > patience:
            ready.set()
        refine(found)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(anytime, "probabilities", late)
        patch.setattr(anytime, "FIRST_WAIT", -1.0)
        patch.setattr(bounds, "DECISIONS_AT_ONCE", 1)
        patch.setattr(anytime.Bounds, "refine", counted)
        anytime.answers_by(
            {"texts": [{"text": text, "file": "program"}]}, lambda reply: told.append(copy.deepcopy(reply))
        )
    return told


@QUICK
@given(programs())
def test_worlds_told_on_the_way_are_a_beginning_of_those_told_at_the_end(drawn):
    assume(drawn.held())
    told = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ranking, "FIRST_WAIT", -1.0)
        document = {"texts": [{"text": drawn.text, "file": "program"}], "number": 100, "anytime": True}
        end = ranking.ranked(document, lambda reply: told.append(json.loads(json.dumps(reply))))
    assert [len(reply["worlds"]) for reply in told] == list(range(1, 1 + len(end["worlds"])))
    for reply in told:
        assert reply["partial"]
        assert reply["worlds"] == end["worlds"][: len(reply["worlds"])]
        assert reply["log_evidence"] == end["log_evidence"]
