"""SoftPOSIT as a refiner: from a near pose to the true one."""

import numpy as np
import pytest
from softposit_scenes import PIXEL, off, scene

from benchmarks.clutter.near import softposit_near
from geometry.errors import GeometryError
from geometry.frames import pose_error
from geometry.poses.softposit import Annealing, softposit


def test_from_ten_degrees_and_three_percent_it_comes_home():
    """With types; without them it mostly does (``test_softposit.py``)."""
    right = 0
    for seed in range(10):
        model, xy, pose, allowed, _, rng = scene(seed, types=5, noise=0.5)
        found = softposit_near(off(pose, rng, 10.0, 0.03)[0], model, xy, off=25.0, allowed=allowed, pixel=PIXEL)
        if found.converged[0]:
            rotation, translation = pose_error(found.camera_from_object[0], pose)
            right += bool(np.degrees(rotation) < 1.0 and translation < 0.01 * np.linalg.norm(pose[:3, 3]))
    assert right >= 9


def test_it_is_softposit_from_a_beta_by_how_far_off_the_points_are():
    model, xy, pose, allowed, _, rng = scene(3, types=5)
    start = off(pose, rng, 10.0, 0.03)
    one = softposit_near(start[0], model, xy, off=20.0, allowed=allowed, pixel=PIXEL)
    other = softposit(model, xy, start, allowed=allowed, annealing=Annealing(beta=1.0 / 400.0, pixel=PIXEL))
    assert np.array_equal(one.camera_from_object, other.camera_from_object)
    assert np.array_equal(one.matches, other.matches)


def test_an_exact_pose_stays():
    model, xy, pose, allowed, _, _ = scene(4, types=5)
    found = softposit_near(pose, model, xy, off=0.1, allowed=allowed, pixel=PIXEL)
    assert found.converged.tolist() == [True]
    rotation, translation = pose_error(found.camera_from_object[0], pose)
    assert np.degrees(rotation) < 0.1
    assert translation < 1e-3 * np.linalg.norm(pose[:3, 3])


def test_without_data_it_does_not_converge():
    model, _, pose, _, _, _ = scene(5)
    assert softposit_near(pose, model, np.zeros((0, 2)), off=10.0).converged.tolist() == [False]


@pytest.mark.parametrize("wrong", [0.0, -1.0, np.nan])
def test_how_far_off_is_a_number_of_pixels(wrong):
    model, xy, pose, *_ = scene(6)
    with pytest.raises(GeometryError, match="off must be above 0"):
        softposit_near(pose, model, xy, off=wrong)
