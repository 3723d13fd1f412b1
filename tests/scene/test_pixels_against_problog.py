"""Pixels as a factor of their own (formalism §9.10).

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
from situations import feature, hypothesis, random_situations, situation, towers, with_pixels
from stock_worlds import assert_same_worlds, stock

from plogic.facts.pixel_table import PixelTable, table_of
from plogic.facts.sanity import faults
from plogic.logic.served.engine import run
from plogic.scene.asking.live import scene_answers, without
from plogic.scene.asking.presence import contributions, presence
from plogic.scene.asking.query import answers
from plogic.scene.asking.relevant import relevant
from plogic.scene.text.program_text import program_of, program_text
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


def marginal(subject, name="h1"):
    return ranked_worlds(subject).marginals[name]


@QUICK
@given(random_situations(most=4, readings=("posterior",)), SEEDS)
def test_worlds_equal_problog_and_the_definition(subject, seed):
    subject = with_pixels(subject, seed)
    ranking = assert_same_worlds(subject)
    logs = log_weights(subject)
    assert ranking.log_evidence == pytest.approx(float(np.logaddexp.reduce(logs)), abs=1e-6)
    ids = [h.id for h in subject.hypotheses]
    shares = np.exp(logs - np.logaddexp.reduce(logs))
    ours = {w.present: w.probability for w in ranking.worlds}
    for row, share in enumerate(shares):
        present = tuple(name for bit, name in enumerate(ids) if row >> bit & 1)
        assert ours.get(present, 0.0) == pytest.approx(share, abs=1e-9)


@settings(QUICK, max_examples=15)
@given(random_situations(most=3, readings=("posterior",)), SEEDS)
def test_answers_equal_problog(subject, seed):
    subject = with_pixels(subject, seed)
    goals = [f"present({h.id})" for h in subject.hypotheses]
    theirs = stock(program_text(subject) + "".join(f"query({goal}).\n" for goal in goals))
    by_text, on_graph = run([program_of(subject)], goals), scene_answers(subject, goals)
    in_parts = [answers(relevant(subject, [goal]), goal) for goal in goals]
    for ours in (by_text, on_graph, in_parts):
        found = {goal: answer.probability for goal, (answer,) in zip(goals, ours, strict=True)}
        assert found == pytest.approx(theirs, abs=1e-9)


@QUICK
@given(random_situations(most=4, readings=("posterior",)), SEEDS)
def test_contributions_sum_to_the_bayes_factor(subject, seed):
    subject = with_pixels(subject, seed)
    ids = [h.id for h in subject.hypotheses]
    logs = log_weights(replace(subject, overlaps=frozenset(), priors={}))
    world = ids[1:]
    rest = sum(1 << ids.index(name) for name in world)
    found = contributions(subject, "h1", world)
    groups = [h.group for h in subject.hypotheses]
    if len(set(groups)) == len(groups) and np.isfinite(logs[[rest, rest + 1]]).all():
        change = logs[rest + 1] - logs[rest] - math.log(0.5 / 0.5)
        assert sum(c.llr for c in found) == pytest.approx(change, abs=1e-9)


def alone(odds, prior=0.3):
    told = hypothesis("h1", [feature("f1")], pixel_table=PixelTable((), (odds,)))
    return situation((told,), "posterior", priors={"box": prior})


def test_pixels_add_to_the_log_odds():
    without_any = marginal(situation((hypothesis("h1", [feature("f1")]),), "posterior"))

    def log_odds(p):
        return math.log(p / (1.0 - p))

    for odds in (-12.0, -0.5, 0.0, 3.0, 8.0):
        assert log_odds(marginal(alone(odds))) == pytest.approx(log_odds(without_any) + odds, abs=1e-6)


def test_a_pixel_counts_once():
    """Where h1 is present h2's are masked, and say nothing; nobody hides h1."""
    h1 = hypothesis("h1", [feature("f1")], pixel_table=PixelTable((), (4.0,)))
    h2 = hypothesis("h2", [feature("f2")], pixel_table=PixelTable(("h1",), (4.0, 0.0)))
    both = situation((h1, h2), "posterior")
    (given_h1,), (given_none,) = (
        scene_answers(both, ["present(h2)"], [evidence])[0] for evidence in ("present(h1)", "\\+ present(h1)")
    )
    odds = [p / (1.0 - p) for p in (given_h1.probability, given_none.probability)]
    assert math.log(odds[1] / odds[0]) == pytest.approx(4.0)
    assert marginal(without(both, "h1"), "h2") == pytest.approx(given_none.probability)


