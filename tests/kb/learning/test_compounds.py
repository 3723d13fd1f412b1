"""Compounds are formed of what is near, seen from the same side, and found together.

What holds of all of them, on made features.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kb.clouds.learned import numbered
from kb.learning.compounds import BY_CHANCE, OF_SIZE, OFTEN, bar, grouped, linked, together, within_parts

WIDTH, PAIRS, LONE, PICTURES = 0.01, 12, 60, 160


def made(seed, together_at=0.97):
    """Features on two sides of a thing, each seen in about half of its side's pictures.

    The first ``2 * PAIRS`` are twins in one place that are shown together in so large a share of them; the next are in
    one place with their twins and shown each for itself; the rest stand alone.
    """
    rng = np.random.default_rng(seed)
    count = 4 * PAIRS + LONE
    at, side = rng.uniform(-0.5, 0.5, (count, 3)), rng.integers(0, 2, count)
    twin = np.arange(count) // 2 * 2
    at[: 4 * PAIRS], side[: 4 * PAIRS] = at[twin[: 4 * PAIRS]], side[twin[: 4 * PAIRS]]
    at += rng.uniform(-0.1, 0.1, at.shape) * OF_SIZE * WIDTH
    held = (np.arange(PICTURES) < PICTURES // 2)[None] == (side == 0)[:, None]
    shown = held & (rng.random(held.shape) < 0.5)
    alike = rng.random((2 * PAIRS, PICTURES)) < together_at
    shown[: 2 * PAIRS] = np.where(alike, shown[twin[: 2 * PAIRS]], held[: 2 * PAIRS] & ~shown[: 2 * PAIRS])
    return shown, held, at, np.full(count, WIDTH)


def groups_of(labels):
    """The groups as sets of features."""
    return {frozenset(np.flatnonzero(labels == label).tolist()) for label in np.unique(labels[labels > 0])}


def qualify(shown, held, at, width, one, other):
    """The stated conditions of two features, but for the bar, each worked out by itself."""
    both, either = (shown[one] & shown[other]).sum(), (shown[one] | shown[other]).sum()
    its, any_of_them = (held[one] & held[other]).sum(), (held[one] | held[other]).sum()
    near = np.linalg.norm(at[one] - at[other]) < OF_SIZE * max(width[one], width[other])
    return near and its >= OFTEN * any_of_them and both >= OFTEN * either


seeds = st.integers(0, 10_000)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seeds)
def test_twins_that_are_shown_together_are_compounds_and_chance_is_rare(seed):
    labels = grouped(*made(seed))
    planted = {frozenset((2 * i, 2 * i + 1)) for i in range(PAIRS)}
    found = groups_of(labels)
    assert len(found & planted) >= PAIRS - 1
    assert len(found - planted) <= 3  # a tenth on average


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seeds, st.sampled_from([0.6, 0.8, 0.97]))
def test_groups_are_disjoint_and_every_pair_of_a_group_qualifies(seed, together_at):
    some = made(seed, together_at)
    labels = grouped(*some)
    assert np.array_equal(numbered(labels), labels)
    pairs = [(a, b) for group in groups_of(labels) for a in group for b in group if a < b]
    assert all(qualify(*some, a, b) for a, b in pairs)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seeds)
def test_another_order_of_features_or_pictures_gives_the_same_groups(seed):
    shown, held, at, width = made(seed)
    rng = np.random.default_rng(seed)
    order, pictures = rng.permutation(len(at)), rng.permutation(PICTURES)
    moved = grouped(shown[order], held[order], at[order], width[order])
    assert {frozenset(order[list(group)].tolist()) for group in groups_of(moved)} == groups_of(
        grouped(shown, held, at, width)
    )
    assert np.array_equal(grouped(shown[:, pictures], held[:, pictures], at, width), grouped(shown, held, at, width))


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seeds)
def test_what_never_occurs_together_is_never_grouped(seed):
    shown, held, at, width = made(seed)
    shown[1 : 4 * PAIRS : 2] = held[1 : 4 * PAIRS : 2] & ~shown[: 4 * PAIRS : 2]
    assert not grouped(shown, held, at, width).any()


def test_what_stands_apart_is_never_grouped_however_often_together():
    shown, held, at, width = made(3)
    labels = grouped(shown, held, at + 10.0 * WIDTH * np.arange(len(at))[:, None], width)
    assert not labels.any()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(seeds, st.integers(0, 40), st.integers(0, 400))
def test_the_bar_keeps_chance_to_its_share(seed, near, others):
    rng = np.random.default_rng(seed)
    mine, its = rng.random(near).astype(np.float32) ** 0.3, rng.random(others).astype(np.float32)
    found = bar(mine, its)
    assert found >= OFTEN
    if np.isfinite(found):
        by_chance = ((its >= found).sum() + 1) / (len(its) + 1) * len(mine)
        assert by_chance <= BY_CHANCE * (mine >= found).sum()


def test_near_pairs_that_are_no_more_together_than_others_make_no_compound():
    shares = np.linspace(0.0, 1.0, 200).astype(np.float32)
    assert bar(shares, shares) == np.inf
    assert bar(np.zeros(0, np.float32), np.zeros(0, np.float32)) == np.inf


def test_a_chain_is_no_compound_for_its_ends_do_not_qualify():
    similar = np.array([[1, 0.9, 0.4], [0.9, 1, 0.8], [0.4, 0.8, 1]], np.float32)
    chain = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]], bool)
    apart = np.ones((3, 3))
    assert linked(similar, apart, chain).tolist() == [1, 1, 0]
    assert linked(similar, apart, ~np.eye(3, dtype=bool)).tolist() == [1, 1, 1]
    assert linked(np.zeros((0, 0), np.float32), np.zeros((0, 0)), np.zeros((0, 0), bool)).tolist() == []


def test_the_share_together_is_that_of_jaccard():
    shown = np.array([[1, 1, 0, 0], [1, 0, 1, 0], [0, 0, 0, 0]], bool)
    assert together(shown) == pytest.approx(np.array([[1, 1 / 3, 0], [1 / 3, 1, 0], [0, 0, 0]]))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(seeds)
def test_no_compound_is_in_two_parts(seed):
    rng = np.random.default_rng(seed)
    compound, part = numbered(rng.integers(0, 6, 30)), rng.integers(0, 3, 30)
    split = within_parts(compound, part)
    assert np.array_equal(numbered(split), split)
    for group in groups_of(split):
        assert len({(compound[f], part[f]) for f in group}) == 1
    for f in np.flatnonzero((split == 0) & (compound > 0)):
        assert ((compound == compound[f]) & (part == part[f])).sum() == 1
