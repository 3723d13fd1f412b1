"""A photo made small for its views, and its camera with it."""

import numpy as np
import pytest

from geometry.camera import Camera
from sensing.pixels.photo import LONGEST, Photo

K = np.array([[900.0, 0.0, 800.0], [0.0, 910.0, 450.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("size", [(1600, 900), (900, 1600), (LONGEST + 1, 40)])
def test_what_is_seen_in_a_pixel_is_seen_in_the_small_one_about_it(size):
    camera = Camera(*size, K, np.array([0.1, -0.05, 0.001, 0.0]))
    small = Photo(np.zeros((*size[::-1], 3), np.uint8), camera).small
    assert max(small.image.shape) == LONGEST
    assert small.image.shape[:2] == (small.camera.height, small.camera.width)
    points = np.random.default_rng(0).uniform([-0.4, -0.2, 1.0], [0.4, 0.2, 2.0], (50, 3))
    by = np.array([small.camera.width, small.camera.height]) / size
    assert np.abs((camera.project(points) + 0.5) * by - 0.5 - small.camera.project(points)).max() < 1e-9


def test_a_bright_spot_is_where_its_camera_has_it():
    image = np.zeros((960, 1280, 3), np.uint8)
    image[400:416, 800:816] = 255
    small = Photo(image, Camera(1280, 960, K)).small
    v, u = np.nonzero(small.image[..., 0])
    weight = small.image[v, u, 0].astype(float)
    seen = np.average(np.column_stack([u, v]), axis=0, weights=weight)
    ray = np.linalg.inv(K) @ [807.5, 407.5, 1.0]
    assert np.abs(small.camera.project(ray) - seen).max() < 0.02


def test_a_photo_that_is_small_is_itself():
    photo = Photo(np.zeros((480, LONGEST, 3), np.uint8), Camera(LONGEST, 480, K))
    assert photo.small is photo