def test_the_score_reading_knows_nothing_of_it():
    subject = towers()
    told = with_pixels(subject, 1)
    assert program_text(replace(told, reading="score")) == program_text(subject)
    assert marginal(told, "t1") == marginal(subject, "t1")


def test_without_a_photo_the_text_says_nothing_of_pixels():
    assert "pixel" not in program_text(towers("posterior"))


def test_what_was_left_out_is_said_in_the_text():
    h1 = hypothesis("h1", [feature("f1")], pixel_table=PixelTable(("h2",), (1.0, 2.0), ("h3",)))
    others = [hypothesis(name, [feature(name)]) for name in ("h2", "h3")]
    text = program_text(situation((h1, *others), "posterior"))
    assert "% h1: not looked at before it: h3" in text
    assert "pixels(h1, [h2], 2.0)." in text


def test_who_edits_a_fact_changes_what_follows():
    text = program_text(alone(3.0)) + "query(present(h1)).\n"
    assert "pixels(h1, [], 3.0)." in text
    edited = stock(text.replace("pixels(h1, [], 3.0).", "pixels(h1, [], -7.5)."))
    assert edited["present(h1)"] == pytest.approx(marginal(alone(-7.5)), abs=1e-9)


def test_explain_tells_pixels_in_one_line():
    h1 = hypothesis("h1", [feature("f1")])
    h2 = hypothesis("h2", [feature("f2")], pixel_table=PixelTable(("h1",), (4.0, -1.0)))
    both = situation((h1, h2), "posterior")
    for world, mark, told in ((("h2",), "for", "+4"), (("h1", "h2"), "against", "-1")):
        (line,) = [line for line in presence(both, "h2", world) if "drawn at its pose" in line]
        assert line.startswith(f"  {mark}: ")
        assert f"{told} in log-odds" in line
    assert [line for line in presence(both, "h1", ("h1", "h2")) if "h2's pixels" in line]


def test_tables_are_read_as_written():
    table = PixelTable(("h2", "h3"), (1.0, 2.0, 3.0, 4.0), ("h4",))
    keys = table.document()
    assert [(row["present"], row["pixels"]) for row in keys["pixels_beside"]] == [
        ([], 1.0),
        (["h2"], 2.0),
        (["h3"], 3.0),
        (["h2", "h3"], 4.0),
    ]
    assert table_of(keys["pixels_beside"], keys["pixels_left_out"]) == table
    assert table.among({"h3"}) == PixelTable(("h3",), (1.0, 3.0))


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (PixelTable(("h1",), (0.0, 1.0)), "'h1' is unknown"),
        (PixelTable(("h9",), (0.0, 1.0)), "'h9' is unknown"),
        (PixelTable((), (math.inf,)), "is not a number from -600.0 to 600.0"),
        (table_of([{"present": ["h2"], "pixels": 1.0}]), "should tell every set of those before it"),
        (table_of([{"present": [], "pixels": 1.0}] * 2), "should tell every set of those before it"),
    ],
)
def test_a_table_that_cannot_be_is_told(table, said):
    subject = situation(
        (hypothesis("h1", [feature("f1")], pixel_table=table), hypothesis("h2", [feature("f2")])), "posterior"
    )
    (fault,) = faults(subject)
    assert said in fault.what
    assert fault.place == ("hypotheses", "h1", "pixels_beside")
