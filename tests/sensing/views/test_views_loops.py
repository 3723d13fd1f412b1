"""The compiled loops against the same sums written out."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.cones import even_directions
from sensing.views.loops import BINS, apart, channel, climbed, in_view, offsets, responses, scanned, score
from sensing.views.search import spread_over
from sensing.views.views import BESIDE, NOTHING, Views

SEEDS = st.integers(0, 2**32 - 1)
COLOURS, HIGH, WIDE = 3, 40, 50


def some_views(rng, number=5, features=12):
    kind = rng.integers(NOTHING, 4, (number, features)).astype(np.int8)
    turn = np.linalg.qr(rng.normal(size=(number, 3, 3)))[0]
    turn *= np.linalg.det(turn)[:, None, None]
    return Views(
        rng.uniform(-0.5, 0.5, (number, features, 2)).astype(np.float32),
        kind,
        rng.uniform(-3.1, 3.1, (number, features)).astype(np.float32),
        rng.integers(0, COLOURS, (number, features)).astype(np.int16),
        turn,
        rng.integers(0, number, (number, BESIDE)),
        rng.uniform(0.0, 100.0, (COLOURS, 3)).astype(np.float32),
        np.full(COLOURS, 1.0 / COLOURS),
    )


def a_stack(rng):
    return rng.integers(-50, 51, (3 * BINS + 2 * COLOURS, HIGH, WIDE)).astype(np.int8)


def told(stack, views, view, angle, size, x, y):
    """The sum written out, about a pixel."""
    total = 0
    c, s = np.cos(angle) * size, np.sin(angle) * size
    for at, kind, across, colour in zip(*(array[view] for array in views[:4]), strict=True):
        if kind == NOTHING:
            continue
        u, v = round(x + c * at[0] - s * at[1]), round(y + s * at[0] + c * at[1])
        which = round((across + angle) / (np.pi / BINS))
        row = (which % (2 * BINS), 2 * BINS + which % BINS, 3 * BINS + colour, 3 * BINS + COLOURS + colour)[kind]
        if 0 <= u < WIDE and 0 <= v < HIGH:
            total += int(stack[row, v, u])
    return total


@settings(derandomize=True, deadline=None, max_examples=20)
@given(SEEDS, st.floats(6.0, 20.0), st.floats(-3.0, 3.0))
def test_a_score_is_the_sum_of_what_its_features_meet(seed, size, angle):
    rng = np.random.default_rng(seed)
    views, stack = some_views(rng), a_stack(rng)
    x, y, view = rng.integers(0, WIDE), rng.integers(0, HIGH), int(rng.integers(len(views.kind)))
    row = np.array([view, angle, size, x, y, 0.0], float)
    assert score(stack, views, row, 1.0, 0.0) == told(stack, views, view, angle, size, x, y)
    assert score(stack, views, row, 1.0, 0.3) == score(stack, views, row, 1.0, 0.0) * (size / 100.0) ** 0.3


@settings(derandomize=True, deadline=None, max_examples=10)
@given(SEEDS, st.floats(6.0, 16.0), st.integers(1, 4))
def test_a_scan_finds_the_best_cell_of_each_template_in_each_block(seed, size, rows):
    rng = np.random.default_rng(seed)
    views, stack, pad, turns = some_views(rng, 3), a_stack(rng), 12, 4
    some = np.array([2, 0])
    offset, count = offsets(views, some, turns, size, WIDE, HIGH * WIDE)
    block = rows * WIDE
    best, where = scanned(stack.ravel(), offset, count, pad * WIDE, (HIGH - pad) * WIDE, block)
    assert best.shape == (len(some) * turns, -(-(HIGH - 2 * pad) // rows))
    flat = stack.ravel()
    for template in range(len(offset)):
        cells = range(pad * WIDE, (HIGH - pad) * WIDE)
        sums = [int(flat[offset[template, : count[template]] + cell].sum()) for cell in cells]
        for b in range(best.shape[1]):
            here = sums[b * block : min((b + 1) * block, (HIGH - 2 * pad) * WIDE)]
            assert best[template, b] == max(here)
            assert where[template, b] == pad * WIDE + b * block + here.index(max(here))
        x, y = WIDE // 2, HIGH // 2
        angle = 2.0 * np.pi * (template % turns) / turns
        assert sums[(y - pad) * WIDE + x] == told(stack, views, some[template // turns], angle, size, x, y)


@settings(derandomize=True, deadline=None, max_examples=10)
@given(SEEDS)
def test_a_climb_never_ends_lower_than_it_began(seed):
    rng = np.random.default_rng(seed)
    views, stack = some_views(rng), a_stack(rng)
    seeds = np.column_stack(
        [
            rng.integers(0, 5, 8),
            rng.uniform(-3, 3, 8),
            rng.uniform(8, 20, 8),
            rng.uniform(15, 35, 8),
            rng.uniform(15, 25, 8),
            np.zeros(8),
        ]
    )
    moved = climbed(stack, views, seeds, 1.0, np.array([0.14, 0.09, 0.05]), 14, 0.0)
    assert len(moved) == len(seeds)
    for before, after in zip(seeds, moved, strict=True):
        assert after[5] == score(stack, views, after, 1.0, 0.0) >= score(stack, views, before, 1.0, 0.0)


@settings(derandomize=True, deadline=None, max_examples=20)
@given(SEEDS, st.floats(-3.0, 3.0))
def test_a_pose_stays_what_it_is_in_the_view_that_it_has(seed, turn):
    here = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    here *= np.linalg.det(here)
    c, s = np.cos(0.7), np.sin(0.7)
    there = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ here
    assert abs(np.angle(np.exp(1j * (in_view(turn, here, here) - turn)))) < 1e-9
    assert abs(np.angle(np.exp(1j * (in_view(turn, here, there) + 0.7 - turn)))) < 1e-9


@settings(derandomize=True, deadline=None, max_examples=20)
@given(SEEDS, st.integers(1, 12))
def test_what_is_kept_is_apart_and_what_is_not_is_like_one_before(seed, most):
    rng = np.random.default_rng(seed)
    rows = np.column_stack([rng.uniform(40, 60, 30), rng.uniform(0, 20, (30, 2))])
    turns = np.tile(np.eye(3), (30, 1, 1))
    kept = apart(rows, turns, most, 0.2, np.log(1.1), 0.06)

    def alike(one, other):
        near = np.abs(rows[one, 1:] - rows[other, 1:]) < 0.06 * rows[other, 0]
        return bool(near.all() and abs(np.log(rows[one, 0] / rows[other, 0])) < np.log(1.1))

    assert kept[0] == 0
    assert len(kept) <= most
    for i in range(30 if len(kept) < most else kept[-1] + 1):
        assert (i in kept) != any(alike(k, i) for k in kept if k < i)


def test_directions_are_told_apart():
    weight, angle = np.ones((1, 2)), np.array([[0.0, np.pi / 2.0]])
    grade = responses(weight, angle, BINS, np.pi, np.radians(20.0))
    assert grade[0, 0, 0] == grade[BINS // 2, 0, 1] == 31
    assert grade[BINS // 2, 0, 0] == grade[0, 0, 1] == 0
    assert channel(0, np.pi, 0, COLOURS) == BINS
    assert channel(1, np.pi, 0, COLOURS) == 2 * BINS
    assert [channel(kind, 0.0, 1, COLOURS) for kind in (2, 3)] == [3 * BINS + 1, 3 * BINS + COLOURS + 1]


@settings(derandomize=True, deadline=None, max_examples=10)
@given(st.integers(20, 400))
def test_few_of_many_views_are_spread_evenly(number):
    ways = even_directions(number)
    few = spread_over(ways, 20)
    assert len(set(few.tolist())) == 20
    assert (ways @ ways[few].T).max(axis=1).min() > np.cos(np.radians(60.0))
