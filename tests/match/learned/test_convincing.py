"""How much pixels must tell: laws of the share of types that are there."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.match.learned.convincing import BEFORE, THERE, demanded

ODDS = st.lists(st.floats(-12.0, 15.0), min_size=1, max_size=25)
laws = settings(derandomize=True, deadline=None)


@laws
@given(ODDS)
def test_it_is_what_the_share_that_it_is_of_asks(odds):
    """Oracle: the share is the mean of P(there), with what is known before."""
    asked = demanded(np.array(odds))
    share = 1.0 / (1.0 + np.exp(asked) / THERE)
    each = [1.0 / (1.0 + np.exp(-one) * (1.0 - share) / share) for one in odds]
    assert share == pytest.approx((BEFORE[0] + sum(each)) / (sum(BEFORE) + len(odds)), rel=1e-3)


@laws
@given(ODDS, st.integers(0, 24), st.floats(0.0, 5.0))
def test_where_more_tells_of_one_less_is_asked_of_all(odds, which, more):
    raised = list(odds)
    raised[which % len(odds)] += more
    assert demanded(np.array(raised)) <= demanded(np.array(odds)) + 1e-6


def test_many_known_types_of_which_few_are_there_must_convince():
    """Two of twenty, and seven of eight."""
    few = demanded(np.array([8.0, 8.0, *[-3.0] * 18]))
    many = demanded(np.array([*[6.0] * 7, -3.0]))
    assert few > 3.0
    assert many < 1.5
    assert demanded(np.full(20, -np.inf)) == pytest.approx(np.log(THERE * (20 + BEFORE[1]) / BEFORE[0]))
