"""§8's worked example: the paper's four rows of Table 1, the towers' own dv, and A4."""

from __future__ import annotations

from dataclasses import replace

import pytest
from situations import towers
from stock_worlds import stock

from plogic.scene.text.program_text import program_text, query_lines
from plogic.scene.worlds.ranked_worlds import ranked_worlds

WORLDS = [
    ("drop", {("t1", "t2"): 0.961, ("t1",): 0.029, ("t1", "t2_distorted"): 0.010}),
    ("to_B", {("t1", "t2"): 0.968, ("t1",): 0.024, ("t1", "t2_distorted"): 0.008}),
]


@pytest.mark.parametrize(("mode", "expected"), WORLDS)
def test_ranked_worlds_are_the_formalisms(mode, expected):
    ranking = ranked_worlds(towers(mode=mode))
    likely = [w for w in ranking.worlds if w.probability > 1e-6]
    assert [w.present for w in likely] == list(expected)
    assert [round(w.probability, 3) for w in likely] == list(expected.values())
    assert ranking.unlisted == (0.0, 0.0)


@pytest.mark.parametrize(("mode", "expected"), WORLDS)
def test_stock_problog_gives_the_same(mode, expected):
    subject = towers(mode=mode)
    theirs = stock(program_text(subject) + query_lines(subject))
    assert theirs["present(t2)"] == pytest.approx(expected["t1", "t2"], abs=5e-4)
    assert theirs["present(t2_distorted)"] == pytest.approx(expected["t1", "t2_distorted"], abs=5e-4)


def test_p_ev_in_each_context():
    found = stock(program_text(towers(mode="drop")) + "query(ev_holds(_, _)).\n")
    prior = stock(program_text(replace(towers(mode="drop"), overlaps=frozenset())) + "query(ev_holds(_, _)).\n")
    assert round(prior["ev_holds(t2,[])"], 3) == 0.791
    assert round(prior["ev_holds(t2,[t1])"], 3) == 0.970
    assert prior["ev_holds(t1,[])"] == pytest.approx(1.0, abs=1e-12)
    assert found["ev_holds(t2,[t1])"] != prior["ev_holds(t2,[t1])"], "A4 is evidence"


def test_ev_of_the_four_rows():
    text = program_text(towers(mode="drop")) + "query(ev(_, _)). query(ev_in(_, _, _)).\n"
    found = {goal.split("],")[-1] for goal in stock(text) if goal.startswith("ev_in")}
    assert sorted(round(float(value.rstrip(")")), 2) for value in found) == [-0.51, 0.58, 0.94, 1.0]
