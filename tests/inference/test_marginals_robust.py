"""Weak and extreme weights: nothing underflows, nothing raises, and plain numbers give what logarithms give."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.inference import order
from plogic.inference import passes as steps
from plogic.inference.graph import Factor, FactorGraph
from plogic.inference.marginals import beliefs, plan
from plogic.inference.order import bucket_tree, elimination_order
from plogic.inference.passes import two_way

LAW = settings(derandomize=True, deadline=None, max_examples=80)


def grid(rows, columns, seed, penalty=-math.inf):
    """Binary, neighbours conflict, unary weights at random."""
    numbers = np.random.default_rng(seed)
    hard = np.array([[0.0, 0.0], [0.0, penalty]])
    factors = [Factor((v,), np.array([0.0, numbers.normal()])) for v in range(rows * columns)]
    for v in range(rows * columns):
        if (v + 1) % columns:
            factors.append(Factor((v, v + 1), hard))
        if v + columns < rows * columns:
            factors.append(Factor((v, v + columns), hard))
    return FactorGraph((2,) * (rows * columns), tuple(factors))


def by_rows(graph, rows, columns):
    """The log of the sum of weights by a transfer matrix between whole rows: an oracle that shares no code."""
    ones = np.array([[math.exp(t) for t in f.table] for f in graph.factors[: rows * columns]])
    pair = math.exp(graph.factors[-1].table[1, 1])
    states = np.array([[s >> c & 1 for c in range(columns)] for s in range(2**columns)])
    within = pair ** (states[:, :-1] * states[:, 1:]).sum(axis=1)
    between = pair ** (states @ states.T)
    total = np.ones(len(states))
    for row in range(rows):
        own = within * np.prod(ones[row * columns + np.arange(columns), states], axis=1)
        total = own * (between @ total if row else total)
    return math.log(total.sum())


@pytest.mark.parametrize("penalty", [-math.inf, -2.0])
def test_grids_against_transfer_matrices(penalty):
    graph = grid(9, 7, 3, penalty)
    assert beliefs(graph).log_z[0] == pytest.approx(by_rows(graph, 9, 7), abs=1e-10)


def test_a_large_grid_keeps_what_its_reflection_keeps():
    rows, columns = 13, 13
    graph = grid(rows, columns, 1)
    mirror = [v // columns * columns + columns - 1 - v % columns for v in range(rows * columns)]
    turned = FactorGraph(graph.cards, tuple(_renamed(f, mirror) for f in graph.factors))
    one, other = beliefs(graph), beliefs(turned)
    assert one.log_z[0] == pytest.approx(other.log_z[0], abs=1e-10)
    for v, image in enumerate(mirror):
        np.testing.assert_allclose(one.low[v], other.low[image], rtol=1e-10, atol=1e-12)


def _renamed(factor, names):
    scope = [names[v] for v in factor.scope]
    return Factor(tuple(sorted(scope)), factor.table.transpose(np.argsort(scope)))


@st.composite
def extreme_grids(draw):
    """Small grids with offsets and spreads far beyond what a double holds."""
    graph = grid(
        draw(st.integers(2, 4)),
        draw(st.integers(2, 4)),
        draw(st.integers(0, 9)),
        draw(st.sampled_from((-math.inf, -1.0, -400.0))),
    )
    offsets = st.sampled_from((0.0, -2000.0, 900.0))
    scales = st.sampled_from((1.0, 1.0, 50.0, 500.0))
    return FactorGraph(
        graph.cards, tuple(Factor(f.scope, _scaled(f.table, draw(scales)) + draw(offsets)) for f in graph.factors)
    )


def _scaled(table, scale):
    return np.where(table == 0.0, 0.0, table * scale)


def passes(graph, monkeypatch, large):
    monkeypatch.setattr(order, "BUCKET_CELLS", 1)
    monkeypatch.setattr(steps, "LARGE_PRODUCT", large)
    tables = tuple((f.scope, f.table) for f in graph.factors)
    scopes = [scope for scope, _ in tables]
    buckets = bucket_tree(graph.cards, scopes, elimination_order(graph.cards, scopes))
    return two_way(graph.cards, tables, buckets, lambda: None)


@LAW
@given(extreme_grids())
def test_plain_numbers_give_what_logarithms_give(graph):
    with pytest.MonkeyPatch.context() as patch:
        plain = passes(graph, patch, 1)
        logs = passes(graph, patch, 1 << 60)
    assert plain[0] == pytest.approx(logs[0], rel=1e-13, abs=1e-10)
    for one, other in zip(plain[1], logs[1], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("limits", [("KEPT_CELLS",), ("KEPT_CELLS", "HELD")])
def test_weighing_again_gives_the_same_bytes(monkeypatch, limits):
    graph = grid(11, 11, 2)
    kept = beliefs(graph)
    for limit in limits:
        monkeypatch.setattr(f"plogic.inference.passes.{limit}", 0)
    again = beliefs(graph)
    assert kept.log_z == again.log_z
    assert [a.tobytes() for a in kept.low] == [a.tobytes() for a in again.low]


def test_thousands_of_weak_factors():
    numbers = np.random.default_rng(0)
    balance = [0.0] * 40
    factors = []
    for _ in range(6000):
        v = int(numbers.integers(40))
        gain = float(numbers.normal())
        balance[v] += gain
        factors.append(Factor((v,), np.array([-50.0, -50.0 + gain])))
    found = beliefs(FactorGraph((2,) * 40, tuple(factors), 0.0))
    for v, gain in enumerate(balance):
        assert found.low[v][1] == pytest.approx(1 / (1 + math.exp(-gain)), abs=1e-9)
    assert found.log_z[0] == pytest.approx(-300000 + sum(math.log1p(math.exp(gain)) for gain in balance), rel=1e-13)


def test_likelihoods_of_1e_300_on_a_chain():
    weak = math.log(1e-300)
    count = 2000
    factors = [
        Factor((v, v + 1), np.array([[weak, 2 * weak], [2 * weak, weak + math.log(2)]])) for v in range(count - 1)
    ]
    found = beliefs(FactorGraph((2,) * count, tuple(factors)))
    assert found.log_z[0] == pytest.approx((count - 1) * (weak + math.log(2)), rel=1e-13)
    assert found.low[0][1] == pytest.approx(1.0)
    assert found.low[7][0] < 1e-290


def test_what_only_the_least_weights_allow_is_found():
    steps = [Factor((v, v + 1), np.array([[0.0, -900.0], [-900.0, -1800.0]])) for v in range(20)]
    only = [Factor((v,), np.array([-math.inf, 0.0])) for v in range(21)]
    found = beliefs(FactorGraph((2,) * 21, (*steps, *only)))
    assert found.log_z == (-36000.0, -36000.0)
    assert all(low.tolist() == [0.0, 1.0] for low in found.low)


def test_the_same_question_gets_the_same_bytes():
    graph = grid(10, 6, 4)
    first = beliefs(graph)
    plan.cache_clear()
    second = beliefs(graph)
    assert first.log_z == second.log_z
    assert [a.tobytes() for a in first.low] == [a.tobytes() for a in second.low]


def test_weights_of_1e300_neither_overflow_nor_warn():
    table = np.array([[0.0, -1e300], [-1e300, 0.0]])
    found = beliefs(FactorGraph((2,) * 15, tuple(Factor((v, v + 1), table) for v in range(14))))
    assert found.log_z[0] == pytest.approx(math.log(2))
    assert all(low.tolist() == [0.5, 0.5] for low in found.low)
