"""Contributions are the terms of the Bayes factor between a world with the hypothesis and one without it."""

from __future__ import annotations

import math

import pytest
from situations import feature, hypothesis, situation

from plogic.scene.asking.presence import contributions
from plogic.scene.worlds.ranked_worlds import ranked_worlds


def test_they_sum_to_the_bayes_factor():
    front = hypothesis("h1", [feature("x"), feature("y", "C")])
    back = hypothesis("h2", [feature("u", match="b"), feature("v", "C", hidden_by=("h1",)), feature("w", match="a_x")])
    subject = situation([front, back], "posterior")
    odds = {w.present: w.probability for w in ranked_worlds(subject).worlds}
    bayes = math.log(odds["h1", "h2"] / odds["h2",]) - math.log(0.3 / 0.7)
    assert math.fsum(c.llr for c in contributions(subject, "h1", ["h2"])) == pytest.approx(bayes, abs=1e-6)


def test_what_it_hides_speaks_for_it_and_what_is_missed_against_it():
    front = hypothesis("h1", [feature("x"), feature("y", "C", hit_rate=0.9)])
    back = hypothesis("h2", [feature("v", "C", hidden_by=("h1",), hit_rate=0.7)])
    found = {c.datum: c.llr for c in contributions(situation([front, back], "posterior"), "h1", ["h2"])}
    assert found["h1/y"] == pytest.approx(math.log(0.1))
    assert found["h2/v"] == pytest.approx(-math.log(0.3))
    assert found["a_x"] == pytest.approx(math.log((0.8 * 0.05 + 0.2 * 2e-5) / 2e-5))


def test_a_transparent_world_without_data_says_nothing():
    assert contributions(situation([hypothesis("h1", [feature("x", "B")])], "posterior"), "h1", []) == []
