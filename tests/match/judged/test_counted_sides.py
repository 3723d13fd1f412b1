"""How much of an observation sides of edges count.

What they share with those beside them is linked less than what keypoints share.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_counted import COUNT, CROWDS, crowded, together

from plogic.measures.crowding import ALONG, LINKED, shares

SIDED = st.integers(0, 2**COUNT - 1).map(lambda bits: np.array([bits >> f & 1 for f in range(COUNT)], bool))


def by_loop(posed, sided):
    result, expected = np.ones(COUNT), np.flatnonzero(posed.candidate).tolist()
    for i in expected:
        links = [
            (LINKED if sided[i] or sided[j] else 1.0) * together(posed, min(i, j), max(i, j))
            for j in expected
            if j != i
        ]
        result[i] = 1.0 / (1.0 + sum(links))
    return result.tolist()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(CROWDS, SIDED)
def test_a_side_and_its_neighbours_are_linked_so_much(how, sided):
    posed = replace(crowded(*how)[0], sided=sided)
    assert posed.counted.tolist() == pytest.approx(by_loop(posed, sided))


@settings(max_examples=20, deadline=None, derandomize=True)
@given(CROWDS)
def test_keypoints_alone_are_as_they_were(how):
    posed = crowded(*how)[0]
    assert posed.sided.tolist() == [False] * COUNT
    for sided in (None, np.zeros(COUNT, bool)):
        assert (
            replace(posed, sided=sided).counted.tolist()
            == posed.counted.tolist()
            == pytest.approx(by_loop(posed, posed.sided))
        )


@settings(max_examples=30, deadline=None, derandomize=True)
@given(CROWDS, SIDED, st.integers(0, COUNT - 1))
def test_a_side_counts_no_less_than_a_keypoint_at_its_place_and_company_never_adds(how, sided, one):
    posed = crowded(*how)[0]
    plain, mixed = (
        replace(posed, sided=sided & (np.arange(COUNT) != one)),
        replace(posed, sided=sided | (np.arange(COUNT) == one)),
    )
    assert 0.0 < LINKED < 1.0
    assert (mixed.counted >= plain.counted * (1 - 1e-12)).all()
    alone = replace(mixed, in_lobe=mixed.in_lobe & (np.arange(COUNT) != one))
    rest = np.arange(COUNT) != one
    assert (alone.counted[rest] >= mixed.counted[rest] * (1 - 1e-12)).all()


@settings(max_examples=30, deadline=None, derandomize=True)
@given(CROWDS, SIDED, st.permutations(range(COUNT)))
def test_the_order_changes_nothing(how, sided, order):
    posed = crowded(*how)[0]
    plain, other = shares(posed.uv, posed.turn, sided), shares(posed.uv[order], posed.turn[order], sided[order])
    assert other.tolist() == pytest.approx(plain[order].tolist())


@pytest.mark.parametrize("kinds", [(True, True), (True, False), (False, True)])
def test_copies_at_one_place_with_a_side_among_them_are_linked_in_part(kinds):
    uv, turn = np.full((2, 2), 50.0), np.full(2, 0.4)
    assert shares(uv, turn, np.array(kinds)).tolist() == pytest.approx([1 / (1 + LINKED)] * 2)
    assert shares(uv, turn, np.zeros(2, bool)).tolist() == pytest.approx([0.5, 0.5])
    far = np.array([[0.0, 0.0], [10.0 * ALONG, 0.0]])
    assert shares(far, np.array([pi / 2, pi / 2]), np.array(kinds)).tolist() == [1.0, 1.0]
    assert shares(uv[:1], turn[:1], np.array(kinds[:1])).tolist() == [1.0]
    assert shares(uv[:0], turn[:0], np.array(kinds[:0], bool)).tolist() == []
