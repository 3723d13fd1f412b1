"""Sums of cost tables and their cells in order, against numpy's plain sums and a stable sort of all cells."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.inference import ranked_tables
from plogic.inference.ranked_tables import Cells, least, placed, total

LAW = settings(derandomize=True, deadline=None, max_examples=40)
IMPOSSIBLE = 1 << 58


@st.composite
def tables(draw):
    """Costs with many ties or few, some impossible, small and large."""
    size = draw(st.sampled_from((1, 2, 7, 64, 65, 300, 3000)))
    most = draw(st.sampled_from((0, 3, 50, 10**6)))
    numbers = np.random.default_rng(draw(st.integers(0, 10**6)))
    table = numbers.integers(0, most + 1, size=size)
    table[numbers.random(size) < draw(st.sampled_from((0.0, 0.4, 1.0)))] = IMPOSSIBLE + draw(st.integers(0, 5))
    return table


@LAW
@given(tables(), st.booleans())
def test_cells_come_as_a_stable_sort_puts_them(table, objects):
    possible = int((table < IMPOSSIBLE).sum())
    order = table.argsort(kind="stable")[:possible]
    cells = Cells(table.astype(object) if objects else table, IMPOSSIBLE)
    assert all(cells.reach(rank) for rank in range(possible))
    assert not cells.reach(possible)
    assert cells.numbers == order.tolist()
    assert cells.costs == table[order].tolist()


def test_few_cells_of_a_large_table_are_looked_for():
    cells = Cells(np.arange(5000)[::-1].copy(), IMPOSSIBLE)
    assert cells.reach(1)
    assert len(cells.costs) < 100
    assert cells.numbers[:2] == [4999, 4998]


@st.composite
def terms(draw):
    """(cards, scopes with flat tables), an order of the axes."""
    cards = draw(st.lists(st.sampled_from((1, 2, 3)), min_size=1, max_size=6))
    numbers = np.random.default_rng(draw(st.integers(0, 10**6)))
    scopes = draw(st.lists(st.sets(st.integers(0, len(cards) - 1), min_size=1, max_size=3), max_size=20))
    scoped = [
        (tuple(sorted(scope)), numbers.integers(0, 9, size=math.prod(cards[v] for v in scope))) for scope in scopes
    ]
    return cards, scoped, draw(st.permutations(range(len(cards))))


@LAW
@given(terms(), st.sampled_from((1, 4096)))
def test_a_total_is_the_sum_of_all_tables(drawn, large):
    cards, scoped, axes = drawn
    place = {v: axis for axis, v in enumerate(axes)}
    shape = [cards[v] for v in axes]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ranked_tables, "LARGE_TABLE", large)
        found = total([placed(scope, flat, place, cards) for scope, flat in scoped], shape, IMPOSSIBLE)
    assert found.shape == tuple(shape)
    for states in np.ndindex(*shape):
        own = [[states[place[v]] for v in scope] for scope, _ in scoped]
        cells = [
            np.ravel_multi_index(at, [cards[v] for v in scope]) for at, (scope, _) in zip(own, scoped, strict=True)
        ]
        assert found[states] == sum(int(flat[cell]) for cell, (_, flat) in zip(cells, scoped, strict=True))


@pytest.mark.parametrize("shape", [(1, 1), (7, 3), (3000, 2), (2000, 5), (1500, 40)])
def test_least_is_the_minimum_of_each_row(shape):
    table = np.random.default_rng(1).integers(0, 10**6, size=shape)
    np.testing.assert_array_equal(least(table), table.min(axis=1))
