"""Packings share no datum and gain by no exchange; probabilities of few tracks are those of enumeration."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from plogic.sequence.constancy.decide import packing, probabilities


def drawn(rng, count=9, views=3, data=4):
    rows = rng.integers(-1, data, (count, views))
    rows = np.unique(rows[(rows >= 0).sum(axis=1) >= 2], axis=0)
    return rows, rng.normal(2.0, 3.0, len(rows))


def shares(rows, a, b):
    return bool(((rows[a] == rows[b]) & (rows[a] >= 0)).any())


def packings(rows):
    every = range(len(rows))
    return [
        s
        for n in range(len(rows) + 1)
        for s in combinations(every, n)
        if not any(shares(rows, a, b) for a, b in combinations(s, 2))
    ]


@pytest.mark.parametrize("seed", range(12))
def test_no_datum_twice_and_no_exchange_gains(seed):
    rows, weight = drawn(np.random.default_rng(seed))
    chosen = packing(rows, weight).tolist()
    assert not [pair for pair in combinations(chosen, 2) if shares(rows, *pair)]
    total = weight[chosen].sum()
    swapped = [
        total + weight[t] - sum(weight[c] for c in chosen if shares(rows, t, c))
        for t in range(len(rows))
        if t not in chosen
    ]
    assert all(other <= total + 1e-6 for other in swapped)
    best = max(sum(weight[list(s)]) for s in packings(rows))
    assert total >= best / rows.shape[1]  # what greedy packing has at least


def test_a_light_track_gives_way_to_two_that_are_heavier_together():
    rows, weight = np.array([[0, 1, -1], [0, 0, -1], [1, 1, -1]]), np.array([5.0, 4.0, 4.0])
    assert packing(rows, weight).tolist() in ([0], [1, 2])
    assert packing(rows, np.array([3.0, 4.0, 4.0])).tolist() == [1, 2]


def test_one_track_alone_has_the_odds_of_its_weight():
    rows, weight = np.array([[0, 0]]), np.array([np.log(3.0)])
    assert probabilities(rows, weight, packing(rows, weight))[0] == pytest.approx(0.75)


def test_a_rival_for_one_datum_is_what_enumeration_says():
    rows, weight = np.array([[0, 0], [0, 1]]), np.array([2.0, 1.0])
    every = [np.exp(sum(weight[list(s)])) for s in packings(rows)]
    holds = [np.exp(sum(weight[list(s)])) for s in packings(rows) if 0 in s]
    assert probabilities(rows, weight, packing(rows, weight))[0] == pytest.approx(sum(holds) / sum(every))


def test_a_part_of_a_track_speaks_for_it():
    rows, weight = np.array([[0, 0, 0], [0, 0, -1]]), np.array([2.0, 1.9])
    total = 1.0 + np.exp(2.0) + np.exp(1.9)
    assert probabilities(rows, weight, np.array([0]))[0] == pytest.approx(1.0 - 1.0 / total)


def test_nothing_to_pack():
    assert packing(np.zeros((0, 3), np.intp), np.zeros(0)).tolist() == []
