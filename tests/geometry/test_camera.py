import numpy as np
import pytest
from geometry_bodies import CAMERA, LENS
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.camera import Camera, camera_from_dict, camera_to_dict, fold_radius
from geometry.errors import CameraError

K = [[600.0, 0, 320], [0, 600, 240], [0, 0, 1]]
cameras = st.sampled_from([CAMERA, LENS])
GOOD = {"width": 640, "height": 480, "K": K}


@settings(deadline=None)
@given(cameras, st.floats(0, 639), st.floats(0, 479), st.floats(0.1, 50))
def test_projecting_a_pixels_ray_gives_the_pixel(camera, u, v, distance):
    ray = camera.rays([u, v])
    assert np.isclose(np.linalg.norm(ray), 1)
    assert np.allclose(camera.project(ray * distance), [u, v], atol=1e-4)


@settings(deadline=None)
@given(cameras, st.floats(-2, 2), st.floats(-2, 2), st.floats(4, 20))
def test_normalised_undoes_projection(camera, x, y, z):
    assert np.allclose(camera.normalised(camera.project([x, y, z])), [x / z, y / z], atol=1e-7)


def test_a_point_on_the_axis_falls_on_the_principal_point():
    assert CAMERA.project([0, 0, 3]).tolist() == [320, 240]
    assert CAMERA.project([1, 0.5, 3]).tolist() == [520, 340]
    assert CAMERA.f == 600


@pytest.mark.parametrize("z", [-1.0, 0.0, 1e-7, np.nan])
def test_what_is_not_in_front_has_no_pixel(z):
    pixels = CAMERA.project([[0, 0, 2], [0.1, 0.1, z]])
    assert np.isfinite(pixels[0]).all()
    assert np.isnan(pixels[1]).all()
    assert CAMERA.contains(pixels).tolist() == [True, False]


def test_the_image_reaches_half_a_pixel_beyond_its_centres():
    edge = [[-0.5, -0.5], [-0.51, 0], [639.49, 479.49], [639.5, 0], [0, 479.5]]
    assert CAMERA.contains(edge).tolist() == [True, False, True, False, False]


def test_a_lens_shows_no_ghosts_past_its_fold():
    fold = fold_radius(np.array([-0.25, 0, 0, 0]))
    assert np.isclose(fold, np.sqrt(1 / 0.75))  # d(r - 0.25 r^3)/dr = 0
    camera = Camera(640, 480, np.array(K), np.array([-0.25, 0, 0, 0]))
    assert np.isfinite(camera.project([0.99 * fold, 0, 1])).all()
    assert np.isnan(camera.project([1.9 * fold, 0, 1])).all()  # would fall near the middle again


def test_a_lens_without_a_fold_has_no_bound():
    assert fold_radius(np.array([0.1, 0.01, 0, 0])) == np.inf


def test_arrays_are_copied_and_read_only():
    matrix = np.array(K)
    camera = Camera(640, 480, matrix)
    matrix[0, 0] = 1
    assert camera.K[0, 0] == 600
    with pytest.raises(ValueError, match="read-only"):
        camera.K[0, 0] = 1


@pytest.mark.parametrize("camera", [CAMERA, LENS, Camera(10, 10, np.array(K), np.zeros(0), np.eye(4))])
def test_dictionary_round_trip(camera):
    document = camera_to_dict(camera)
    assert camera_to_dict(camera_from_dict(document)) == document
    assert ("T_world_camera" in document) == (camera.world_from_camera is not None)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"width": 0}, "camera.width"),
        ({"width": 6.5}, "camera.width"),
        ({"height": True}, "camera.height"),
        ({"height": "480"}, "camera.height"),
        ({"width": 10**30}, "camera.width"),
        ({"K": [[600, 0], [0, 600]]}, "camera.K"),
        ({"K": [[600, 0, 320], [0, 600, 240], [0, 0, 2]]}, "camera.K"),
        ({"K": [[-600, 0, 320], [0, 600, 240], [0, 0, 1]]}, "camera.K: focal lengths"),
        ({"K": [[600, 0, np.nan], [0, 600, 240], [0, 0, 1]]}, "camera.K"),
        ({"K": [[600, 0, 320], [0, 600], [0, 0, 1]]}, "camera.K"),
        ({"K": "eye"}, "camera.K"),
        ({"dist": [0.1]}, "camera.dist"),
        ({"dist": [np.inf, 0, 0, 0]}, "camera.dist"),
        ({"dist": None}, "camera.dist"),
        ({"T_world_camera": np.zeros((4, 4)).tolist()}, "camera.T_world_camera"),
        ({"focal": 1}, "camera.focal: unknown key"),
    ],
)
def test_each_mistake_is_named(change, key):
    with pytest.raises(CameraError) as caught:
        camera_from_dict({**GOOD, **change})
    assert key in str(caught.value)
    assert "\n" not in str(caught.value)


def test_all_mistakes_come_at_once_and_under_the_callers_name():
    with pytest.raises(CameraError) as caught:
        camera_from_dict({"width": -1}, where="gamma.camera")
    for key in ("gamma.camera.width", "gamma.camera.height: is missing", "gamma.camera.K: is missing"):
        assert key in str(caught.value)
    with pytest.raises(CameraError, match="must be an object"):
        camera_from_dict([1, 2])
