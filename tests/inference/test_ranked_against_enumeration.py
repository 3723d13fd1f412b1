"""The ranking of joint states, against the enumeration of them all; by every way that a piece can be ranked."""

import contextlib
import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from factor_graphs import log_weight
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.inference import marginals, order, ranked_component
from plogic.inference import ranked as ranking
from plogic.inference.graph import Factor, FactorGraph
from plogic.inference.marginals import beliefs
from plogic.inference.ranked import Ranked, best

LAW = settings(derandomize=True, deadline=None, max_examples=30)

# module, name, value: what makes small graphs go the way of large ones
PIECES = (ranking, "STATES", 0)
TREES = (PIECES, (ranking, "JOINT_CELLS", 0))
WAYS = {
    "whole": (),
    "joint": (PIECES,),
    "tree": (*TREES, (order, "BUCKET_CELLS", 1)),
    "merged": (*TREES, (order, "BUCKET_CELLS", 12)),
    "apart": (*TREES, (order, "BUCKET_CELLS", 12), (ranked_component, "SUMMED", 0)),
    "forgetful": (*TREES, (order, "BUCKET_CELLS", 1), (ranked_component, "KEPT_COSTS", 0)),
    "wide": (*TREES, (ranking, "WIDTH", -1.0)),
    "bounded": (*TREES, (ranking, "WIDTH", -1.0), (ranked_component, "BITS", (1.0,))),
}
every_way = pytest.mark.parametrize("way", WAYS)

weights = st.one_of(st.just(-math.inf), st.floats(-40, 5), st.sampled_from((0.0, -700.0, -1e-9)))
halves = st.one_of(st.just(-math.inf), st.integers(-4, 1).map(lambda n: n / 2))
extremes = st.sampled_from(
    (-math.inf, 0.0, -1e-12, 1e-12, -1e5, -1e5 - 1e-10, 1e5, -1e8, -1e30, 1e30, -1e300, 3.7, -2.1)
)


@st.composite
def graphs(draw, entries=weights, most=6, cards=(1, 2, 2, 2, 3, 4)):
    sizes = tuple(draw(st.lists(st.sampled_from(cards), max_size=most)))
    scopes = draw(st.lists(st.sets(st.integers(0, len(sizes) - 1), max_size=3), max_size=9)) if sizes else []
    factors = []
    for scope in (tuple(sorted(s)) for s in scopes):
        shape = [sizes[v] for v in scope]
        cells = draw(st.lists(entries, min_size=math.prod(shape), max_size=math.prod(shape)))
        factors.append(Factor(scope, np.array(cells).reshape(shape)))
    return FactorGraph(sizes, tuple(factors), draw(st.sampled_from((0.0, -3.0, -2000.0))))


@contextlib.contextmanager
def going(way):
    with pytest.MonkeyPatch.context() as patch:
        for module, name, value in WAYS[way]:
            patch.setattr(module, name, value)
        marginals.plan.cache_clear()
        yield
    marginals.plan.cache_clear()


def enumerated(graph):
    """All joint states of positive weight, heaviest first, ties lexicographic."""
    every = ((log_weight(graph, states), states) for states in itertools.product(*(range(c) for c in graph.cards)))
    return sorted((one for one in every if one[0] > -math.inf), key=lambda one: (-one[0], one[1]))


@every_way
@LAW
@given(graph=graphs())
def test_every_state_once_by_falling_weight(way, graph):
    expected = enumerated(graph)
    with going(way):
        found = list(Ranked(graph))
    assert sorted(states for _, states in found) == sorted(states for _, states in expected)
    np.testing.assert_allclose([w for w, _ in found], [w for w, _ in expected], rtol=1e-12, atol=1e-9)
    assert all(a >= b for (a, _), (b, _) in itertools.pairwise(found))
    for weight, states in found:
        assert math.isclose(weight, log_weight(graph, states), rel_tol=1e-12, abs_tol=1e-9)


@every_way
@LAW
@given(graph=graphs(halves, most=5))
def test_ties_are_lexicographic(way, graph):
    with going(way):
        assert list(Ranked(graph)) == enumerated(graph)


@pytest.mark.parametrize("way", ["whole", "joint", "tree", "merged", "apart", "forgetful"])
@LAW
@given(graph=graphs(halves))
def test_exact_ties_are_lexicographic_without_looking_ahead(way, graph):
    with going(way), pytest.MonkeyPatch.context() as patch:
        patch.setattr(ranking, "MOST_TIES", 1)
        assert list(Ranked(graph)) == enumerated(graph)


@every_way
@LAW
@given(graph=graphs(extremes, most=4))
def test_extreme_weights_keep_their_order(way, graph):
    with going(way):
        found = [states for _, states in Ranked(graph)]
    possible = [states for _, states in enumerated(graph)]
    assert sorted(found) == sorted(possible)
    weights = [_exact(graph, states) for states in found]
    for (a, noise), (b, more) in itertools.pairwise(weights):
        assert a >= b - Fraction(2, 10**11) - max(noise, more)


def _exact(graph, states):
    """(log weight without rounding, what rounding each entry once to a double may change)."""
    entries = [Fraction(float(f.table[tuple(states[v] for v in f.scope)])) for f in graph.factors]
    return sum(entries, Fraction(0)), sum((abs(e) for e in entries), Fraction(0)) * Fraction(1, 2**50)


@LAW
@given(graph=graphs(), n=st.integers(0, 5), m=st.integers(0, 40))
def test_the_first_n_are_a_prefix_of_more(graph, n, m):
    assert best(graph, n) == best(graph, n + m)[:n]


@LAW
@given(graph=graphs())
def test_weights_sum_to_the_partition_function(graph):
    log_z = beliefs(graph).log_z[0]
    total = (
        math.fsum(math.exp(weight - log_z) for weight, _ in Ranked(graph))
        if log_z > -math.inf
        else len(list(Ranked(graph)))
    )
    assert total == pytest.approx(1.0 if log_z > -math.inf else 0.0, abs=1e-9)


@LAW
@given(graph=graphs())
def test_enough_time_finds_all(graph):
    timed = Ranked(graph, seconds=3600.0)
    assert list(timed) == list(Ranked(graph)) == timed.states
    assert timed.finished


@every_way
@LAW
@given(graph=graphs(most=5), data=st.data())
def test_reordering_the_factors_changes_nothing(way, graph, data):
    shuffled = FactorGraph(graph.cards, tuple(data.draw(st.permutations(graph.factors))), graph.constant)
    with going(way):
        found, other = list(Ranked(graph)), list(Ranked(shuffled))
    np.testing.assert_allclose([w for w, _ in found], [w for w, _ in other], rtol=1e-12, atol=1e-9)
    assert {states for _, states in found} == {states for _, states in other}
