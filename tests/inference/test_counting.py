"""How many literals hold, against the enumeration of every joint state."""

import itertools
import math

import numpy as np
import pytest
from factor_graphs import log_weight
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.inference.counting import counted
from plogic.inference.gates import Literal
from plogic.inference.graph import Factor, FactorGraph
from plogic.inference.marginals import beliefs

CARDS = (2, 3, 2, 1, 4)


def weighed():
    """Two pieces of two and three variables, one joint state of which is impossible, and a variable of one state."""
    numbers = np.random.default_rng(5)
    factors = [Factor((a, b), numbers.normal(size=(CARDS[a], CARDS[b]))) for a, b in ((0, 1), (1, 4), (2, 3))]
    factors[0].table[1, 2] = -np.inf
    return FactorGraph(CARDS, tuple(factors), -7.0)


def enumerated(graph, literals):
    masses = [0.0] * (len(literals) + 1)
    for states in itertools.product(*(range(card) for card in graph.cards)):
        masses[sum(states[one.variable] in one.states for one in literals)] += math.exp(log_weight(graph, states))
    return [mass / math.fsum(masses) for mass in masses]


@settings(derandomize=True, deadline=None, max_examples=100)
@given(st.dictionaries(st.integers(0, len(CARDS) - 1), st.frozensets(st.integers(0, 3), max_size=3)))
def test_a_count_has_the_mass_of_the_states_in_which_so_many_hold(states):
    graph, literals = weighed(), [Literal(v, some) for v, some in states.items()]
    found = counted(graph, literals, beliefs)
    assert [low for low, _ in found] == pytest.approx(enumerated(graph, literals), abs=1e-12)
    assert [high for _, high in found] == pytest.approx(enumerated(graph, literals), abs=1e-12)


def test_nothing_is_counted_as_none():
    assert counted(weighed(), [], beliefs) == [(1.0, 1.0)]


def test_many_of_one_piece_are_counted_without_listing_their_states():
    """A chain of 60 variables, each like the one before with odds of e to 1, has 2 ** 60 joint states."""
    factors = tuple(Factor((i, i + 1), np.eye(2)) for i in range(59))
    found = counted(FactorGraph((2,) * 60, factors), [Literal(i, frozenset({1})) for i in range(60)], beliefs)
    assert sum(low for low, _ in found) == pytest.approx(1.0)
    assert [low for low, _ in found] == pytest.approx([high for high, _ in reversed(found)])
    assert sum(k * low for k, (low, _) in enumerate(found)) == pytest.approx(30.0)
