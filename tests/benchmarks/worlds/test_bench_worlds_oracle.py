"""The benchmark's oracles against each other, against stock ProbLog, and against a case that is done by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.families.bench import clusters, grid
from benchmarks.worlds.oracle import MOST, by_frontier, enumerated, marginals_of
from benchmarks.worlds.stock import stock
from plogic.base.errors import SituationError
from plogic.scene.text.program_text import program_text, query_lines


def by_enumeration(situation):
    return marginals_of(situation, enumerated(situation))


def of_stock(situation, knowledge="ddnnf"):
    run = stock(program_text(situation) + query_lines(situation), knowledge, 60.0)
    assert not run.why
    return {h.id: run.answers[f"present({h.id})"] for h in situation.hypotheses}


@pytest.mark.parametrize(
    "situation",
    [
        clusters(6, 1),
        clusters(9, 2),
        clusters(6, 1, "score"),
        clusters(9, 2, "score"),
        grid(8, 3, 0),
        grid(8, 3, 1, "score"),
    ],
    ids=lambda s: f"{s.reading} {len(s.hypotheses)}",
)
def test_enumeration_against_stock_problog(situation):
    assert by_enumeration(situation) == pytest.approx(of_stock(situation), abs=1e-9)


def test_one_detected_feature_by_hand():
    """P = π·(hN + f − hf) / (π·(hN + f − hf) + (1 − π)·f), where each missed feature costs 1 − h (§8)."""
    h = grid(1, 1, 0).hypotheses[0]
    hit = next(f for f in h.features if f.match == "a2")
    missed = next(f for f in h.features if f.match is None)
    situation = replace(grid(1, 1, 0), hypotheses=(replace(h, features=(hit, missed)),))
    f = situation.appearances[1].clutter
    present = 0.5 * (hit.hit_rate * hit.density + f - hit.hit_rate * f) * (1.0 - missed.hit_rate)
    assert by_enumeration(situation)["h1"] == pytest.approx(present / (present + 0.5 * f), rel=1e-12)


@settings(derandomize=True, deadline=None, max_examples=20)
@given(st.integers(1, 12), st.integers(1, 4), st.integers(0, 100))
def test_the_frontier_against_enumeration(number, columns, seed):
    situation = grid(number, columns, seed)
    wanted = by_enumeration(situation)
    assert by_frontier(situation, columns, tuple(wanted)) == pytest.approx(wanted, abs=1e-12)


def test_worlds_sum_to_one_and_none_breaks_a4():
    situation = clusters(10, 4)
    chances = enumerated(situation)
    names = [h.id for h in situation.hypotheses]
    assert chances.sum() == pytest.approx(1.0)
    assert situation.overlaps
    for x, y in situation.overlaps:
        both = np.take(np.take(chances, [1], names.index(x)), [1], names.index(y))
        assert both.sum() == 0.0


def test_too_many_to_enumerate_is_said():
    with pytest.raises(SituationError, match=f"15 hypotheses.*at most {MOST}"):
        enumerated(clusters(15, 0))
