import numpy as np
import pytest
from geometry_bodies import CAMERA, random_rotations
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, pose_error, transform_points
from geometry.poses.posit import posit


def scene(seed, count, points=4, spread=0.6, nearest=4.0):
    """Random point sets, poses 4-9 m ahead, and their pixels."""
    rng = np.random.default_rng(seed)
    objects = rng.uniform(-spread, spread, (count, points, 3))
    places = np.c_[rng.uniform(-0.8, 0.8, (count, 2)), rng.uniform(nearest, 9, count)]
    poses = from_rotation_translation(random_rotations(rng, count), places)
    return objects, poses, CAMERA.project(transform_points(poses, objects)), rng


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(4, 8))
def test_exact_points_give_the_exact_pose_or_show_that_they_did_not(seed, points):
    objects, poses, uv, _ = scene(seed, 20, points)
    found = posit(objects, CAMERA.normalised(uv))
    rotation, translation = pose_error(found.camera_from_object, poses)
    exact = (rotation < 1e-3) & (translation < 1e-2)
    shown = found.residual * CAMERA.f > 1e-3  # px: another fixed point, or one that is slow to reach
    assert np.all(exact | shown | ~found.ok)
    assert np.mean(exact) > 0.5


def test_half_a_pixel_of_noise_is_borne_by_what_is_accepted():
    objects, poses, uv, rng = scene(1, 4000, spread=0.5)
    xy = CAMERA.normalised(uv + rng.normal(0, 0.5, uv.shape))
    found = posit(objects, xy)
    rotation, _ = pose_error(found.camera_from_object, poses)
    assert found.ok.mean() > 0.4
    assert np.degrees(np.percentile(rotation[found.ok], 90)) < 8
    assert np.degrees(np.percentile(rotation[~found.ok], 90)) > 20  # the refused would have been poison


def test_nearly_flat_quadruples_are_refused():
    objects, _, _, rng = scene(2, 500)
    objects[..., 2] *= 0.02
    poses = from_rotation_translation(random_rotations(rng, 500), [0, 0, 6])
    uv = CAMERA.project(transform_points(poses, objects)) + rng.normal(0, 0.5, (500, 4, 2))
    assert posit(objects, CAMERA.normalised(uv)).ok.mean() < 0.02


def test_condition_predicts_the_error_to_first_order():
    objects, poses, uv, rng = scene(3, 4000)
    found = posit(objects, CAMERA.normalised(uv + rng.normal(0, 0.1, uv.shape)))
    rotation, _ = pose_error(found.camera_from_object, poses)
    ratio = rotation[found.ok] / (found.condition[found.ok] * 0.1 / CAMERA.f)
    assert 0.5 < np.median(ratio) < 2


def test_the_poses_do_not_depend_on_the_batch_around_them():
    objects, _, uv, _ = scene(4, 50)
    xy = CAMERA.normalised(uv)
    together = posit(objects, xy, iterations=12)
    alone = posit(objects[7:8], xy[7:8], iterations=12)
    assert np.allclose(together.camera_from_object[7], alone.camera_from_object[0], atol=1e-8)


def test_moving_the_objects_origin_moves_the_pose_with_it():
    objects, _, uv, _ = scene(5, 50)
    shift = np.array([3.0, -2.0, 1.0])
    here, there = (posit(points, CAMERA.normalised(uv)).camera_from_object for points in (objects, objects + shift))
    assert np.allclose(transform_points(here, objects), transform_points(there, objects + shift), atol=1e-6)


def test_degenerate_sets_are_refused_and_harm_no_neighbour():
    objects, poses, uv, _ = scene(6, 8, spread=0.6)
    xy = CAMERA.normalised(uv)
    good = posit(objects, xy).ok
    objects[0], objects[1, :, 2], objects[2] = 0.0, 0.0, np.linspace(0, 1, 4)[:, None] * [1, 1, 1]
    xy[3] = np.nan
    found = posit(objects, xy)
    assert not found.ok[:4].any()
    assert found.ok[4:].tolist() == good[4:].tolist()
    assert good[4:].any()
    assert np.isfinite(found.camera_from_object).all()
    assert np.isinf(found.condition[:3]).all()
    assert np.isfinite(poses).all()


def test_an_impossible_match_shows_in_the_residual():
    objects, _, uv, _ = scene(7, 200)
    right, wrong = (posit(objects, CAMERA.normalised(pixels)) for pixels in (uv, uv[:, [1, 0, 3, 2]]))
    assert np.median(right.residual[right.ok]) * CAMERA.f < 1e-3
    assert wrong.ok.mean() < right.ok.mean()


@pytest.mark.parametrize("shape", [(5, 3, 3), (4, 3), (5, 4, 2)])
def test_wrong_shapes_are_refused(shape):
    with pytest.raises(GeometryError):
        posit(np.zeros(shape), np.zeros((5, 4, 2)))


def test_an_empty_batch_is_an_answer():
    assert posit(np.zeros((0, 4, 3)), np.zeros((0, 4, 2))).ok.shape == (0,)
