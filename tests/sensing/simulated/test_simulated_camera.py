"""The simulated camera against projected points: what is drawn lies where the camera model says."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from sensing.errors import SceneError
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.camera import Sensor, render, visible_fractions
from sensing.simulated.surroundings import Light, Surroundings, brightness

CLEAN = Sensor(noise=0, blur=0)
DARK = Surroundings(floor=(0, 0, 0), background=(0, 0, 0), contrast=0, shadow=0)


def a_camera(eye=(3.0, -4.0, 2.0), target=(0.0, 0.0, 0.7), K=None, size=(640, 480)) -> Camera:
    K = np.array([[600, 0, 320], [0, 600, 240], [0, 0, 1.0]]) if K is None else K
    return Camera(*size, K, np.zeros(0), inverse(look_at(eye, target, (0, 0, 1))))


def a_ball(centre, radius=0.06, colour=(1.0, 1.0, 1.0)) -> Body:
    """An octahedron-born ball: its picture's centroid is its centre's, up to perspective far below 0.05 px."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=2, radius=radius)
    pose = np.eye(4)
    pose[:3, 3] = centre
    return Body("ball", TexturedMesh(ball.vertices, ball.faces, colour=colour), pose)


def a_box(size=(1.0, 1.0, 1.0), at=(0.0, 0.0, 0.5)) -> Body:
    import trimesh

    box = trimesh.creation.box(size)
    pose = np.eye(4)
    pose[:3, 3] = at
    return Body("box", TexturedMesh(box.vertices, box.faces, colour=(0.8, 0.8, 0.8)), pose)


@pytest.mark.parametrize("supersample", [1, 2, 3])
@pytest.mark.parametrize("K", [None, np.array([[520, 0, 301.3], [0, 560, 251.8], [0, 0, 1.0]])])
def test_a_drawn_ball_lies_where_its_centre_projects(supersample, K):
    centres = np.array([[0, 0, 0.7], [0.9, 0.3, 1.2], [-0.8, -0.5, 0.3], [0.2, 0.9, 0.1], [-1.0, 0.6, 1.4]])
    camera = a_camera(K=K)
    bodies = [a_ball(c) for c in centres]
    light = Light(ambient=1.0, lamp=0, sky=0, back=0)
    picture = render(bodies, camera, light, DARK, CLEAN, supersample)
    expected = camera.project(transform_points(inverse(camera.world_from_camera), centres))
    weights = picture.image.astype(float).sum(axis=2)
    v, u = np.mgrid[:480, :640]
    assert len(expected) == 5
    for (x, y), number in zip(expected, range(len(bodies)), strict=True):
        near = weights * (np.hypot(u - x, v - y) < 16)
        found = np.array([(near * u).sum(), (near * v).sum()]) / near.sum()
        assert np.abs(found - (x, y)).max() < 0.15, number


def test_depth_and_segmentation_are_those_of_the_ray_through_the_pixel_s_centre():
    camera = a_camera()
    picture = render([a_box()], camera, sensor=CLEAN)
    camera_from_world = inverse(camera.world_from_camera)
    top = np.array([[x, y, 1.0] for x in (-0.3, 0, 0.3) for y in (-0.3, 0, 0.3)])
    seen = transform_points(camera_from_world, top)
    for (u, v), z in zip(np.rint(camera.project(seen)).astype(int), seen[:, 2], strict=True):
        assert picture.segmentation[v, u] == 0
        assert picture.depth[v, u] == pytest.approx(z, abs=0.03)
    floor = np.array([[1.0, -1.5, 0.0]])
    seen = transform_points(camera_from_world, floor)
    (u, v), z = np.rint(camera.project(seen)[0]).astype(int), seen[0, 2]
    assert picture.segmentation[v, u] == -1
    assert picture.depth[v, u] == pytest.approx(z, abs=0.03)


