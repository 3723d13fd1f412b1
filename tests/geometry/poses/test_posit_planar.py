import numpy as np
from geometry_bodies import CAMERA, random_rotations
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.frames import from_rotation_translation, pose_error, transform_points
from geometry.poses.posit import posit_planar


def scene(seed, count, points=5):
    rng = np.random.default_rng(seed)
    objects = np.concatenate([rng.uniform(-0.6, 0.6, (count, points, 2)), np.zeros((count, points, 1))], axis=-1)
    objects = objects @ np.swapaxes(random_rotations(rng, count), 1, 2) + rng.uniform(-1, 1, (count, 1, 3))
    poses = from_rotation_translation(
        random_rotations(rng, count), np.c_[rng.uniform(-0.5, 0.5, (count, 2)), np.full(count, 6)]
    )
    return objects, poses, CAMERA.project(transform_points(poses, objects)), rng


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_one_of_the_two_branches_is_the_pose(seed):
    objects, poses, uv, _ = scene(seed, 40)
    found, ok = posit_planar(objects, CAMERA.normalised(uv))
    rotation, _ = pose_error(found, poses[:, None])
    nearest = np.where(ok, rotation, np.inf).min(axis=1)[ok.any(axis=1)]
    assert ok.any(axis=1).mean() > 0.8
    assert np.percentile(nearest, 85) < 1e-3


def test_the_better_reprojection_comes_first_and_the_two_differ():
    objects, poses, uv, _ = scene(1, 400, 7)
    found, ok = posit_planar(objects, CAMERA.normalised(uv))
    off = np.linalg.norm(CAMERA.project(transform_points(found, objects[:, None])) - uv[:, None], axis=-1).mean(axis=-1)
    both = ok.all(axis=1)
    assert both.mean() > 0.5
    assert np.all(off[both, 0] <= off[both, 1] + 1e-9)
    between, _ = pose_error(found[both, 0], found[both, 1])
    assert np.median(between) > 0.2
    right, _ = pose_error(found[both, 0], poses[both])
    assert np.median(right) < 1e-6


def test_solid_collinear_and_unknown_sets_are_refused():
    objects, _, uv, rng = scene(2, 6)
    xy = CAMERA.normalised(uv)
    objects[0] = rng.uniform(-1, 1, (5, 3))
    objects[1] = np.linspace(0, 1, 5)[:, None] * [1, 2, 3]
    objects[2] = 0.5
    xy[3, 2] = np.nan
    found, ok = posit_planar(objects, xy)
    assert not ok[:4].any()
    assert ok[4:].any(axis=1).all()
    assert np.isfinite(found).all()
