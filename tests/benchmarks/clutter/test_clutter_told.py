"""The ceiling of ``plogic bench clutter``: whom we told everything."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.clutter.scenes import Trial, trial
from benchmarks.clutter.table import judged
from benchmarks.clutter.told import told
from benchmarks.clutter.types import EASY, Detector, random_types
from benchmarks.recognition.score import errors_of

EXACT = Detector("exact", 0.6, 0.0, 0.0)


@pytest.fixture(scope="module")
def kb():
    return random_types(4, 100, 50, np.random.default_rng(5))


def one(kb, detector, seed):
    return trial(kb.types[seed % 4], kb, detector, np.random.default_rng(seed), 200)


@pytest.mark.parametrize("seed", range(4))
def test_of_data_without_noise_the_pose_is_exact(kb, seed):
    posed = one(kb, EXACT, seed)
    found = told(kb, posed)
    assert judged(found, posed.truth) == (True, True, False)
    assert max(errors_of(found[0], posed.truth)) < 1e-6


def test_noise_leads_away_from_the_true_pose(kb):
    """He answers what his data say, not what he was told to start from; the more noise, the farther off."""
    turned = {
        sigma: np.mean(
            [
                errors_of(told(kb, posed)[0], posed.truth)[0]
                for posed in (one(kb, Detector("it", 0.6, sigma, 0.01), s) for s in range(20))
            ]
        )
        for sigma in (0.1, 3.0)
    }
    assert 1e-4 < turned[0.1] < 0.1 * turned[3.0]


def test_of_three_data_nothing_is_told(kb):
    posed = one(kb, EASY, 1)
    some = dict(list(posed.causes.items())[:3])
    assert told(kb, Trial(posed.gamma, posed.truth, some)) == []
    some = dict(list(posed.causes.items())[:4])
    assert len(told(kb, Trial(posed.gamma, posed.truth, some))) == 1
