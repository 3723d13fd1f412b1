"""Elimination orders: what they claim about tables is what elimination by definition makes."""

import math

import networkx as nx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.inference.order import elimination_order, members, min_fill, neighbours, order_along, sweep

LAW = settings(derandomize=True, deadline=None, max_examples=100)

scopes_of = st.integers(1, 9).flatmap(
    lambda count: st.tuples(
        st.lists(st.integers(1, 4), min_size=count, max_size=count),
        st.lists(st.sets(st.integers(0, count - 1), max_size=4).map(lambda s: tuple(sorted(s))), max_size=10),
    ),
)


def eliminated(count, scopes, sequence):
    """Neighbours at their turn, by definition."""
    graph = nx.Graph()
    graph.add_nodes_from(range(count))
    graph.add_edges_from((a, b) for scope in scopes for a in scope for b in scope if a < b)
    rests = {}
    for v in sequence:
        around = set(graph[v])
        rests[v] = around
        graph.add_edges_from((a, b) for a in around for b in around if a < b)
        graph.remove_node(v)
    return rests


def grid_scopes(rows, columns):
    across = [(v, v + 1) for v in range(rows * columns) if (v + 1) % columns]
    return across + [(v, v + columns) for v in range((rows - 1) * columns)]


@LAW
@given(scopes_of)
def test_rests_width_and_work_are_those_of_the_sequence(drawn):
    cards, scopes = drawn
    order = elimination_order(cards, scopes)
    rests = eliminated(len(cards), scopes, order.sequence)
    assert sorted(order.sequence) == list(range(len(cards)))
    assert {v: set(members(order.rests[v])) for v in order.sequence} == rests
    cells = [math.prod(cards[u] for u in {v, *around}) for v, around in rests.items()]
    assert order.width == pytest.approx(math.log2(max(cells)))
    assert order.work == pytest.approx(math.log2(sum(cells)))


@LAW
@given(scopes_of)
def test_min_fill_takes_the_least_fill_then_the_smaller_table_then_the_lower_number(drawn):
    cards, scopes = drawn
    sequence, _ = min_fill(neighbours(len(cards), scopes), cards, range(len(cards)))
    assert sorted(sequence) == list(range(len(cards)))
    graph = neighbours(len(cards), scopes)
    left = set(range(len(cards)))
    for v in sequence:
        assert v == min(left, key=lambda u: (_fill(graph, u), math.prod(cards[w] for w in (u, *members(graph[u]))), u))
        left.remove(v)
        around = graph[v]
        graph = [(mask | around if around >> u & 1 else mask) & ~(1 << u) & ~(1 << v) for u, mask in enumerate(graph)]
        graph[v] = 0


def _fill(graph, v):
    around = members(graph[v])
    return sum(1 for a in around for b in around if a < b and not graph[a] >> b & 1)


@LAW
@given(scopes_of)
def test_a_sweep_takes_from_its_boundary_what_brings_the_fewest_new_bits_then_the_oldest(drawn):
    cards, scopes = drawn
    graph = neighbours(len(cards), scopes)
    around, bits = [set(members(mask)) for mask in graph], [math.log2(card) for card in cards]
    boundary, gone = [], set()
    for v in sweep(graph, bits):
        boundary = boundary or [v]  # where a piece begins
        fresh = set(range(len(cards))) - gone - set(boundary)
        brings = {u: round(sum(bits[w] for w in around[u] & fresh) - bits[u], 9) for u in boundary}
        assert v == min(boundary, key=brings.__getitem__)
        boundary = [u for u in boundary if u != v] + sorted(around[v] & fresh)
        gone.add(v)
    assert len(gone) == len(cards)


@pytest.mark.parametrize("side", [13, 16, 19])
def test_square_grids_get_tables_of_one_row_and_one_variable(side):
    assert elimination_order([2] * side * side, grid_scopes(side, side)).width <= side + 1


def test_a_tree_needs_no_more_than_its_edges():
    tree = nx.random_labeled_tree(300, seed=4)
    assert elimination_order([2] * 300, [tuple(sorted(edge)) for edge in tree.edges]).width == 2.0


def test_a_given_sequence_is_followed():
    order = order_along((2, 2, 2), ((0, 1), (1, 2)), (1, 0, 2))
    assert order.sequence == (1, 0, 2)
    assert order.width == 3.0


def test_nothing_to_order():
    assert elimination_order((), ()).width == 0.0
