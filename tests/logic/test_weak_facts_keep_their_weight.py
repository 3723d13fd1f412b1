"""Trap (g) of §8: thousands of weak facts neither underflow nor raise, and labels below 1e-9 count."""

from __future__ import annotations

import math

import numpy as np
import pytest

from plogic.logic.answers.answer import answers_of_text, prepared


def test_thousands_of_weak_facts_as_evidence():
    n = 2000
    text = "0.3::h.\n" + "".join(
        f"0.01::x({i}). 0.02::y({i}). e({i}) :- h, x({i}). e({i}) :- \\+ h, y({i}). evidence(e({i})).\n"
        for i in range(n)
    )
    text += "query(h)."
    log_odds = math.log(0.3 / 0.7) + n * math.log(0.01 / 0.02)
    found = answers_of_text(text)["h"]
    assert found == 0.0 if log_odds < -745 else found == pytest.approx(math.exp(log_odds))
    _, program = prepared({"texts": [{"text": text, "file": "program"}]})  # the one that has just answered
    expected = float(np.logaddexp(math.log(0.3) + n * math.log(0.01), math.log(0.7) + n * math.log(0.02)))
    assert float(program.log_mass([()])[0]) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("exponent", [9, 12, 15])
def test_labels_below_problogs_threshold_count(exponent):
    text = f"1e-{exponent}::a. 2e-{exponent}::b. c :- a. c :- b. evidence(c). query(a). query(b)."
    assert answers_of_text(text) == pytest.approx({"a": 1 / 3, "b": 2 / 3}, rel=1e-9)


def test_certainty_is_told_from_near_certainty():
    text = "0.999999999999::a. 0.5::b. c :- \\+ a. c :- a, b. evidence(c). evidence(\\+ b). query(a)."
    assert answers_of_text(text) == {"a": 0.0}
