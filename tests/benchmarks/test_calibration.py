"""Measures of calibration: cases done by hand, and laws."""

from itertools import pairwise
from math import isnan, log

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.calibration.reliability import (
    Bin,
    bootstrap_interval,
    brier,
    brier_skill,
    expected_calibration_error,
    log_loss,
    parts,
    reliability,
)

CHANCES = st.sampled_from([0.0, 0.1, 0.25, 0.5, 0.9, 1.0]) | st.floats(0.0, 1.0)
FORECASTS = st.lists(st.tuples(CHANCES, st.booleans()), min_size=2, max_size=60)
SOME = settings(max_examples=60, deadline=None, derandomize=True)


def split(rows):
    return np.array([p for p, _ in rows]), np.array([float(y) for _, y in rows])


def test_four_forecasts_by_hand():
    p, y = [0.0, 0.5, 0.5, 0.75], [0, 0, 1, 1]
    assert brier(p, y) == pytest.approx((0 + 0.25 + 0.25 + 0.0625) / 4)
    assert brier_skill(p, y) == pytest.approx(1 - 0.140625 / 0.25)
    assert log_loss(p, y) == pytest.approx(-(log(1 - 1e-6) + 2 * log(0.5) + log(0.75)) / 4)
    assert expected_calibration_error(p, y, bins=2) == pytest.approx(0.75 * (2 / 3 - 1.75 / 3)), (
        "0 alone, the three others together"
    )


def test_bins_by_hand():
    """Six forecasts in three bins of two; the pair of equal ones in the middle stays together."""
    table = reliability([0.1, 0.2, 0.4, 0.4, 0.8, 0.9], [0, 1, 0, 1, 1, 1], bins=3)
    assert table == (
        Bin(0.1, 0.2, pytest.approx(0.15), 0.5, 2),
        Bin(0.4, 0.4, 0.4, 0.5, 2),
        Bin(0.8, 0.9, pytest.approx(0.85), 1.0, 2),
    )
    assert expected_calibration_error([0.1, 0.2, 0.4, 0.4, 0.8, 0.9], [0, 1, 0, 1, 1, 1], bins=3) == pytest.approx(
        (0.35 + 0.1 + 0.15) / 3
    )


def test_the_interval_of_a_share_is_wilsons():
    """Two of ten: [0.0567, 0.5098] (Newcombe 1998, method 3)."""
    assert Bin(0.1, 0.3, 0.2, 0.2, 10).interval == pytest.approx((0.0567, 0.5098), abs=1e-4)


def test_whoever_is_sure_and_wrong_pays_what_is_stated():
    assert log_loss([1.0], [0]) == pytest.approx(-log(1e-6))
    assert log_loss([1.0], [0], least=0.01) == pytest.approx(-log(0.01))


def test_where_nothing_can_be_learned_there_is_no_skill():
    assert isnan(brier_skill([0.2, 0.9], [1, 1]))


@pytest.mark.parametrize(
    ("p", "y", "words"),
    [
        ([], [], "two rows"),
        ([0.5], [1, 0], "two rows"),
        ([1.5], [1], "no probability"),
        ([float("nan")], [1], "no probability"),
        ([0.5], [2], "neither"),
    ],
)
def test_what_is_no_forecast_is_refused(p, y, words):
    with pytest.raises(ValueError, match=words):
        brier(p, y)


def test_bins_are_at_least_one():
    with pytest.raises(ValueError, match="0 bins"):
        reliability([0.5], [1], bins=0)


@SOME
@given(FORECASTS, st.randoms(use_true_random=False), st.integers(1, 20))
def test_no_order_of_the_forecasts_changes_anything(rows, random, bins):
    p, y = split(rows)
    random.shuffle(rows)
    q, z = split(rows)
    assert [(b.low, b.high, b.count) for b in reliability(p, y, bins)] == [
        (b.low, b.high, b.count) for b in reliability(q, z, bins)
    ]
    for measure in (brier, log_loss):
        assert measure(p, y) == pytest.approx(measure(q, z))
    assert expected_calibration_error(p, y, bins) == pytest.approx(expected_calibration_error(q, z, bins))


