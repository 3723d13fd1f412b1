"""Table-top scenes: patterns, the sensor, pictures by rays against projected points, and scenes as asked for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.tabletop.patterns import PATTERNS, pattern, printed_box, printed_can, random_package, words
from benchmarks.tabletop.rgbd_sensor import RgbdSensor, _streak, random_sensor, sensed
from benchmarks.tabletop.scene import Arrangement, bounds, hull, recognition_scene, seen_fractions
from benchmarks.tabletop.table import Table, photographed
from geometry.camera import Camera
from geometry.frames import inverse, is_rigid, look_at, transform_points
from sensing.errors import SceneError
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.raycast import TexturePyramid, corner_normals
from sensing.simulated.scene import truth_to_dict
from sensing.simulated.surroundings import Light

YCB = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "ycb"
CLEAN = RgbdSensor(noise=0, blur=0)


def shapes():
    rng = np.random.default_rng(7)
    boxes = [(f"box{i}", printed_box(rng.uniform((0.06, 0.05, 0.08), (0.12, 0.09, 0.2)), rng)) for i in range(3)]
    return [*boxes, ("can", printed_can(0.034, 0.1, rng))]


def camera(eye=(0.5, -0.4, 0.5), size=(160, 120), f=150.0):
    K = [[f, 0, size[0] / 2], [0, f, size[1] / 2], [0, 0, 1]]
    return Camera(*size, np.array(K), np.zeros(0), inverse(look_at(eye, (0, 0, 0.05))))


def at(x, y):
    pose = np.eye(4)
    pose[:2, 3] = x, y
    return pose


def volume(mesh: TexturedMesh) -> float:
    a, b, c = np.moveaxis(mesh.corners, 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize("name", sorted(PATTERNS))
def test_a_pattern_is_the_same_for_the_same_seed_and_another_for_another(name):
    first, second, other = (pattern(name, np.random.default_rng(s), 256) for s in (1, 1, 2))
    assert first.shape == (256, 256, 3)
    assert first.dtype == np.uint8
    assert np.array_equal(first, second)
    assert not np.array_equal(first, other)


def test_an_unknown_pattern_is_one_clear_line():
    with pytest.raises(SceneError, match="pattern 'marble': not one of plain, noise, wood"):
        pattern("marble", np.random.default_rng(0), 64)
    assert len(words(np.random.default_rng(0), 3).split()) == 3


def test_packages_are_closed_and_face_outward():
    rng = np.random.default_rng(3)
    size = np.array([0.1, 0.06, 0.2])
    assert volume(printed_box(size, rng)) == pytest.approx(np.prod(size))
    assert volume(printed_can(0.03, 0.1, rng)) == pytest.approx(np.pi * 0.03**2 * 0.1, rel=0.01)
    for _ in range(5):
        mesh = random_package(rng)
        assert mesh.vertices[:, 2].min() == 0
        assert mesh.uv.min() >= 0
        assert mesh.uv.max() <= 1


def test_a_texture_is_read_at_its_texels_and_averaged_from_afar():
    texture = np.zeros((64, 64, 3), np.uint8)
    texture[::2, ::2] = texture[1::2, 1::2] = 200
    texture[0, 0] = 90
    pyramid = TexturePyramid(texture)
    upper_left = np.array([[0.5 / 64, 1 - 0.5 / 64]])
    assert pyramid.at(upper_left, np.array([1.0])).tolist() == [[90, 90, 90]]
    assert pyramid.at(np.array([[0.5, 0.5]]), np.array([4.0])) == pytest.approx(100, abs=1)
    assert pyramid.size == (64, 64)


def test_a_box_has_sharp_edges_and_a_can_is_round():
    rng = np.random.default_rng(0)
    box, can = printed_box(np.array([0.1, 0.1, 0.1]), rng), printed_can(0.03, 0.1, rng)
    assert corner_normals(box) == pytest.approx(np.repeat(box.normals[:, None], 3, axis=1))
    wall = np.abs(can.normals[:, 2]) < 0.5
    radial = can.corners[wall][:, :, :2] / 0.03
    assert corner_normals(can)[wall][:, :, :2] == pytest.approx(radial, abs=0.04)  # flat facets would be 0.098 off
    assert corner_normals(can)[~wall] == pytest.approx(np.repeat(can.normals[~wall][:, None], 3, axis=1))


def test_a_perfect_sensor_shows_the_light_as_it_is():
    light = np.random.default_rng(0).uniform(0, 255, (20, 30, 3)).astype(np.float32)
    assert np.array_equal(sensed(light, CLEAN), np.rint(light).astype(np.uint8))


def test_over_exposure_clips_and_vignetting_darkens_the_corners():
    light = np.full((21, 31, 3), 150, np.float32)
    assert (sensed(light, RgbdSensor(noise=0, blur=0, gain=1.8)) == 255).all()
    dark = sensed(light, RgbdSensor(noise=0, blur=0, vignette=0.4))
    assert dark[10, 15].tolist() == [150] * 3
    assert dark[0, 0].tolist() == [90] * 3
    assert (sensed(light, RgbdSensor(noise=0, blur=0, gamma=0.7)) > 150).all()


def test_noise_has_its_deviation_and_jpeg_leaves_its_traces():
    light = np.full((200, 200, 3), 128, np.float32)
    noisy = sensed(light, RgbdSensor(noise=8, blur=0, seed=5))
    assert noisy.std() == pytest.approx(8, rel=0.05)
    assert np.array_equal(noisy, sensed(light, RgbdSensor(noise=8, blur=0, seed=5)))
    packed = sensed(light, RgbdSensor(noise=8, blur=0, seed=5, jpeg=40))
    assert packed.shape == noisy.shape
    assert 0 < np.abs(packed.astype(float) - noisy).mean() < 12


@pytest.mark.parametrize("length", [0.5, 3.0, 6.4])
def test_motion_keeps_the_light_and_its_centre(length):
    kernel = _streak(length, 0.7)
    half = len(kernel) // 2
    assert kernel.sum() == pytest.approx(1)
    row, column = np.indices(kernel.shape) - half
    assert (kernel * row).sum() == pytest.approx(0, abs=1e-5)
    assert (kernel * column).sum() == pytest.approx(0, abs=1e-5)
    assert np.sqrt((kernel * (row**2 + column**2)).sum()) >= length / np.sqrt(12)


def test_hardness_spans_from_a_good_camera_to_a_bad_one():
    easy, hard = (random_sensor(np.random.default_rng(2), h) for h in (0.0, 1.0))
    assert (easy.noise, easy.blur, easy.gain, easy.gamma, easy.motion, easy.vignette, easy.jpeg) == (
        1.5,
        0.4,
        1,
        1,
        0,
        0,
        95,
    )
    assert hard.noise > 1.5
    assert hard.jpeg < 95


def test_a_picture_by_rays_lies_where_points_project():
    body = Body("box", printed_box(np.array([0.2, 0.1, 0.15]), np.random.default_rng(0)), at(0.05, 0.0))
    view = camera()
    picture = photographed([body], view, Light(), Table(), CLEAN, supersample=1)
    v, u = np.nonzero(picture.segmentation == 0)
    low, high = bounds(body, view)
    assert [u.min(), v.min()] == pytest.approx(low, abs=1)
    assert [u.max(), v.max()] == pytest.approx(high, abs=1)
    points = view.rays(np.stack([u, v], axis=1).astype(float))
    points = points / points[:, 2:] * picture.depth[v, u][:, None]
    inside = transform_points(inverse(body.world_from_body) @ view.world_from_camera, points)
    assert (inside >= np.array([-0.1, -0.05, 0]) - 1e-4).all()
    assert (inside <= np.array([0.1, 0.05, 0.15]) + 1e-4).all()
    assert np.isfinite(picture.depth[0, 0])
    assert np.array_equal(picture.image, photographed([body], view, Light(), Table(), CLEAN, supersample=1).image)


def test_paint_is_not_mirrored_and_shadow_falls_away_from_the_lamp():
    texture = np.zeros((32, 32, 3), np.uint8)
    texture[:16, :16] = (0, 0, 255)  # the upper left is red
    square = np.array([(-0.1, 0, 0), (0.1, 0, 0), (0.1, 0, 0.2), (-0.1, 0, 0.2)])
    card = TexturedMesh(square, [(0, 1, 2), (0, 2, 3)], [(0, 0), (1, 0), (1, 1), (0, 1)], texture)
    view = camera(eye=(0, -0.7, 0.5))
    picture = photographed(
        [Body(None, card, at(0, 0))], view, Light((0.0, 1.0, 1.0)), Table(floor_pattern="plain"), CLEAN, supersample=2
    )
    v, u = np.nonzero((picture.image[:, :, 2] > 60) & (picture.segmentation == 0) & (picture.image[:, :, 0] < 20))
    assert len(u)
    camera_from_world = inverse(view.world_from_camera)
    assert [u.mean(), v.mean()] == pytest.approx(
        view.project(transform_points(camera_from_world, [(-0.05, 0, 0.15)])[0]), abs=2
    )
    before, beside = (
        view.project(transform_points(camera_from_world, [(0, -0.05, 0), (0.25, -0.05, 0)])).round().astype(int)
    )
    assert picture.image[before[1], before[0]].mean() < 0.8 * picture.image[beside[1], beside[0]].mean()


def test_a_table_needs_a_pose_and_a_body():
    with pytest.raises(SceneError, match="needs a pose"):
        photographed([], camera(), Light(), Table(), CLEAN)


def test_what_hides_a_body_is_in_its_fraction():
    rng = np.random.default_rng(1)
    front, back = (
        Body(n, printed_box(np.array([0.1, 0.1, 0.1]), rng), at(x, 0)) for n, x in (("front", 0.1), ("back", -0.1))
    )
    view = camera(eye=(0.7, 0.1, 0.2), size=(320, 240), f=300.0)
    fractions = seen_fractions([front, back], view)
    alone, both = (photographed(b, view, Light(), Table(), CLEAN, 1).segmentation for b in ([back], [front, back]))
    assert fractions[0] == 1
    assert fractions[1] == pytest.approx((both == 1).sum() / (alone == 0).sum(), abs=0.03)
    assert fractions[1] < 0.9


@pytest.mark.parametrize("seed", [5000, 5001, 5003])
def test_a_table_top_scene_is_as_it_was_asked_for(seed):
    scene = recognition_scene(shapes(), seed, arranged=Arrangement(bodies=(2, 3)), hard=0.5)
    labelled = [i for i, b in enumerate(scene.bodies) if b.label is not None]
    assert 2 <= len(labelled) <= 3
    assert [b.label for b in scene.bodies[len(labelled) :]] == [None] * (len(scene.bodies) - len(labelled))
    for i in labelled:
        body, pose = scene.bodies[i], scene.camera_from_bodies[i]
        assert is_rigid(pose)
        assert body.vertices_world[:, 2].min() == pytest.approx(0, abs=0.007)
        points = transform_points(pose, body.mesh.vertices)
        uv = scene.camera.project(points)
        assert scene.camera.contains(uv).all()
        assert 60 <= np.ptp(uv, axis=0).max() <= 200
        assert 0.5 <= np.linalg.norm(points.mean(axis=0)) <= 1.2
        assert 0.4 <= scene.fractions[i] <= 1
    assert len(truth_to_dict(scene)["objects"]) == len(scene.bodies)


def test_the_same_seed_gives_the_same_table_top_and_another_does_not():
    first, second, other = (
        recognition_scene(shapes(), seed, arranged=Arrangement(bodies=(2, 2))) for seed in (5004, 5004, 5005)
    )
    assert np.array_equal(first.camera_from_bodies, second.camera_from_bodies)
    assert first.surroundings == second.surroundings
    assert first.sensor == second.sensor
    assert first.surroundings != other.surroundings
    assert not np.array_equal(first.camera_from_bodies[0], other.camera_from_bodies[0])


def test_an_empty_scene_has_things_but_none_of_the_types():
    scene = recognition_scene(shapes(), 5006, empty=True)
    assert [b.label for b in scene.bodies] == [None] * len(scene.bodies)
    assert len(scene.bodies) >= 2


def test_a_hull_holds_its_mesh():
    mesh = shapes()[3][1]
    assert np.ptp(hull(mesh).vertices, axis=0) == pytest.approx(np.ptp(mesh.vertices, axis=0), abs=0.003)
    assert volume(mesh) > 0


@pytest.mark.skipif(not YCB.is_dir(), reason=f"the YCB meshes are not there ({YCB})")
def test_real_meshes_make_a_scene():
    from sensing.simulated.body import read_mesh

    real = [(n, read_mesh(YCB / n / "textured.obj")) for n in ("003_cracker_box", "025_mug", "077_rubiks_cube")]
    scene = recognition_scene(real, 5010, arranged=Arrangement(bodies=(3, 3)), hard=1.0)
    picture = scene.photograph(1)
    assert picture.image.shape == (480, 640, 3)
    assert {b.label for b in scene.bodies} - {None} <= {n for n, _ in real}
    seen = [(picture.segmentation == i).sum() for i, f in enumerate(scene.fractions) if f > 0.4]
    assert min(seen) > 300


def test_sharpening_raises_the_step_at_an_edge():
    picture = np.full((20, 20, 3), 80, np.float32)
    picture[:, 10:] = 160
    sharp = sensed(picture, replace(CLEAN, sharpening=1.0))
    assert (sharp[:, 9] < 80).all()
    assert (sharp[:, 10] > 160).all()
    assert (sharp[:, 0] == 80).all()
