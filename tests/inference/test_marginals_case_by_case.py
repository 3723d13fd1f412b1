"""Past the width guard: cases of a cutset agree with enumeration, and intervals hold the exact values at every stop."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.base.clock import Clock, OutOfTimeError
from plogic.base.errors import WidthError
from plogic.inference import marginals as solving
from plogic.inference.conditioning import conditioned, log_weight, mini_buckets, promising
from plogic.inference.gates import Literal, Or, probability, with_formulas
from plogic.inference.graph import Factor, FactorGraph, split
from plogic.inference.marginals import Beliefs, beliefs, cutset, planned
from plogic.inference.order import order_along
from plogic.inference.passes import joint

LAW = settings(derandomize=True, deadline=None, max_examples=60)
FOREVER = Clock(None)


class Countdown(Clock):
    """A clock that stops at its n-th check: every place where a deadline can fall, without a clock."""

    def __init__(self, checks):
        super().__init__(None)
        self.checks = checks

    def check(self):
        """Raises once the checks are used up."""
        self.checks -= 1
        if self.checks < 0:
            raise OutOfTimeError


@st.composite
def dense_graphs(draw):
    """Connected by many factors, with impossible states."""
    cards = tuple(draw(st.lists(st.sampled_from((2, 2, 3)), min_size=3, max_size=7)))
    numbers = np.random.default_rng(draw(st.integers(0, 10**6)))
    impossible = draw(st.sampled_from((0.0, 0.15, 0.5)))
    factors = []
    for a in range(len(cards)):
        for b in range(a + 1, len(cards)):
            if b == a + 1 or numbers.random() < 0.6:
                table = numbers.normal(scale=draw(st.sampled_from((0.3, 3.0))), size=(cards[a], cards[b]))
                table[numbers.random(table.shape) < impossible] = -np.inf
                factors.append(Factor((a, b), table))
    return FactorGraph(cards, tuple(factors))


def assert_contains(interval, exact):
    log_z, singles = exact
    assert interval.log_z[0] <= log_z <= interval.log_z[1]
    if log_z > -math.inf:
        for low, high, single in zip(interval.low, interval.high, singles, strict=True):
            assert (low <= single).all()
            assert (single <= high).all()


@LAW
@given(dense_graphs(), st.sampled_from((1.0, 2.0, 3.2)))
def test_cases_agree_with_tables(graph, width):
    exact, found = beliefs(graph), beliefs(graph, width=width)
    assert found.exact
    assert found.log_z[0] == exact.log_z[0] or math.isclose(
        found.log_z[0], exact.log_z[0], rel_tol=1e-12, abs_tol=1e-12
    )
    for one, other in zip(found.low, exact.low, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-13)


@LAW
@given(dense_graphs(), st.integers(0, 300), st.sampled_from((2.0, 3.2)))
def test_wherever_the_clock_stops_it_the_interval_contains_the_exact_value(graph, checks, width):
    _, (part,) = split(graph)
    exact = joint(part.cards, part.tables)
    stopped = conditioned(part, cutset(part, planned(part, FOREVER)[0], width, 64.0, FOREVER), width, Countdown(checks))
    if exact[0] > -math.inf and stopped.log_z[0] == stopped.log_z[1]:
        assert stopped.log_z[0] == pytest.approx(exact[0], abs=1e-11)
    else:
        assert_contains(stopped, exact)


@LAW
@given(dense_graphs(), st.sampled_from((0.0, 2.0, 4.0, 30.0)))
def test_mini_buckets_bound_from_above_and_a_state_from_below(graph, bits):
    _, (part,) = split(graph)
    log_z, _ = joint(part.cards, part.tables)
    bound = mini_buckets(part.cards, part.tables, planned(part, FOREVER)[0].sequence, bits, FOREVER)
    assert bound.upper >= log_z - 1e-11
    if bound.upper > -math.inf:
        assert log_weight(part.tables, promising(part.cards, bound)) <= log_z + 1e-11
    if bits == 30.0:
        assert bound.upper == (pytest.approx(log_z, abs=1e-11) if log_z > -math.inf else log_z)


@LAW
@given(dense_graphs(), st.sampled_from((1e-9, 1e-4, 1e-3, 1e-2)), st.sampled_from((2.0, 20.0)))
def test_every_deadline_gives_a_valid_answer(graph, seconds, width):
    exact, found = beliefs(graph), beliefs(graph, width=width, seconds=seconds)
    if found.exact:
        assert found.log_z[0] == (pytest.approx(exact.log_z[0], abs=1e-11) if exact.log_z[0] > -math.inf else -math.inf)
    else:
        assert_contains(found, (exact.log_z[0], exact.low))


def test_an_expired_deadline_still_answers_every_piece():
    graph = FactorGraph((2, 3, 1, 2), (Factor((0, 1), np.zeros((2, 3))), Factor((3,), np.array([0.0, -1.0]))))
    found = beliefs(graph, seconds=0.0)
    assert not found.exact
    assert [(low.tolist(), high.tolist()) for low, high in zip(found.low, found.high, strict=True)] == [
        ([0.0] * 2, [1.0] * 2),
        ([0.0] * 3, [1.0] * 3),
        ([1.0], [1.0]),
        ([0.0] * 2, [1.0] * 2),
    ]
    assert found.log_z[0] <= math.log(6 * (1 + math.exp(-1))) <= found.log_z[1]


def test_a_clique_past_all_guards_says_its_width():
    count = 40
    table = np.array([[0.0, 0.0], [0.0, -1.0]])
    graph = FactorGraph((2,) * count, tuple(Factor((a, b), table) for a in range(count) for b in range(a + 1, count)))
    with pytest.raises(WidthError, match=r"40 variables .* 40\.0 bits .*limit is 20.* with a deadline"):
        beliefs(graph)
    found = beliefs(graph, seconds=0.2)
    counts = [math.log(math.comb(count, ones)) - math.comb(ones, 2) for ones in range(count + 1)]
    log_z = math.log(math.fsum(map(math.exp, counts)))
    one = math.fsum(math.exp(c) * ones / count for ones, c in enumerate(counts)) / math.exp(log_z)
    assert_contains(found, (log_z, [np.array([1 - one, one])] * count))


@LAW
@given(dense_graphs())
def test_an_exact_attempt_that_is_given_up_is_followed_by_cases(graph):
    exact = beliefs(graph)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solving, "small", lambda _part, _width: False)
        patch.setattr(solving, "ATTEMPT", 0.0)  # share of the time: it is over at its first look at the clock
        patch.setattr(solving, "_fair", lambda *_: True)
        found = solving.bounded(split(graph)[1][0], 20.0, Clock(60.0))
    assert found.low is found.high
    assert found.log_z[0] == (
        pytest.approx(exact.log_z[0] - graph.constant, abs=1e-11) if exact.log_z[0] > -math.inf else -math.inf
    )


def test_with_time_enough_a_deadline_changes_nothing():
    numbers = np.random.default_rng(3)
    pairs = [(v, u) for v in range(64) for u in (v + 1, v + 8) if u < 64 and (u != v + 1 or u % 8)]
    graph = FactorGraph((2,) * 64, tuple(Factor(pair, numbers.normal(size=(2, 2))) for pair in pairs))
    exact, direct, cases = beliefs(graph), beliefs(graph, seconds=60.0), beliefs(graph, width=6.0, seconds=60.0)
    assert direct.exact
    assert cases.exact
    assert direct.log_z == exact.log_z
    assert cases.log_z[0] == pytest.approx(exact.log_z[0], abs=1e-9)


def test_effort_decides_what_is_hopeless(monkeypatch):
    table = np.array([[0.0, 0.0], [0.0, -1.0]])
    graph = FactorGraph((2,) * 8, tuple(Factor((a, b), table) for a in range(8) for b in range(a + 1, 8)))
    assert beliefs(graph, width=3).exact
    monkeypatch.setattr(solving, "EFFORT", 4.0)
    with pytest.raises(WidthError, match=r"tables of 8\.0 bits"):
        beliefs(graph, width=3)


@LAW
@given(dense_graphs(), st.sampled_from((1.0, 2.0, 4.0)))
def test_a_cutset_leaves_no_table_too_wide(graph, width):
    _, (part,) = split(graph)
    cut = cutset(part, planned(part, FOREVER)[0], width, 64.0, FOREVER)
    gone = set(cut.fixed)
    assert len(gone) == len(cut.fixed)
    scopes = [[v for v in scope if v not in gone] for scope, _ in part.tables]
    assert order_along(cut.cards, scopes, cut.order.sequence) == cut.order
    assert cut.order.width <= max(width, math.log2(max(part.cards)))
    assert cutset(part, planned(part, FOREVER)[0], width, -1.0, FOREVER) is None or not gone


@LAW
@given(dense_graphs())
def test_where_cases_are_far_too_many_a_glance_bounds_the_sum(graph):
    exact = beliefs(graph)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solving, "MOST_CUT_BITS", 0.0)
        found = beliefs(graph, width=1.0, seconds=60.0)
    if found.exact:
        assert exact.log_z[0] == -math.inf
    else:
        assert_contains(found, (exact.log_z[0], exact.low))
        assert found.log_z[1] < math.inf


def test_probabilities_of_formulas_are_intervals_too():
    either = Or((Literal(0, frozenset({1})), Literal(1, frozenset({1}))))
    graph, (literal,) = with_formulas(FactorGraph((3, 2), (Factor((0, 1), np.zeros((3, 2))),)), (either,))
    assert probability(beliefs(graph, seconds=0.0), literal) == (0.0, 1.0)
    assert probability(beliefs(graph), literal) == pytest.approx((2 / 3, 2 / 3))
    half = Beliefs((0.0, 1.0), (np.array([0.1, 0.2, 0.3]),), (np.array([0.4, 0.5, 0.6]),))
    assert probability(half, Literal(0, frozenset({1, 2}))) == pytest.approx((0.6, 0.9))
