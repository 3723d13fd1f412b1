"""The ranking of joint states: what large, tied, hopeless and hurried graphs give."""

import itertools
import math

import numpy as np
import pytest
from factor_graphs import log_weight

from plogic.base.errors import LimitError
from plogic.inference import ranked as ranking
from plogic.inference import ranked_component
from plogic.inference.graph import Factor, FactorGraph
from plogic.inference.ranked import Ranked, best

EXCLUSIVE = np.array([[0.0, 0.0], [0.0, -np.inf]])


def binary(number):
    return tuple(int(digit) for digit in number)


def grid(rows, columns, singles):
    """Neighbours exclude each other."""
    factors = [Factor((v,), np.array([0.0, w])) for v, w in enumerate(singles)]
    for v in range(rows * columns):
        if (v + 1) % columns:
            factors.append(Factor((v, v + 1), EXCLUSIVE))
        if v + columns < rows * columns:
            factors.append(Factor((v, v + columns), EXCLUSIVE))
    return FactorGraph((2,) * (rows * columns), tuple(factors))


def test_no_variable_is_one_state_of_the_constant_weight():
    assert list(Ranked(FactorGraph((), (), -1.5))) == [(-1.5, ())]


def test_factors_over_no_variable_count():
    assert list(Ranked(FactorGraph((1,), (Factor((), np.array(-2.0)), Factor((0,), np.array([0.5])))))) == [
        (-1.5, (0,))
    ]


@pytest.mark.parametrize(
    "graph",
    [
        FactorGraph((2, 2), (), -math.inf),
        FactorGraph((2, 2), (Factor((), np.array(-np.inf)),)),
        FactorGraph((2, 2), (Factor((1,), np.array([-np.inf, -np.inf])),)),
        FactorGraph((1,), (Factor((0,), np.array([-np.inf])),)),
        FactorGraph(
            (2, 2),
            (Factor((0, 1), np.array([[-np.inf, 0.0], [-np.inf, -np.inf]])), Factor((1,), np.array([0.0, -np.inf]))),
        ),
    ],
)
def test_what_is_impossible_has_no_states(graph):
    found = Ranked(graph)
    assert list(found) == []
    assert found.finished


def test_sixty_equal_variables_begin_lexicographically():
    expected = [binary(f"{n:060b}") for n in range(10)]
    assert [states for _, states in best(FactorGraph((2,) * 60, ()), 10)] == expected
    chain = FactorGraph((2,) * 60, tuple(Factor((v, v + 1), np.zeros((2, 2))) for v in range(59)))
    assert [states for _, states in best(chain, 10)] == expected


def test_a_tied_grid_begins_lexicographically():
    found = [states for _, states in best(grid(5, 8, [0.0] * 40), 600)]
    allowed = (binary(f"{n:040b}") for n in itertools.count())
    neighbours = [f.scope for f in grid(5, 8, []).factors]
    assert found == list(itertools.islice((s for s in allowed if not any(s[a] and s[b] for a, b in neighbours)), 600))


def test_ties_among_many_states_come_after_what_is_heavier():
    graph = FactorGraph((2,) * 40, (Factor((39,), np.array([0.0, 1.0])),))
    assert [states for _, states in best(graph, 3)] == [binary(f"{n:040b}") for n in (1, 3, 5)]


def test_weights_that_differ_by_rounding_tie():
    pairs = np.log(np.array([0.1, 0.2])), np.log(np.array([0.2, 0.1]))
    noisy = FactorGraph((2, 2), (Factor((0,), pairs[0]), Factor((1,), pairs[1] + 3e-12)))
    assert [states for _, states in Ranked(noisy)] == [(1, 0), (0, 0), (1, 1), (0, 1)]


def test_ties_beyond_the_look_ahead_still_all_come(monkeypatch):
    monkeypatch.setattr(ranking, "MOST_TIES", 3)
    rng = np.random.default_rng(3)
    graph = FactorGraph((2,) * 6, tuple(Factor((v,), rng.normal(scale=1e-12, size=2)) for v in range(6)))
    found = list(Ranked(graph))
    assert {states for _, states in found} == set(itertools.product((0, 1), repeat=6))
    assert all(a >= b for (a, _), (b, _) in itertools.pairwise(found))


def test_a_long_chain_does_not_exhaust_the_stack():
    rng = np.random.default_rng(1)
    tables = rng.normal(size=(2999, 2, 2))
    graph = FactorGraph((2,) * 3000, tuple(Factor((v, v + 1), table) for v, table in enumerate(tables)))
    found = best(graph, 5)
    assert found[0][0] == pytest.approx(_viterbi(tables), abs=1e-8)
    assert all(log_weight(graph, states) == pytest.approx(weight, abs=1e-8) for weight, states in found)
    assert len({states for _, states in found}) == 5


def _viterbi(tables):
    best_so_far = np.zeros(2)
    for table in tables:
        best_so_far = (best_so_far[:, None] + table).max(axis=0)
    return float(best_so_far.max())


def test_a_star_with_a_thousand_leaves():
    leaves = tuple(Factor((0, v), np.array([[0.0, -1.0], [-2.0, -0.5]])) for v in range(1, 1001))
    found = best(FactorGraph((2,) * 1001, leaves), 3)
    assert [round(weight, 9) for weight, _ in found] == [0.0, -1.0, -1.0]
    assert [np.flatnonzero(states).tolist() for _, states in found] == [[], [1000], [999]]


def test_many_states_of_one_variable():
    weights = -np.arange(70_000.0)
    found = best(FactorGraph((70_000, 2), (Factor((0,), weights), Factor((0, 1), np.zeros((70_000, 2))))), 5)
    assert [states for _, states in found] == [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0)]


def test_a_wide_grid_agrees_with_the_exact_heuristic(monkeypatch):
    rng = np.random.default_rng(5)
    graph = grid(5, 6, rng.normal(size=30))
    expected = best(graph, 50)
    monkeypatch.setattr(ranking, "WIDTH", 3.0)
    for bits in (3.0, 5.0, 12.0):
        monkeypatch.setattr(ranked_component, "BITS", (bits,))
        found = best(graph, 50)
        assert [states for _, states in found] == [states for _, states in expected]
        assert [weight for weight, _ in found] == pytest.approx([weight for weight, _ in expected], abs=1e-11)


def test_too_many_open_nodes_say_so(monkeypatch):
    monkeypatch.setattr(ranking, "WIDTH", 3.0)
    monkeypatch.setattr(ranked_component, "BITS", (2.0,))
    monkeypatch.setattr(ranked_component, "MOST_OPEN_NODES", 20)
    with pytest.raises(LimitError, match=r"36 variables .* more than 20 partial states"):
        best(grid(6, 6, np.random.default_rng(5).normal(size=36)), 50)


def test_no_time_gives_a_part_and_says_so():
    graph = grid(5, 6, np.random.default_rng(5).normal(size=30))
    late = Ranked(graph, seconds=0.0)
    assert list(late) == []
    assert not late.finished


def test_what_was_found_in_time_is_a_prefix():
    graph = grid(9, 9, np.random.default_rng(5).normal(size=81))
    hurried = Ranked(graph, seconds=0.2)
    found = list(hurried)
    assert found == hurried.states
    assert not hurried.finished
    assert [states for _, states in found] == [states for _, states in best(graph, len(found))]
