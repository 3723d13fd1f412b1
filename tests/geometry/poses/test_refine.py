import numpy as np
import pytest
from geometry_bodies import CAMERA, LENS, random_rotations

from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, is_rigid, pose_error, rotation_from_quat_xyzw, transform_points
from geometry.poses.refine import Steps, refine_poses, refined_poses


def scene(seed, count=40, *, camera=CAMERA, noise=0.5, start=0.1):
    rng = np.random.default_rng(seed)
    objects = rng.uniform(-0.6, 0.6, (count, 12, 3))
    places = np.c_[rng.uniform(-0.5, 0.5, (count, 2)), rng.uniform(3, 8, count)]
    poses = from_rotation_translation(random_rotations(rng, count), places)
    uv = camera.project(transform_points(poses, objects)) + rng.normal(0, noise, (count, 12, 2))
    nudge = rotation_from_quat_xyzw(np.c_[rng.normal(0, start / 2, (count, 3)), np.ones(count)])
    guess = poses.copy()
    guess[:, :3, :3] = nudge @ guess[:, :3, :3]
    guess[:, :3, 3] += rng.normal(0, start, (count, 3))
    return guess, objects, uv, np.ones((count, 12)), poses


@pytest.mark.parametrize("camera", [CAMERA, LENS])
def test_exact_points_are_fitted_exactly(camera):
    guess, objects, uv, weights, poses = scene(0, camera=camera, noise=0)
    found, rms, _ = refine_poses(guess, objects, uv, weights, camera, 15)
    assert np.allclose(pose_error(found, poses), 0, atol=1e-5)
    assert rms.max() < 1e-3


def test_the_same_minimum_as_opencvs_solve_pnp():
    cv2 = pytest.importorskip("cv2")
    guess, objects, uv, weights, _ = scene(1, camera=LENS)
    found, _, _ = refine_poses(guess, objects, uv, weights, LENS, 20)
    assert len(guess) > 0
    for k in range(len(guess)):
        r, t = cv2.Rodrigues(guess[k, :3, :3])[0], guess[k, :3, 3].copy().reshape(3, 1)
        ideal = LENS.to_pixels(LENS.normalised(uv[k]))  # the residuals that we minimise
        r, t = cv2.solvePnPRefineLM(objects[k], ideal, np.array(LENS.K), np.zeros(4), r, t, (3, 200, 1e-14))
        theirs = from_rotation_translation(cv2.Rodrigues(r)[0], t.ravel())
        assert np.allclose(pose_error(found[k], theirs), 0, atol=1e-5)


def test_no_pose_gets_worse_and_all_stay_rigid():
    guess, objects, uv, weights, _ = scene(2, start=0.6)
    before = refine_poses(guess, objects, uv, weights, CAMERA, 0)[1]
    found, after, _ = refine_poses(guess, objects, uv, weights, CAMERA)
    assert np.all(after <= before)
    assert all(is_rigid(pose) for pose in found)


def test_zero_weight_is_a_missing_point():
    guess, objects, uv, weights, _ = scene(3)
    weights[:, 3:6] = 0
    uv[:, 3:6], objects[:, 4] = np.nan, np.nan
    kept = [0, 1, 2, *range(6, 12)]
    with_gaps = refine_poses(guess, objects, uv, weights, CAMERA)
    without = refine_poses(guess, objects[:, kept], uv[:, kept], weights[:, kept], CAMERA)
    assert len(with_gaps[0]) == len(guess) > 0
    for a, b in zip(with_gaps, without, strict=True):
        assert np.allclose(a, b, atol=1e-9)


def test_the_order_of_the_points_changes_nothing():
    guess, objects, uv, weights, _ = scene(4)
    order = np.random.default_rng(0).permutation(12)
    a = refine_poses(guess, objects, uv, weights, CAMERA)[0]
    b = refine_poses(guess, objects[:, order], uv[:, order], weights, CAMERA)[0]
    assert np.allclose(a, b, atol=1e-8)


def test_huber_bears_an_outlier():
    guess, objects, uv, weights, poses = scene(5, start=0.05)
    uv[:, 0] += 60
    plain = np.median(pose_error(refine_poses(guess, objects, uv, weights, CAMERA, 20)[0], poses)[0])
    robust = np.median(pose_error(refine_poses(guess, objects, uv, weights, CAMERA, 20, huber=1.0)[0], poses)[0])
    assert robust < plain / 4


def test_the_covariance_is_that_of_repeated_measurement():
    guess, objects, uv, weights, poses = scene(6, count=1, noise=0, start=1e-6)
    rng = np.random.default_rng(1)
    many = [np.repeat(array, 3000, axis=0) for array in (guess, objects, uv, weights)]
    many[2] = many[2] + rng.normal(0, 1.0, many[2].shape)
    found, rms, covariance = refine_poses(*many, CAMERA)
    spread = np.cov(found[:, :3, 3].T)
    assert np.allclose(np.sqrt(np.diag(spread)), np.sqrt(np.diag(covariance[0])[3:]), rtol=0.1)
    turns = pose_error(found, poses)[0]
    assert np.isclose(np.sqrt((turns**2).mean()), np.sqrt(np.trace(covariance[0][:3, :3])), rtol=0.1)
    assert np.isclose((rms**2).mean(), 2 * (24 - 6) / 24, rtol=0.05)  # 24 numbers, 6 of them fitted


def test_too_few_points_leave_the_covariance_infinite():
    guess, objects, uv, weights, _ = scene(7, count=3)
    weights[0, 2:], weights[1] = 0, 0
    found, rms, covariance = refine_poses(guess, objects, uv, weights, CAMERA)
    assert np.isinf(np.diagonal(covariance[:2], axis1=1, axis2=2)).all()
    assert np.isfinite(covariance[2]).all()
    assert np.isfinite(found).all()
    assert np.isnan(rms[1])


def test_a_point_behind_the_camera_is_an_infinite_error():
    guess, objects, uv, weights, _ = scene(8, count=2)
    guess[0, 2, 3] = -5
    found, rms, _ = refine_poses(guess, objects, uv, weights, CAMERA)
    assert np.isinf(rms[0])
    assert np.isfinite(rms[1])
    assert np.isfinite(found).all()


@pytest.mark.parametrize("huber", [None, 1.0])
def test_the_poses_alone_are_the_same(huber):
    guess, objects, uv, weights, _ = scene(10, camera=LENS)
    alone = refined_poses(guess, objects, uv, weights, LENS, Steps(5), huber=huber)
    assert np.array_equal(alone, refine_poses(guess, objects, uv, weights, LENS, 5, huber=huber)[0])


def test_bad_shapes_and_weights_are_refused():
    guess, objects, uv, weights, _ = scene(9, count=2)
    with pytest.raises(GeometryError, match="must agree"):
        refine_poses(guess[:1], objects, uv, weights, CAMERA)
    with pytest.raises(GeometryError, match="not negative"):
        refine_poses(guess, objects, uv, -weights, CAMERA)
