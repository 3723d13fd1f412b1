"""Points that may lie anywhere along a line.

What of an offset counts, in the pose, in its distance and in its covariance.
"""

import numpy as np
import pytest
from geometry_bodies import CAMERA, LENS, random_rotations
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, pose_error, transform_points
from geometry.poses.refine import refine_poses
from geometry.poses.reprojection import information

SEEDS = st.integers(0, 9999)
COUNT = 24


def ideal(camera, poses, objects):
    """(B, N, 2) undistorted pixels."""
    return camera.to_pixels(camera.normalised(camera.project(transform_points(poses, objects))))


def scene(seed, ways, *, camera=CAMERA, noise=0.0, start=0.03):
    """Guesses, points, pixels, weights, unit vectors across lines of angles ``ways``, and true poses, of 3 objects."""
    rng = np.random.default_rng(seed)
    objects = rng.uniform(-0.6, 0.6, (3, COUNT, 3))
    poses = from_rotation_translation(
        random_rotations(rng, 3), np.c_[rng.uniform(-0.5, 0.5, (3, 2)), rng.uniform(3, 6, 3)]
    )
    uv = camera.project(transform_points(poses, objects)) + rng.normal(0, noise, (3, COUNT, 2))
    guess = turned(poses, rng.normal(0, start, (3, 6)))
    angle = np.resize(ways, (3, COUNT))
    return guess, objects, uv, np.ones((3, COUNT)), np.stack([np.cos(angle), np.sin(angle)], axis=2), poses


def turned(poses, step):
    """Poses (B, 4, 4) after a turn by w about their origins, to first order made a rotation again, and a move by v.

    Steps (B, 6).
    """
    result = poses.copy()
    for k, (w, v) in enumerate(zip(step[:, :3], step[:, 3:], strict=True)):
        cross = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        left, _, right = np.linalg.svd(np.eye(3) + cross)
        result[k, :3, :3] = left @ right @ poses[k, :3, :3]
        result[k, :3, 3] += v
    return result


def along(across):
    return np.stack([-across[..., 1], across[..., 0]], axis=-1)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([CAMERA, LENS]), st.sampled_from([None, 2.0]))
def test_points_without_a_line_count_as_before(seed, camera, huber):
    guess, objects, uv, weights, _, _ = scene(seed, [0.0], camera=camera, noise=1.0)
    plain = refine_poses(guess, objects, uv, weights, camera, huber=huber)
    nowhere = refine_poses(guess, objects, uv, weights, camera, huber=huber, across=np.full((3, COUNT, 2), np.nan))
    assert len(plain[0]) == len(guess) > 0
    for one, other in zip(plain, nowhere, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(SEEDS, st.floats(0.0, np.pi))
def test_two_lines_at_a_right_angle_through_a_place_are_the_place(seed, angle):
    guess, objects, uv, weights, _, _ = scene(seed, [0.0], noise=1.0)
    one = np.broadcast_to([np.cos(angle), np.sin(angle)], uv.shape)
    twice = [np.concatenate([array, array], axis=1) for array in (objects, uv, weights)]
    found, rms, covariance = refine_poses(guess, *twice, CAMERA, 15, across=np.concatenate([one, along(one)], axis=1))
    plain, plain_rms, plain_covariance = refine_poses(guess, objects, uv, weights, CAMERA, 15)
    np.testing.assert_allclose(found, plain, atol=1e-7)
    np.testing.assert_allclose(rms, plain_rms / np.sqrt(2.0), rtol=1e-6)
    np.testing.assert_allclose(covariance, plain_covariance, rtol=1e-4, atol=1e-12)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    SEEDS,
    st.lists(st.floats(-3.2, 3.2), min_size=1, max_size=COUNT),
    st.sampled_from([None, 2.0]),
    st.floats(1.0, 50.0),
)
def test_a_pixel_moved_along_its_line_changes_nothing(seed, ways, huber, far):
    guess, objects, uv, weights, across, _ = scene(seed, ways, noise=1.0)
    moved = uv + np.random.default_rng(seed).normal(0, far, (3, COUNT, 1)) * along(across)
    one = refine_poses(guess, objects, uv, weights, CAMERA, 4, huber=huber, across=across)
    other = refine_poses(guess, objects, moved, weights, CAMERA, 4, huber=huber, across=across)
    np.testing.assert_allclose(one[0], other[0], atol=1e-6)
    np.testing.assert_allclose(one[1], other[1], rtol=1e-6, atol=1e-9)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(SEEDS, st.lists(st.floats(-3.2, 3.2), min_size=1, max_size=COUNT))
