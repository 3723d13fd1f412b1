"""The information of a look: by brute force on small cases, and its laws on any."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from plogic.sequence.next_view import look as module
from plogic.sequence.next_view.look import each_site, entropy, gain


def _case(seed, worlds=4, sites=6, levels=3):
    rng = np.random.default_rng([seed, 77])
    return rng.dirichlet(np.ones(worlds)), rng.choice(rng.uniform(0.02, 0.98, levels), (worlds, sites))


def _brute(probability, report, answers):
    """I(T; Z) as it is defined, over each outcome of all sites."""
    joint = np.zeros((2 ** report.shape[1], answers.shape[1]))
    for i, z in enumerate(product((0, 1), repeat=report.shape[1])):
        given = np.prod(np.where(np.array(z) == 1, report, 1.0 - report), axis=1)
        joint[i] = (probability * given) @ answers
    independent = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0, keepdims=True)
    some = joint > 0
    return float((joint[some] * np.log2(joint[some] / independent[some])).sum())


@pytest.mark.parametrize("seed", range(8))
def test_it_is_the_mutual_information_of_worlds_and_reports(seed):
    probability, report = _case(seed)
    found = gain(probability, report)
    assert found.error == 0.0
    assert found.bits == pytest.approx(_brute(probability, report, np.eye(4)), abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_of_a_goal_that_a_world_may_leave_open_too(seed):
    probability, report = _case(seed)
    true = np.random.default_rng(seed).uniform(0, 1, 4)
    answers = np.stack([true, 1 - true], axis=1)
    assert gain(probability, report, answers).bits == pytest.approx(_brute(probability, report, answers), abs=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_samples_agree_with_the_sum_within_their_error(seed, monkeypatch):
    probability, report = _case(seed, worlds=6, sites=9)
    exact = gain(probability, report).bits
    monkeypatch.setattr(module, "OUTCOMES", 0)
    found = gain(probability, report, seed=seed)
    assert 0.0 < found.error <= module.ERROR
    assert abs(found.bits - exact) < 4 * found.error


@pytest.mark.parametrize("seed", range(6))
def test_it_is_between_nothing_and_all_and_a_goal_is_less_than_the_whole(seed):
    probability, report = _case(seed, worlds=5, sites=10)
    answers = np.eye(2)[np.random.default_rng(seed).integers(2, size=5)]
    whole, part = gain(probability, report).bits, gain(probability, report, answers).bits
    assert 0.0 <= part <= whole + 1e-12
    assert whole <= float(entropy(probability)) + 1e-12
    assert part <= float(entropy(probability @ answers)) + 1e-12


def test_where_all_worlds_lead_to_expect_the_same_there_is_nothing_to_learn():
    assert gain(np.array([0.3, 0.7]), np.full((2, 5), 0.4)) == (0.0, 0.0, 0)
    assert gain(np.array([0.3, 0.7]), np.zeros((2, 0))) == (0.0, 0.0, 0)


def test_the_order_of_worlds_and_sites_and_a_world_told_twice_change_nothing():
    probability, report = _case(3, worlds=5, sites=7)
    before = gain(probability, report).bits
    rng = np.random.default_rng(1)
    rows, columns = rng.permutation(5), rng.permutation(7)
    assert gain(probability[rows], report[rows][:, columns]).bits == pytest.approx(before, abs=1e-12)
    twice = np.concatenate([probability[:4], probability[4:] / 2, probability[4:] / 2])
    assert gain(twice, np.concatenate([report, report[4:]])).bits == pytest.approx(before, abs=1e-12)


def test_a_site_alone_tells_what_the_sum_over_it_says_and_more_sites_tell_no_less():
    probability, report = _case(5)
    alone = each_site(probability, report)
    assert alone == pytest.approx([gain(probability, report[:, [s]]).bits for s in range(6)], abs=1e-9)
    growing = [gain(probability, report[:, :n]).bits for n in range(7)]
    assert (np.diff(growing) >= -1e-12).all()


def test_a_sure_report_of_one_world_tells_it():
    report = np.array([[1.0], [0.0]])
    assert gain(np.array([0.5, 0.5]), report).bits == pytest.approx(1.0)
