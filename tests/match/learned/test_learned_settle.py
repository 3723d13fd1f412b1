"""Expected and the one assignment (D7, D8) of a learned type: what the lobes say, expected features first, one to one.

Then the pose.
"""

from itertools import permutations
from math import log, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import CAMERA, gamma_at, keypoint_of, one_sided, pose_before, ready, viewpoint
from random_cloud import random_cloud

from geometry.frames import pose_error, transform_points
from kb.clouds.lobes import in_lobe
from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.judged.type_models import SURE
from plogic.match.learned.agreement import ANGLES, ASIDE, SIZES, lobes_held
from plogic.match.learned.keypoints import FARTHEST
from plogic.match.learned.learned_match import FEWEST, LOOSER, NOISE, WIDE, blur, matched, pose_of
from plogic.match.learned.learned_poses import generate
from plogic.match.learned.learned_views import SEEN, keypoints_shown


def posed_of(thing, pose, data):
    return pose_of(thing.index, pose, data, thing.kb)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.floats(0.2, 4.0))
def test_lobes_that_hold_the_viewpoint_are_those_of_any_type(seed, distance):
    rng = np.random.default_rng(seed)
    thing = ready(random_cloud(seed, 10, 30, half_angle=rng.uniform(0.3, 2.0, 30)))
    pose, granularity = pose_before(rng, distance, 2.0), CAMERA.f / thing.kb.f_ref
    held = lobes_held(thing.index, pose, granularity)
    assert held.tolist() == np.flatnonzero(in_lobe(thing.kind.lobes, viewpoint(pose), granularity)[0]).tolist()
    posed = posed_of(thing, pose, gamma_at(thing.cloud, [], pose))
    for f in range(10):
        rates = [thing.cloud.hit[lobe] for lobe in held if thing.cloud.feature[lobe] == f]
        assert posed.hit[f] == max(rates, default=0.0)
        assert posed.in_lobe[f] == bool(rates)
        lobes = [lobe for lobe in held if thing.cloud.feature[lobe] == f and thing.cloud.hit[lobe] == posed.hit[f]]
        assert posed.turn[f] == pytest.approx(
            screen_angle(pose[:3, :3] @ thing.cloud.up[lobes[0]], posed.at[f]) if lobes else 0.0
        )
    inside = CAMERA.contains(CAMERA.project(transform_points(pose, thing.cloud.at)))
    assert posed.in_image.tolist() == inside.tolist()
    assert posed.candidate.tolist() == (inside & posed.in_lobe).tolist()


def may_be(thing, posed, data, lobe, datum):
    """Whether a keypoint looks as an appearance would at this pose: one by one."""
    cloud, at = thing.cloud, posed.at[thing.cloud.feature[lobe]]
    if not data.described[datum] or abs(log(cloud.size[lobe] * data.camera.f / at[2] / data.scale[datum])) >= SIZES:
        return False
    turned = screen_angle(posed.camera_from_object[:3, :3] @ cloud.up[lobe], at) - data.angle[datum]
    apart = np.linalg.norm(cloud.descriptor[lobe].astype(float) - data.descriptors[datum])
    return abs((turned + pi) % (2 * pi) - pi) < ANGLES and apart < LOOSER * FARTHEST