def test_the_texture_is_not_mirrored_and_its_origin_is_below_left():
    quad = np.array([[-0.5, 0, 0], [0.5, 0, 0], [0.5, 0, 1], [-0.5, 0, 1.0]])
    texture = np.zeros((64, 64, 3), np.uint8)
    texture[:32, :32] = (255, 0, 0)  # upper left of the texture is blue
    mesh = TexturedMesh(quad, [[0, 1, 2], [0, 2, 3]], [[0, 0], [1, 0], [1, 1], [0, 1]], texture)
    camera = a_camera((0, -4, 0.5), (0, 0, 0.5))
    image = render([Body("board", mesh, np.eye(4))], camera, Light(ambient=1, lamp=0, sky=0, back=0), DARK, CLEAN).image
    assert image[200, 280].tolist() == pytest.approx([255, 0, 0], abs=3)
    assert [int(image[v, u].max()) for v, u in ((200, 360), (280, 280), (280, 360))] == pytest.approx([0, 0, 0], abs=3)


def test_facets_are_as_bright_as_the_light_says():
    camera, light = a_camera((2.0, -4.0, 2.5)), Light(direction=(1.0, 0.5, 0.7))
    image = render([a_box()], camera, light, DARK, CLEAN).image
    camera_from_world = inverse(camera.world_from_camera)
    for normal in ((0, 0, 1.0), (1.0, 0, 0), (0, -1.0, 0)):
        at = np.array([0, 0, 0.5]) + 0.5 * np.array(normal)
        u, v = np.rint(camera.project(transform_points(camera_from_world, at[None]))[0]).astype(int)
        shade = brightness(np.array([normal]), light)[0]
        assert float(image[v, u].mean()) == pytest.approx(255 * 0.8 * shade, abs=3)


def test_the_same_seed_gives_the_same_bytes_and_another_does_not():
    first, second = (render([a_box()], a_camera()).image for _ in range(2))
    assert np.array_equal(first, second)
    assert not np.array_equal(first, render([a_box()], a_camera(), sensor=Sensor(seed=1)).image)
    assert not np.array_equal(first, render([a_box()], a_camera(), surroundings=Surroundings(seed=1)).image)


def test_the_noise_has_the_stated_deviation():
    flat = replace(DARK, floor=(100, 100, 100), background=(100, 100, 100))
    quiet, noisy = (render([], a_camera(), None, flat, Sensor(noise=n, blur=0)).image.astype(float) for n in (0.0, 3.5))
    assert np.std(noisy - quiet) == pytest.approx(3.5, rel=0.03)


def test_visible_fractions_by_segmentation():
    near, far = a_box((0.5, 0.5, 1.0), (0, -1.0, 0.5)), a_box((0.5, 0.5, 1.0), (0, 1.0, 0.5))
    apart = a_box((0.5, 0.5, 1.0), (2.0, 1.0, 0.5))
    camera = a_camera((0, -6, 0.5), (0, 0, 0.5))
    hiding, hidden, free = visible_fractions([near, far, apart], camera)
    assert hiding == 1
    assert hidden < 0.05
    assert free == 1


def test_a_camera_without_a_pose_or_with_distortion_is_refused():
    camera = a_camera()
    with pytest.raises(SceneError, match="no pose"):
        render([], Camera(640, 480, camera.K, camera.dist))
    with pytest.raises(SceneError, match="no lens distortion"):
        render([], Camera(640, 480, camera.K, np.array([0.1, 0, 0, 0]), camera.world_from_camera))


def test_standard_output_stays_clean():
    program = (
        "import numpy as np; from geometry.camera import Camera; from sensing.simulated.camera import render; "
        "render([], Camera(64, 48, np.array([[60, 0, 32], [0, 60, 24], [0, 0, 1.0]]), np.zeros(0), np.eye(4))); print('done')"
    )
    answer = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert (answer.stdout, answer.stderr) == ("done\n", "")
