"""What is foretold of more types: laws, a toy that is counted, and costs by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.scale.costs import looks_needed, need, types_under_limit
from benchmarks.scale.recall import Standing, interval, line, recall

counts = st.lists(st.integers(0, 500), min_size=1, max_size=8).map(lambda some: np.array(some, np.int64))
standings = st.builds(
    Standing, st.integers(1, 9), st.integers(1, 5), st.integers(0, 30), st.integers(0, 30), counts, st.integers(1, 1000)
)


@given(standings, st.integers(1, 10**6), st.integers(0, 10**6), st.integers(1, 3000))
def test_recall_falls_with_types_and_grows_with_what_is_laid(standing, types, more, laid):
    assert (
        0.0
        <= standing.chance(types + more, laid)
        <= standing.chance(types, laid)
        <= standing.chance(types, 2 * laid)
        <= 1.0
    )


@given(standings, st.integers(2, 50))
def test_votes_before_grow_by_as_much_with_each_type(standing, types):
    totals = [sum(standing.before(number)) for number in (1, types, 2 * types - 1)]
    assert totals[0] == standing.above + standing.level
    assert totals[2] - totals[1] == pytest.approx(totals[1] - totals[0])


@given(standings, counts, st.integers(1, 1000))
def test_more_types_join_as_if_they_had_been_counted_at_once(standing, others, types):
    joined = standing.joined(others, types)
    assert joined.others.sum() == standing.others.sum() + others.sum()
    assert joined.types == standing.types + types
    both = joined.joined(np.zeros(20, np.int64), 0)
    assert both.before(joined.types + 1) == joined.before(joined.types + 1)


def test_what_is_measured_needs_no_foretelling():
    standing = Standing(3, 1, 2, 1, np.array([0, 50, 40, 30, 20]), 99)
    assert standing.before(100) == (22.0, 31.0)
    assert standing.chance(100, 22) == 0.0
    assert standing.chance(100, 54) == 1.0
    assert standing.chance(100, 38) == pytest.approx(0.5)


def test_who_has_no_right_vote_is_never_found():
    assert Standing(0, 0, 0, 0, np.array([0, 3]), 9).chance(10, 2000) == 0.0


def test_votes_of_one_count_come_in_any_order():
    rng, standing = np.random.default_rng(1), Standing(2, 2, 0, 0, np.array([0, 0, 18]), 19)
    hits = [(rng.permutation(20)[:5] < 2).any() for _ in range(4000)]
    assert standing.chance(20, 5) == pytest.approx(np.mean(hits), abs=0.04)


def test_a_toy_is_foretold_from_a_tenth_of_its_types():
    rng, laid, many = np.random.default_rng(2), 300, 2000
    foretold, counted = [], []
    for _ in range(60):
        right, votes = int(rng.integers(1, 9)), rng.geometric(0.5, (many, 5))
        few, whole = (np.bincount(some.ravel()) for some in (votes[: many // 10], votes))
        foretold.append(Standing(right, 1, 0, 0, few, many // 10))
        counted.append(Standing(right, 1, 0, 0, whole, many))
    assert 0.1 < recall(counted, many + 1, laid) < 0.9
    assert recall(foretold, many + 1, laid) == pytest.approx(recall(counted, many + 1, laid), abs=0.03)


def test_an_interval_holds_the_mean_and_a_line_its_points():
    values = [0.0, 1.0, 1.0, 1.0, 0.5, 1.0]
    low, high = interval(values, np.random.default_rng(0))
    assert low < np.mean(values) < high
    assert interval([1.0, 1.0], np.random.default_rng(0)) == (1.0, 1.0)
    assert line([10, 20, 40], [1.5, 2.5, 4.5]) == pytest.approx((0.5, 0.1))


def test_costs_by_hand():
    found = need(10**6, 3600.0, 1e6, (0.5, 1e-4), memory=125.0, most=50_000.0)
    assert (found.terabytes, found.index, found.indices, found.machines) == (1.0, 50_000, 20, 10)
    assert (found.seconds, found.cores) == (pytest.approx(110.0), 110)
    assert need(10**6, 1.0, 10.0, (0.0, 0.0), memory=1.0).index == 1 << 17
    assert types_under_limit(200.0, most=1000) == 5.0
    assert looks_needed(4000, 100, 1.0, most=1000) == 200