def best_worth(possible, off, tolerance):
    """The greatest Σ (1 − d²/2·tolerance²) over injective choices, by trying all."""
    features, data = possible.shape
    best = 0.0
    for order in permutations(range(data + features), features):
        chosen = [(f, d) for f, d in enumerate(order) if d < data and possible[f, d]]
        best = max(best, sum(1 - 0.5 * (off[f, d] / tolerance) ** 2 for f, d in chosen))
    return best


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 9999))
def test_the_assignment_takes_expected_features_first_and_is_the_best(seed):
    """Four features so close that they could take each other's keypoints.

    Some lobes do not hold the viewpoint, some are hidden.
    """
    rng = np.random.default_rng(seed)
    look = np.tile(rng.integers(0, 256, 128, np.uint8), (4, 1))
    alike = {
        "descriptor": look,
        "size": np.full(4, 0.02),
        "up": np.tile([[1.0, 0, 0]], (4, 1)),
        "axis": np.tile([[0.0, 0, 1]], (4, 1)),
    }
    thing = ready(
        one_sided(
            seed, 4, at=rng.uniform(-0.003, 0.003, (4, 3)), half_angle=np.where(rng.random(4) < 0.6, 0.9, 1e-3), **alike
        )
    )
    pose = pose_before(rng, 0.8, 0.1)
    data = gamma_at(thing.cloud, rng.permutation(4)[:3], pose)
    data.uv[:] += rng.normal(0, 0.8, data.uv.shape)
    free, hidden, tolerance = rng.random(3) < 0.8, rng.random(4) < 0.25, thing.kb.rates.match_tolerance
    posed = matched(thing.index, posed_of(thing, pose, data), data, thing.kb, free, hidden)
    apart = np.linalg.norm(posed.uv[:, None] - data.uv[None], axis=2)
    reach = np.maximum(
        tolerance, WIDE * thing.cloud.sigma * data.camera.f / posed.at[:, 2]
    )  # less exact places are looked for farther off
    off = apart * (tolerance / reach)[:, None]
    possible = np.array(
        [[may_be(thing, posed, data, f, d) and free[d] and off[f, d] <= tolerance for d in range(3)] for f in range(4)]
    )
    expected = posed.candidate & ~hidden
    taken = posed.matches
    assert len(set(taken[taken >= 0].tolist())) == (taken >= 0).sum()
    assert all(possible[f, d] for f, d in enumerate(taken) if d >= 0)
    first = possible & expected[:, None]
    worth = sum(1 - 0.5 * (off[f, taken[f]] / tolerance) ** 2 for f in np.flatnonzero(expected & (taken >= 0)))
    assert worth == pytest.approx(best_worth(first, off, tolerance))
    rest = possible & ~expected[:, None]
    rest[:, taken[expected & (taken >= 0)]] = False
    worth = sum(1 - 0.5 * (off[f, taken[f]] / tolerance) ** 2 for f in np.flatnonzero(~expected & (taken >= 0)))
    assert worth == pytest.approx(best_worth(rest, off, tolerance))
    found = taken >= 0
    np.testing.assert_allclose(posed.residual[found], apart[np.flatnonzero(found), taken[found]])
    assert np.isnan(posed.residual[~found]).all()


@pytest.mark.parametrize(("aside", "taken"), [(0.3, 0), (ASIDE + 0.3, -1), (pi, -1)])
def test_an_expected_feature_takes_only_what_a_lobe_reports_that_holds_the_viewpoint(aside, taken):
    """Two lobes of one feature, the keypoint looking like the one that does not hold the viewpoint.

    It is no detection (D8).

    Where the feature is hidden, and so not expected, any lobe will do whose axis is about where the viewpoint is.
    """
    rng = np.random.default_rng(3)
    axis = np.array([[0.0, 0, 1], [0, np.sin(aside), np.cos(aside)], [0, 0, 1]])
    lobes = {"axis": axis, "up": np.tile([[1.0, 0, 0]], (3, 1)), "r_min": [0.1] * 3, "half_angle": [0.9, 0.1, 0.9]}
    cloud = random_cloud(3, 2, 3, feature=[0, 0, 1], at=[[0, 0, 0], [0.05, 0, 0]], **lobes)
    thing, pose = ready(cloud), pose_before(rng, 0.8, 0.02)
    data = data_of([keypoint_of(cloud, lobe, pose, number=lobe) for lobe in (1, 2)], CAMERA)
    posed = matched(thing.index, posed_of(thing, pose, data), data, thing.kb)
    assert posed.candidate.tolist() == [True, True]
    assert posed.matches.tolist() == [-1, 1]
    other = matched(thing.index, posed_of(thing, pose, data), data, thing.kb, hidden=np.array([True, False]))
    assert other.matches.tolist() == [taken, 1]


