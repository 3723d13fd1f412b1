"""What matches say of a pose where angles count.

By sampling of poses, and what the evidence and the program make of it.
"""

from __future__ import annotations

from dataclasses import replace
from math import log, pi

import numpy as np
import pytest
from oriented_scenes import EASY, HARD, a_trial, clouds
from scipy.spatial.transform import Rotation

from geometry.poses.reprojection import information
from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.hand.hand_models import type_index
from plogic.match.judged.evidence import (
    DEPTHS,
    as_counted,
    as_fitted,
    clutter_density,
    evidence,
    known,
    log_share,
    share_of,
    sigmas,
)
from plogic.match.judged.type_models import SURE
from plogic.match.oriented.oriented_models import search_of
from plogic.measures.distinctiveness import distinctiveness, instance_counts


def stood(seed, detector=EASY):
    """The true hypothesis of a trial, its data and KB."""
    ready = clouds(detector=detector)
    which, case, data = a_trial(ready, seed, detector)
    return ready.rows[which].settle(case.truth.camera_from_object, data, ready.kb), data, ready.kb


def matched(posed):
    return posed.candidate & posed.detected


def sampled(posed, data, kb, angles, count=40_000):
    """Logarithm of the share of poses that fit as well, by importance sampling.

    Places off by so much, and angles, if they count.
    """
    found, centre, camera = matched(posed), posed.middle, data.camera
    at, axes, sigma = posed.at[found], posed.axes[found], sigmas(posed, kb)[found]
    facts = known(posed, found, data, kb)
    scale = np.array([1.0, 1.0, 1.0, *[centre[2]] * 3])
    wide = 1.5 * np.linalg.cholesky(
        np.linalg.inv(information(facts.at, centre, facts.precision, camera, facts.across) * np.outer(scale, scale))
    )
    normal = np.random.default_rng(7).normal(size=(count, 6))
    step = normal @ wide.T
    turn = Rotation.from_rotvec(step[:, :3]).as_matrix()
    places = np.einsum("sij,nj->sni", turn, at - centre) + centre + centre[2] * step[:, None, 3:]
    facing = screen_angle(np.einsum("sij,nj->sni", turn, axes), places)
    off = camera.f * (places[..., :2] / places[..., 2:] - at[:, :2] / at[:, 2:])
    bent = np.angle(np.exp(1j * (facing - screen_angle(axes, at))))
    fits = -0.5 * ((off**2).sum(axis=2) / sigma**2).sum(axis=1)
    fits -= 0.5 * ((bent / kb.rates.sigma_angle) ** 2).sum(axis=1) if angles else 0.0
    drawn = -0.5 * (normal**2).sum(axis=1) - 3 * log(2 * pi) - np.log(np.diag(wide)).sum()
    return log(np.exp(fits - drawn).mean()) - log(camera.width * camera.height / camera.f**2 * DEPTHS * 8 * pi**2)


@pytest.mark.parametrize("detector", [EASY, HARD])
@pytest.mark.parametrize("seed", range(4))
def test_angles_narrow_the_poses_that_fit_as_sampling_says(seed, detector):
    """An angle is taken for the line to a point, which its own place's noise moves as well.

    So a little less than it says.
    """
    posed, data, kb = stood(seed, detector)
    at, precision, middle, across = known(posed, matched(posed), data, kb)
    with_angles, count = log_share(at, precision, middle, data.camera, across), int(matched(posed).sum())
    assert len(at) == 2 * count
    places = log_share(at[:count], precision[:count], middle, data.camera)
    assert with_angles < places
    assert with_angles == pytest.approx(sampled(posed, data, kb, angles=True), abs=0.5)
    assert places == pytest.approx(sampled(posed, data, kb, angles=False), abs=0.5)


def test_a_datum_without_an_angle_says_its_place_alone():
    posed, data, kb = stood(3)
    silent = data.only(np.ones(len(data.ids), bool))
    silent.angle[:] = np.nan
    facts = known(posed, matched(posed), silent, kb)
    assert np.allclose(facts.at, posed.at[matched(posed)])
    assert np.isnan(facts.across).all()


@pytest.mark.parametrize("seed", range(4))
def test_the_surplus_is_the_ratio_at_all_poses_together(seed):
    posed, data, kb = stood(seed)
    at, precision, middle, across = known(posed, matched(posed), data, kb)
    found = evidence(posed, data, kb)
    assert found.surplus - found.ratio == pytest.approx(log_share(at, precision, middle, data.camera, across))


@pytest.mark.parametrize("seed", range(4))
def test_the_program_is_told_what_the_surplus_says(seed):
    """The matches give up what the pose owes: ratio and share come to the surplus, which is what acceptance asks."""
    posed, data, kb = stood(seed)
    hit, near = as_fitted(posed, data, kb)
    found, missed = matched(posed), posed.candidate & ~posed.detected
    clutter = clutter_density(kb, data, posed.matches[found])
    told = (
        np.log((hit[found] * near[found] + (1 - hit[found]) * clutter) / clutter).sum() + np.log(1 - hit[missed]).sum()
    )
    assert told == pytest.approx(evidence(posed, data, kb).surplus, abs=1e-6)
    assert np.array_equal(hit, as_counted(posed, data, kb)[0])


def test_where_no_datum_has_an_angle_it_is_judged_as_without():
    ready = clouds()
    which, case, data = a_trial(ready, 3)
    silent = data_of([replace(a, angle=None) for a in case.gamma.appearances], case.gamma.camera)
    plain = replace(ready.kb, rates=replace(ready.kb.rates, sigma_angle=None))
    pose = case.truth.camera_from_object
    without = type_index(ready.rows[which].object_type, distinctiveness(instance_counts(ready.kb.types)))
    found = evidence(ready.rows[which].settle(pose, silent, ready.kb, rounds=0), silent, ready.kb)
    assert found == evidence(without.settle(pose, silent, plain, rounds=0), silent, plain)
    assert search_of(ready.shared, silent, ready.kb) is None
    assert found.surplus != evidence(ready.rows[which].settle(pose, data, ready.kb, rounds=0), data, ready.kb).surplus


def test_what_is_searched_for_together_must_be_as_sure_as_a_learned_type():
    which, case, data = a_trial(clouds(), 1)
    pose, index = case.truth.camera_from_object, clouds().rows[which]
    silent = data_of([replace(a, angle=None) for a in case.gamma.appearances], case.gamma.camera)
    assert index.significance(index.settle(pose, data, clouds().kb, rounds=0)) == SURE
    assert index.significance(index.settle(pose, silent, clouds().kb, rounds=0)) > SURE


def test_of_many_poses_at_once_the_share_is_that_of_each():
    facts, camera = [], None
    for seed in range(3):
        posed, data, kb = stood(seed)
        one, camera = known(posed, matched(posed), data, kb), data.camera
        facts.append(
            [rows[[0, 1, 2, 3, -4, -3, -2, -1]] for rows in (one.at, one.precision, one.across)] + [one.middle]
        )
    at, precision, across, middle = (np.array(rows) for rows in zip(*facts, strict=True))
    together = share_of(information(at, middle, precision, camera, across), middle[:, 2], camera)
    for row in range(3):
        assert together[row] == pytest.approx(log_share(at[row], precision[row], middle[row], camera, across[row]))
