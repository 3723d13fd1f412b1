"""Random scenes: at rest, apart, in view whole, partly hidden where asked, and the same for the same seed."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geometry.camera import camera_from_dict
from geometry.frames import inverse, is_rigid, transform_points
from sensing.errors import SceneError, SensingError
from sensing.simulated.body import Body, TexturedMesh, read_mesh
from sensing.simulated.physics import settle
from sensing.simulated.scene import box, random_decoy, random_scene, truth_to_dict, wedge, write_scene


def shapes():
    rng = np.random.default_rng(0)
    return [
        ("tall", box(np.array([0.6, 0.6, 1.5]), rng, painted=True)),
        ("ramp", wedge(np.array([0.8, 0.7, 1.3]), rng, painted=False)),
    ]


def volume(mesh: TexturedMesh) -> float:
    a, b, c = np.moveaxis(mesh.corners, 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("placement", ["beside", "hiding"])
def test_a_scene_is_as_it_was_asked_for(seed, placement):
    scene = random_scene(shapes(), seed, decoys=seed % 2, placement=placement)
    assert [b.label for b in scene.bodies] == ["tall", "ramp", None][: 2 + seed % 2]
    for pose, body in zip(scene.camera_from_bodies, scene.bodies, strict=True):
        assert is_rigid(pose)
        assert body.vertices_world[:, 2].min() == pytest.approx(0, abs=0.005)
        points = transform_points(pose, body.mesh.vertices)
        assert scene.camera.contains(scene.camera.project(points)).all()
        assert 2 < np.linalg.norm(points.mean(axis=0)) < 10
    labelled = scene.fractions[:2]
    assert min(labelled) >= (0.97 if placement == "beside" else 0.5)
    assert placement == "beside" or min(labelled) <= 0.92


def test_the_same_seed_gives_the_same_scene_and_another_does_not():
    first, second, other = (random_scene(shapes(), seed, decoys=1) for seed in (3, 3, 4))
    assert np.array_equal(first.camera_from_bodies, second.camera_from_bodies)
    assert np.array_equal(first.photograph(1).image, second.photograph(1).image)
    assert not np.array_equal(first.camera_from_bodies[0], other.camera_from_bodies[0])


def test_decoys_alone_and_a_hiding_scene_of_one():
    assert [b.label for b in random_scene([], 1, decoys=3).bodies] == [None] * 3
    with pytest.raises(SceneError, match="needs two shapes, not 1"):
        random_scene(shapes()[:1], placement="hiding")


def test_decoys_are_closed_and_face_outward():
    for seed in range(20):
        mesh = random_decoy(np.random.default_rng(seed))
        size = np.ptp(mesh.vertices, axis=0)
        assert volume(mesh) in (pytest.approx(np.prod(size)), pytest.approx(np.prod(size) / 2))
        assert mesh.vertices[:, 2].min() == 0


def test_a_body_falls_and_comes_to_rest_on_the_floor():
    pose = np.eye(4)
    pose[:3, 3] = (1, 2, 0.2)
    (rested,) = settle([Body("box", shapes()[0][1], pose)], drop=0.1)
    assert rested.vertices_world[:, 2].min() == pytest.approx(0, abs=0.004)
    assert rested.world_from_body[:2, 3] == pytest.approx([1, 2], abs=0.02)
    assert rested.world_from_body[2, 2] == pytest.approx(1, abs=1e-3)


def test_a_scene_s_folder_is_whole_and_its_truth_is_true(tmp_path):
    scene = random_scene(shapes(), 5)
    write_scene(scene, tmp_path / "a" / "scene", supersample=1)
    folder = tmp_path / "a" / "scene"
    assert sorted(p.name for p in folder.iterdir()) == ["camera.json", "image.png", "truth.json"]
    camera = camera_from_dict(json.loads((folder / "camera.json").read_text()))
    truth = json.loads((folder / "truth.json").read_text())
    assert truth == truth_to_dict(scene)
    for row, body in zip(truth["objects"], scene.bodies, strict=True):
        assert row["label"] == body.label
        world = camera.world_from_camera @ np.array(row["T_camera_object"])
        assert world == pytest.approx(body.world_from_body)
    write_scene(random_scene(shapes(), 5), tmp_path / "b", supersample=1)
    assert all((tmp_path / "b" / p.name).read_bytes() == p.read_bytes() for p in folder.iterdir())


def test_a_folder_with_something_in_it_is_left_alone(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(SensingError, match="not an empty folder"):
        write_scene(random_scene(shapes(), 5), tmp_path, supersample=1)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


def test_a_mesh_file_is_read_with_its_texture(tmp_path):
    import cv2

    cv2.imwrite(str(tmp_path / "paint.png"), np.full((8, 8, 3), (10, 200, 30), np.uint8))
    (tmp_path / "m.mtl").write_text("newmtl m\nmap_Kd paint.png\n")
    (tmp_path / "m.obj").write_text(
        "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1000 0 0\nv 0 1000 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    )
    mesh = read_mesh(tmp_path / "m.obj", 0.001)
    assert mesh.texture is not None
    assert mesh.texture[0, 0].tolist() == [10, 200, 30]
    assert np.ptp(mesh.vertices, axis=0).tolist() == [1, 1, 0]


def test_a_mesh_that_is_missing_or_none_is_one_clear_line(tmp_path):
    with pytest.raises(SceneError, match="no such mesh file"):
        read_mesh(tmp_path / "none.obj")
    (tmp_path / "bad.ply").write_text("nothing of the kind")
    with pytest.raises(SceneError, match=r"bad\.ply"):
        read_mesh(tmp_path / "bad.ply")
    with pytest.raises(SceneError, match="no triangle"):
        TexturedMesh(np.zeros((3, 3)), np.zeros((0, 3)))
    with pytest.raises(SceneError, match="not finite"):
        TexturedMesh(np.full((3, 3), np.nan), [[0, 1, 2]])


def test_poses_and_camera_agree():
    scene = random_scene(shapes(), 2)
    again = scene.camera.world_from_camera @ scene.camera_from_bodies[0]
    assert again == pytest.approx(scene.bodies[0].world_from_body)
    assert inverse(scene.camera.world_from_camera) @ scene.camera.world_from_camera == pytest.approx(np.eye(4))