def test_settling_moves_a_pose_to_where_its_features_are():
    rng, errors = np.random.default_rng(6), []
    for seed in range(5):
        thing = ready(one_sided(seed, 30))
        truth = pose_before(rng)
        data = gamma_at(thing.cloud, range(30), truth)
        data.uv[:] += rng.normal(0, 0.2, data.uv.shape)
        start = truth.copy()
        start[:3, 3] += rng.normal(0, 0.001, 3)
        posed = thing.index.settle(start, data, thing.kb)
        assert (posed.matches == np.arange(30)).mean() > 0.9
        rotation, translation = pose_error(posed.camera_from_object, truth)
        errors.append((np.degrees(rotation), translation))
    assert np.max(errors, axis=0)[0] < 0.5
    assert np.max(errors, axis=0)[1] < 0.01


def test_the_noise_of_places_is_told_by_the_matches_within_bounds():
    rng = np.random.default_rng(0)
    for sigma in np.linspace(*NOISE, 4):
        assert blur(np.linalg.norm(rng.normal(0, sigma, (20_000, 2)), axis=1)) == pytest.approx(sigma, rel=0.03)
    assert blur(np.full(FEWEST, 1e-6)) == NOISE[0]
    assert blur(np.full(FEWEST, 1e6)) == blur(np.full(FEWEST - 1, 1e-6)) == blur(np.zeros(0)) == NOISE[1]


def test_what_is_claimed_already_is_not_taken_again():
    thing, pose = ready(one_sided()), pose_before(np.random.default_rng(8))
    data = gamma_at(thing.cloud, range(24), pose)
    free = np.arange(24) % 3 > 0
    posed = thing.index.settle(pose, data, thing.kb, free=free)
    assert set(posed.matches.tolist()) == {-1, *np.flatnonzero(free).tolist()}
    nothing = thing.index.settle(pose, data, thing.kb, free=np.zeros(24, bool))
    assert (nothing.matches == -1).all()
    assert (thing.index.settle(pose, data.only(np.zeros(24, bool)), thing.kb).matches == -1).all()


def test_the_pose_is_found_among_clutter_and_the_evidence_says_so():
    rng = np.random.default_rng(9)
    thing = ready(one_sided(2, 40))
    truth = pose_before(rng)
    clutter = [keypoint_of(random_cloud(7, 60, 60), lobe, pose_before(rng), number=100 + lobe) for lobe in range(60)]
    rows = [keypoint_of(thing.cloud, lobe, truth, number=lobe) for lobe in range(0, 40, 2)]
    data = data_of([*rows, *(a for a in clutter if np.isfinite(a.uv).all())], CAMERA)
    found = generate(thing.index, data, thing.kb)
    assert found == sorted(found, key=lambda pair: -pair[0])
    ratio, posed = found[0]
    rotation, translation = pose_error(posed.camera_from_object, truth)
    assert ratio > 50
    assert np.degrees(rotation) < 0.5
    assert translation < 0.005
    assert (
        generate(thing.index, data_of(clutter, CAMERA), thing.kb) == []
        or generate(thing.index, data_of(clutter, CAMERA), thing.kb)[0][0] < 20
    )


@pytest.mark.parametrize("lobes", [20, 600])
def test_pixels_need_say_less_than_keypoints(lobes):
    """Of what keypoints say, all poses count; pixels are asked of few."""
    thing = ready(random_cloud(3, 10, lobes, half_angle=np.full(lobes, pi), hit=np.full(lobes, 0.5)))
    pose = pose_before(np.random.default_rng(3))
    posed = posed_of(thing, pose, gamma_at(thing.cloud, [], pose))
    assert keypoints_shown(thing.cloud) == pytest.approx(0.5 * lobes)
    assert thing.index.significance(posed) == SURE
    assert thing.index.significance(posed.told(pixels=1.0)) == SEEN