def test_which_way_across_a_line_is_named_changes_nothing(seed, ways):
    guess, objects, uv, weights, across, _ = scene(seed, ways, noise=1.0)
    one, other = (refine_poses(guess, objects, uv, weights, CAMERA, 4, across=sign * across) for sign in (1.0, -1.0))
    assert len(one[0]) == len(guess) > 0
    for mine, its in zip(one, other, strict=True):
        np.testing.assert_allclose(mine, its, rtol=1e-9, atol=1e-12)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(SEEDS, st.floats(0.0, np.pi), st.integers(3, 8), st.sampled_from([CAMERA, LENS]))
def test_a_pose_is_recovered_from_places_anywhere_along_lines_of_three_directions(seed, first, number, camera):
    guess, objects, _, weights, across, poses = scene(seed, first + np.pi * np.arange(number) / number, camera=camera)
    at = ideal(camera, poses, objects)
    anywhere = at + np.random.default_rng(seed).uniform(-15, 15, (3, COUNT, 1)) * along(across)
    seen = camera.project(np.concatenate([rays(camera, anywhere), np.ones((3, COUNT, 1))], axis=2))
    found, rms, covariance = refine_poses(guess, objects, seen, weights, camera, 30, across=across)
    assert np.allclose(pose_error(found, poses), 0, atol=1e-5)
    assert rms.max() < 1e-3
    assert np.isfinite(covariance).all()


def rays(camera, pixels):
    """(..., 2) of undistorted pixels, by the matrix alone."""
    return np.linalg.solve(camera.K[:2, :2], (pixels - camera.K[:2, 2])[..., None])[..., 0]


@settings(max_examples=25, deadline=None, derandomize=True)
@given(SEEDS, st.lists(st.floats(-3.2, 3.2), min_size=1, max_size=COUNT), st.sampled_from([None, 1.0]))
def test_no_pose_gets_worse_and_the_distance_is_that_across_the_lines(seed, ways, huber):
    guess, objects, uv, weights, across, _ = scene(seed, ways, noise=2.0)
    weights = weights * np.random.default_rng(seed).uniform(0.1, 3.0, COUNT)
    before = refine_poses(guess, objects, uv, weights, CAMERA, 0, across=across)[1]
    found, after, _ = refine_poses(guess, objects, uv, weights, CAMERA, across=across, huber=huber)
    for poses, rms in ((guess, before), (found, after)):
        off = ((ideal(CAMERA, poses, objects) - uv) * across).sum(axis=2)
        np.testing.assert_allclose(
            rms, np.sqrt((weights * off**2).sum(axis=1) / weights.sum(axis=1)), rtol=1e-6, atol=1e-9
        )
    assert huber is not None or (after <= before + 1e-12).all()


def by_differences(poses, objects, camera):
    """(N, 2, 6) d pixel / d (w, v) of one pose, by moving it both ways."""
    tiny, slopes = 1e-6, []
    for axis in range(6):
        step = np.zeros((2, 6))
        step[:, axis] = tiny, -tiny
        ahead, behind = (ideal(camera, turned(poses, step[i : i + 1]), objects)[0] for i in (0, 1))
        slopes.append((ahead - behind) / (2 * tiny))
    return np.stack(slopes, axis=-1)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, st.lists(st.floats(-3.2, 3.2), min_size=1, max_size=COUNT), st.integers(0, COUNT))