@SOME
@given(FORECASTS, st.integers(1, 20))
def test_bins_share_out_the_forecasts_in_order_and_equal_ones_are_together(rows, bins):
    p, y = split(rows)
    table = reliability(p, y, bins)
    assert sum(b.count for b in table) == len(p)
    assert len(table) <= bins
    assert all(one.high < other.low for one, other in pairwise(table))
    assert 0.0 <= expected_calibration_error(p, y, bins) <= 1.0


@SOME
@given(st.lists(st.floats(0, 1), min_size=30, max_size=200, unique=True), st.integers(1, 15))
def test_bins_of_different_forecasts_are_of_equal_mass(p, bins):
    counts = [b.count for b in reliability(p, np.zeros(len(p)), bins)]
    assert max(counts) - min(counts) <= 1


@SOME
@given(st.lists(st.booleans(), min_size=2, max_size=60).filter(lambda y: 0 < sum(y) < len(y)), st.integers(1, 20))
def test_the_base_rate_is_calibrated_and_has_no_skill_and_the_perfect_has_all(y, bins):
    y = np.array(y, float)
    always = np.full(len(y), y.mean())
    assert brier_skill(always, y) == pytest.approx(0.0, abs=1e-12)
    assert expected_calibration_error(always, y, bins) == pytest.approx(0.0, abs=1e-12)
    assert brier_skill(y, y) == 1.0
    assert expected_calibration_error(y, y, bins) == 0.0


@SOME
@given(FORECASTS)
def test_murphys_parts_make_the_score_where_forecasts_of_a_bin_are_alike(rows):
    """As many bins as it takes to part any two that differ.

    Then skill is what is resolved, less what is wrong, of what was uncertain.
    """
    p, y = split(rows)
    found = parts(p, y, bins=2 * len(p))
    assert found.reliability - found.resolution + found.uncertainty == pytest.approx(brier(p, y))
    if found.uncertainty:
        assert brier_skill(p, y) == pytest.approx((found.resolution - found.reliability) / found.uncertainty)


def test_who_says_what_is_so_is_calibrated():
    """Outcomes drawn by the forecasts: ECE goes to 0, skill to what is resolved."""
    rng = np.random.default_rng(0)
    p = rng.beta(0.5, 0.5, 40_000)
    y = (rng.random(len(p)) < p).astype(float)
    found = parts(p, y)
    assert expected_calibration_error(p, y) < 0.01
    assert brier_skill(p, y) == pytest.approx(found.resolution / found.uncertainty, abs=0.02)
    assert expected_calibration_error(p**2, y) > 0.1


@SOME
@given(FORECASTS, st.integers(0, 100))
def test_the_interval_holds_the_estimate_and_is_the_same_every_time(rows, seed):
    p, y = split(rows)
    scene = np.arange(len(p)) // 3
    once, again = (bootstrap_interval(brier, p, y, scene, seed=seed, resamples=40) for _ in range(2))
    assert once == again
    assert once[0] <= brier(p, y) <= once[1]


def test_the_interval_of_a_mean_is_that_of_its_standard_error():
    rng = np.random.default_rng(1)
    y = (rng.random(900) < 0.3).astype(float)
    low, high = bootstrap_interval(lambda _, outcome: float(outcome.mean()), np.full(900, 0.3), y, np.arange(900))
    half = 1.96 * np.sqrt(y.mean() * (1 - y.mean()) / 900)
    assert (low, high) == pytest.approx((y.mean() - half, y.mean() + half), abs=0.006)


def test_forecasts_of_one_scene_are_drawn_together():
    """A hundred scenes that each say one thing nine times know no more than a hundred forecasts."""
    rng = np.random.default_rng(2)
    one = (rng.random(100) < 0.5).astype(float)
    y, scene = np.repeat(one, 9), np.repeat(np.arange(100), 9)

    def width(of, scenes):
        low, high = bootstrap_interval(lambda _, outcome: float(outcome.mean()), np.full(len(of), 0.5), of, scenes)
        return high - low

    assert width(y, scene) == pytest.approx(width(one, np.arange(100)), rel=0.1)
    assert width(y, scene) > 2 * width(y, np.arange(900))
