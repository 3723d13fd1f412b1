"""The marginals and the sum of weights, against the enumeration of all joint states."""

import itertools
import math

import numpy as np
import pytest
from factor_graphs import log_weight
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.base.errors import WidthError
from plogic.inference import marginals, order
from plogic.inference.graph import Factor, FactorGraph
from plogic.inference.marginals import beliefs, summed_out

LAW = settings(derandomize=True, deadline=None, max_examples=150)

weights = st.one_of(st.just(-math.inf), st.floats(-40, 5), st.sampled_from((0.0, -700.0, -1e-9)))


@st.composite
def graphs(draw, most=7, cards=(1, 2, 2, 2, 3, 4)):
    sizes = tuple(draw(st.lists(st.sampled_from(cards), max_size=most)))
    scopes = draw(st.lists(st.sets(st.integers(0, len(sizes) - 1), max_size=3), max_size=9)) if sizes else []
    factors = []
    for scope in (tuple(sorted(s)) for s in scopes):
        shape = [sizes[v] for v in scope]
        cells = draw(st.lists(weights, min_size=math.prod(shape), max_size=math.prod(shape)))
        factors.append(Factor(scope, np.array(cells).reshape(shape)))
    return FactorGraph(sizes, tuple(factors), draw(st.sampled_from((0.0, -3.0, -2000.0))))


def enumerated(graph):
    """(ln Σ weights, belief of every variable), NaN where nothing is possible."""
    logs = {states: log_weight(graph, states) for states in itertools.product(*(range(c) for c in graph.cards))}
    top = max(logs.values())
    if top == -math.inf:
        return top, [np.full(c, np.nan) for c in graph.cards]
    scaled = {states: math.exp(log - top) for states, log in logs.items()}
    total = math.fsum(scaled.values())
    return top + math.log(total), [
        np.array([_mass(scaled, v, s) for s in range(c)]) / total for v, c in enumerate(graph.cards)
    ]


def _mass(scaled, variable, state):
    return math.fsum(w for states, w in scaled.items() if states[variable] == state)


def assert_agrees(found, graph):
    log_z, singles = enumerated(graph)
    assert found.exact
    assert found.log_z[0] == log_z or math.isclose(found.log_z[0], log_z, rel_tol=1e-12, abs_tol=1e-11)
    assert len(found.low) == len(singles)
    for low, expected in zip(found.low, singles, strict=True):
        np.testing.assert_allclose(low, expected, rtol=1e-9, atol=1e-11)


@LAW
@given(graphs())
def test_joint_tables_agree(graph):
    assert_agrees(beliefs(graph), graph)


@LAW
@given(graphs())
def test_two_passes_agree(graph):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(marginals, "BUCKET_CELLS", 1)
        patch.setattr(order, "BUCKET_CELLS", 1)
        marginals.plan.cache_clear()
        assert_agrees(beliefs(graph), graph)
    marginals.plan.cache_clear()


@LAW
@given(graphs(), st.sets(st.integers(0, 6)))
def test_summing_out_keeps_what_is_left(graph, gone):
    gone = {v for v in gone if v < len(graph.cards)}
    rest = summed_out(graph, gone)
    before, after = beliefs(graph), beliefs(rest)
    assert rest.cards == tuple(1 if v in gone else c for v, c in enumerate(graph.cards))
    assert after.log_z[0] == before.log_z[0] or math.isclose(
        after.log_z[0], before.log_z[0], rel_tol=1e-12, abs_tol=1e-11
    )
    for v in set(range(len(graph.cards))) - gone:
        np.testing.assert_allclose(after.low[v], before.low[v], rtol=1e-9, atol=1e-11)


@LAW
@given(graphs(), st.randoms(use_true_random=False))
def test_renaming_and_reordering_change_nothing(graph, random):
    names = list(range(len(graph.cards)))
    random.shuffle(names)
    factors = [_renamed(f, names) for f in graph.factors]
    random.shuffle(factors)
    cards = [0] * len(names)
    for v, name in enumerate(names):
        cards[name] = graph.cards[v]
    one, other = beliefs(graph), beliefs(FactorGraph(tuple(cards), tuple(factors), graph.constant))
    assert one.log_z[0] == other.log_z[0] or math.isclose(one.log_z[0], other.log_z[0], rel_tol=1e-12, abs_tol=1e-11)
    for v, name in enumerate(names):
        np.testing.assert_allclose(one.low[v], other.low[name], rtol=1e-10, atol=1e-13)


def _renamed(factor, names):
    scope = [names[v] for v in factor.scope]
    return Factor(tuple(sorted(scope)), factor.table.transpose(np.argsort(scope)) if scope else factor.table)


def test_pieces_multiply():
    table = np.array([[0.3, -1.0], [0.0, 2.0]])
    one = beliefs(FactorGraph((2, 2), (Factor((0, 1), table),)))
    three = beliefs(FactorGraph((2,) * 6, tuple(Factor((v, v + 3), table) for v in range(3)), 1.0))
    assert three.log_z[0] == pytest.approx(1.0 + 3 * one.log_z[0])
    assert [low.tobytes() for low in three.low] == [low.tobytes() for low in one.low for _ in range(3)]


def test_nothing_is_certain():
    assert beliefs(FactorGraph((), ())).log_z == (0.0, 0.0)
    assert beliefs(FactorGraph((), (), -math.inf)).log_z == (-math.inf, -math.inf)


def test_beliefs_are_read_only():
    found = beliefs(FactorGraph((2, 2, 1), (Factor((0,), np.zeros(2)),)))
    assert not any(low.flags.writeable for low in found.low)


def test_summing_out_past_the_width_says_so():
    star = FactorGraph((2,) * 12, tuple(Factor((0, v), np.zeros((2, 2))) for v in range(1, 12)))
    with pytest.raises(WidthError, match=r"variable 0 .* 12\.0 bits; the limit is 11"):
        summed_out(star, (0,), width=11)
    assert summed_out(star, range(1, 12), width=2).cards == (2, *(1,) * 11)


def test_a_chain_of_many_variables_against_matrix_products():
    numbers = np.random.default_rng(7)
    tables = [numbers.normal(size=(3, 3)) for _ in range(120)]
    graph = FactorGraph((3,) * 121, tuple(Factor((v, v + 1), table) for v, table in enumerate(tables)))
    found = beliefs(graph)
    forward, backward = [np.ones(3)], [np.ones(3)]
    for table in tables:
        forward.append(_scaled(forward[-1] @ np.exp(table)))
    for table in reversed(tables):
        backward.append(_scaled(np.exp(table) @ backward[-1]))
    assert len(found.low) == 121
    for low, f, b in zip(found.low, forward, reversed(backward), strict=True):
        np.testing.assert_allclose(low, f * b / (f * b).sum(), rtol=1e-11)


def _scaled(vector):
    return vector / vector.sum()
