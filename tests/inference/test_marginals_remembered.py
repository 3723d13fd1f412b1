"""Remembered pieces: the same bytes as without, and only what changed is solved."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.inference.graph import Factor, FactorGraph
from plogic.inference.marginals import Remembered, beliefs


def pairs(count, seed=0):
    """Pieces of two variables each."""
    numbers = np.random.default_rng(seed)
    return FactorGraph(
        (2, 3) * count, tuple(Factor((2 * i, 2 * i + 1), numbers.normal(size=(2, 3))) for i in range(count))
    )


def with_factor(graph, factor):
    return FactorGraph(graph.cards, (*graph.factors, factor), graph.constant)


def as_bytes(found):
    return found.log_z, [low.tobytes() for low in found.low], [high.tobytes() for high in found.high]


def test_only_the_touched_piece_is_solved_again():
    memory, graph = Remembered(), pairs(10)
    memory.beliefs(graph)
    assert memory.solved == 10
    more = with_factor(graph, Factor((4,), np.array([0.0, -1.0])))
    memory.beliefs(more)
    assert memory.solved == 11
    memory.beliefs(with_factor(graph, Factor((0, 6), np.array([[0.0, -1.0], [-1.0, 0.0]]))))
    assert memory.solved == 12
    assert as_bytes(memory.beliefs(graph)) == as_bytes(beliefs(graph))
    assert memory.solved == 12


def test_equal_pieces_are_solved_once_and_the_oldest_are_forgotten():
    one = np.array([0.0, -2.0])
    memory = Remembered(2)
    memory.beliefs(FactorGraph((2, 2, 2), tuple(Factor((v,), one) for v in range(3))))
    assert memory.solved == 1
    memory.beliefs(pairs(2))
    memory.beliefs(FactorGraph((2,), (Factor((0,), one),)))
    assert memory.solved == 4


@settings(derandomize=True, deadline=None, max_examples=40)
@given(st.lists(st.tuples(st.integers(0, 11), st.sampled_from((-np.inf, -1.0, 0.5))), max_size=6))
def test_bytes_are_those_of_no_memory(changes):
    memory, graph = Remembered(), pairs(6)
    for v, weight in changes:
        table = np.zeros(graph.cards[v])
        table[1] = weight
        graph = with_factor(graph, Factor((v,), table))
        assert as_bytes(memory.beliefs(graph)) == as_bytes(beliefs(graph))
    assert as_bytes(memory.beliefs(pairs(6))) == as_bytes(beliefs(pairs(6)))


def test_an_interval_is_not_remembered():
    memory, graph = Remembered(), pairs(3)
    assert not memory.beliefs(graph, seconds=0.0).exact
    assert memory.beliefs(graph).exact
    assert memory.beliefs(graph, seconds=0.0).exact


def test_an_impossible_piece_makes_all_impossible():
    memory = Remembered()
    graph = with_factor(pairs(2), Factor((0,), np.full(2, -np.inf)))
    assert memory.beliefs(graph).log_z == (-np.inf, -np.inf)
    assert all(np.isnan(low).all() for low in memory.beliefs(graph).low)
    assert memory.beliefs(pairs(2)).log_z[0] == pytest.approx(beliefs(pairs(2)).log_z[0])