def test_information_is_that_of_a_jacobian_by_differences(seed, ways, points):
    """The first ``points`` are to be met, the others lie along lines.

    What counts of them is one number, their offset across.
    """
    _, objects, _, weights, across, poses = scene(seed, ways)
    weights = weights[0] * np.random.default_rng(seed).uniform(0.1, 3.0, COUNT)
    across, pose, some = across[0].copy(), poses[:1], objects[:1]
    across[:points] = np.nan
    slopes, expected = by_differences(pose, some, CAMERA), np.zeros((6, 6))
    for i in range(COUNT):
        rows = slopes[i] if i < points else across[i] @ slopes[i][None]
        rows = rows.reshape(-1, 6)
        expected += weights[i] * rows.T @ rows
    found = information(transform_points(pose, some)[0], pose[0, :3, 3], weights, CAMERA, across)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-5 * np.abs(expected).max())
    assert (
        np.linalg.eigvalsh(information(transform_points(pose, some)[0], pose[0, :3, 3], weights, CAMERA) - found)
        > -1e-3
    ).all()


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, st.floats(0.0, np.pi), st.floats(0.3, 2.0))
def test_the_covariance_is_the_inverse_of_the_information(seed, first, weight):
    guess, objects, uv, weights, across, _ = scene(seed, first + np.array([0.0, 1.0, 2.0]), start=0.0)
    covariance = refine_poses(guess, objects, uv, weight * weights, CAMERA, 0, across=across)[2]
    for k in range(3):
        known = information(
            transform_points(guess, objects)[k], guess[k, :3, 3], weight * weights[k], CAMERA, across[k]
        )
        np.testing.assert_allclose(covariance[k] @ known, np.eye(6), atol=1e-5)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, st.floats(0.0, np.pi))
def test_one_direction_of_lines_leaves_the_pose_unfixed(seed, angle):
    """All may move along the lines.

    Some points that are to be met fix it again, and so do lines of another direction.
    """
    _, objects, uv, weights, across, poses = scene(seed, [angle])
    assert np.isinf(
        np.diagonal(refine_poses(poses, objects, uv, weights, CAMERA, across=across)[2], axis1=1, axis2=2)
    ).all()
    some, others = across.copy(), across.copy()
    some[:, :4], others[:, : COUNT // 2] = np.nan, along(across)[:, : COUNT // 2]
    for fixed in (some, others):
        assert np.isfinite(refine_poses(poses, objects, uv, weights, CAMERA, across=fixed)[2]).all()


def test_a_missing_point_may_have_any_line():
    guess, objects, uv, weights, across, _ = scene(3, [0.1, 1.2, 2.3], noise=1.0)
    weights[:, 3:6], uv[:, 3:6], across[:, 4] = 0, np.nan, np.nan
    kept = [0, 1, 2, *range(6, COUNT)]
    with_gaps = refine_poses(guess, objects, uv, weights, CAMERA, across=across)
    without = refine_poses(guess, objects[:, kept], uv[:, kept], weights[:, kept], CAMERA, across=across[:, kept])
    assert len(without[0]) == len(guess) > 0
    for one, other in zip(with_gaps, without, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_huber_bears_a_line_that_is_another_s():
    guess, objects, uv, weights, across, poses = scene(5, [0.0, 1.0, 2.0], noise=0.3)
    uv[:, 0] += 60 * across[:, 0]
    plain, robust = (
        pose_error(refine_poses(guess, objects, uv, weights, CAMERA, 20, huber=huber, across=across)[0], poses)[0]
        for huber in (None, 1.0)
    )
    assert np.median(robust) < np.median(plain) / 4


def test_lines_that_do_not_fit_the_points_are_refused():
    guess, objects, uv, weights, across, _ = scene(6, [0.0, 1.0])
    for wrong in (across[:1], across[:, :1], across[:, :5], across[0], np.zeros((3, COUNT, 3))):
        with pytest.raises(GeometryError, match="across"):
            refine_poses(guess, objects, uv, weights, CAMERA, across=wrong)
