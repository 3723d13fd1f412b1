"""Rivals: A4, and claims on the same appearances (§3.1, §4.1)."""

import numpy as np
import pytest
from synthetic import CAMERA, camera_pose, data, one_before_the_other, posed_at, scene, side_by_side

from geometry.frames import from_rotation_translation, transform_points
from plogic.match.judged.expectation import hidden_by
from plogic.match.judged.rivals import SHARED_CLAIMS, SHARED_VOLUME, apart_on_screen, claims, overlap, shared_claims


@pytest.fixture(scope="module")
def two():
    rng = np.random.default_rng(7200)
    shot = scene(rng, one_before_the_other(rng))
    of = data(shot)
    return shot, of, posed_at("t1", shot.poses["t1"], of), posed_at("t2", shot.poses["t2"], of)


def moved(pose, step):
    return pose @ from_rotation_translation(np.eye(3), step)


def test_two_towers_that_stand_apart_do_not_overlap(two):
    _, _, front, back = two
    assert not overlap(front, back)
    assert not overlap(back, front)


def test_a_body_overlaps_itself_and_another_in_its_place(two):
    shot, of, front, _ = two
    assert overlap(front, front)
    assert overlap(front, posed_at("t2", shot.poses["t1"], of))


def test_touching_is_allowed_sharing_volume_is_not(two):
    """Side by side along its own x axis: by the width it touches, by half of it it shares half."""
    shot, of, front, _ = two
    surface = front.object_type.surface
    width = float(np.ptp(surface.vertices[:, 0]))
    assert not overlap(front, posed_at("t1", moved(shot.poses["t1"], [width, 0, 0]), of))
    assert not overlap(front, posed_at("t1", moved(shot.poses["t1"], [(1 - 0.5 * SHARED_VOLUME) * width, 0, 0]), of))
    assert overlap(front, posed_at("t1", moved(shot.poses["t1"], [0.5 * width, 0, 0]), of))


def test_overlap_is_symmetric():
    rng = np.random.default_rng(7201)
    pose = camera_pose(rng, (4.0, 5.0))
    of = data(scene(rng, {"t1": pose}))
    one = posed_at("t1", pose, of)
    told = []
    for step in np.linspace(0, 1.2, 9):
        other = posed_at("t2", moved(pose, [step, 0.3 * step, 0]), of)
        told.append(overlap(one, other))
        assert told[-1] == overlap(other, one)
    assert told[0]
    assert not told[-1]


def test_claims_are_the_data_of_expected_features(two):
    _, _, front, _ = two
    mine = claims(front)
    assert set(mine) == set(front.matches[front.candidate & front.detected].tolist())
    assert all(residual <= 3.0 for residual in mine.values())


def test_beside_an_occluder_hidden_features_claim_nothing(two):
    """A window of the tower in front is not claimed by a hidden window of the tower behind."""
    _, _, front, back = two
    assert set(claims(back, front)) <= set(claims(back))
    assert claims(front, back) == claims(front)
    both, share = shared_claims(front, back)
    assert share <= SHARED_CLAIMS
    assert both == set(claims(front)) & set(claims(back, front))


def test_apart_nothing_is_shared():
    rng = np.random.default_rng(7202)
    shot = scene(rng, side_by_side(rng), clutter=0)
    of = data(shot)
    one, other = (posed_at(n, shot.poses[n], of) for n in ("t1", "t2"))
    assert shared_claims(one, other) == (set(), 0.0)


def test_a_copy_shares_all_claims():
    rng = np.random.default_rng(7203)
    pose = camera_pose(rng, (3.0, 5.0))
    of = data(scene(rng, {"t1": pose}))
    nearly = pose.copy()
    nearly[0, 3] += 1e-3
    one, other = posed_at("t1", pose, of), posed_at("t1", nearly, of)
    assert overlap(one, other)
    assert len(set(claims(one)) & set(claims(other))) > 0.8 * len(claims(one))


def test_shared_claims_are_symmetric(two):
    _, _, front, back = two
    assert shared_claims(front, back) == shared_claims(back, front)


def test_bodies_apart_on_the_screen_have_nothing_to_do_with_each_other():
    """Over random pairs: where it says apart, no corner of one is drawn near the other, and nothing is shared."""
    rng = np.random.default_rng(7300)
    of, told = data(scene(rng, {"t1": camera_pose(rng)})), []
    for _ in range(120):
        one, other = (posed_at(name, camera_pose(rng, (3.0, 9.0), rng.uniform(-3, 3, 3)), of) for name in ("t1", "t2"))
        told.append(apart_on_screen(one, other, CAMERA.f, 8.0))
        assert told[-1] == apart_on_screen(other, one, CAMERA.f, 8.0)
        if told[-1]:
            corners = [
                transform_points(posed.camera_from_object, posed.object_type.surface.vertices) for posed in (one, other)
            ]
            first, second = (CAMERA.f * some[:, :2] / some[:, 2:] for some in corners)
            assert np.linalg.norm(first[:, None] - second[None], axis=2).min() > 8.0
            assert not overlap(one, other)
            assert not hidden_by(one, other).any()
            assert not hidden_by(other, one).any()
    assert 10 < sum(told) < 110
