"""A camera that moves in the simulated world: where it can be, what it sees there, and the folder of its way."""

from __future__ import annotations

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from geometry.files.pose_files import read_poses
from geometry.frames import inverse, look_at
from sensing.errors import SceneError
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.camera import Sensor
from sensing.simulated.robot import Robot, write_tour
from sensing.simulated.scene import Scene, default_camera
from sensing.simulated.surroundings import Light, Surroundings

SMALL = replace(default_camera(), width=96, height=72, K=np.array([[90.0, 0, 48], [0, 90.0, 36], [0, 0, 1]]))


def _box(label, x):
    import trimesh

    mesh = trimesh.creation.box((0.4, 0.4, 0.8))
    pose = np.eye(4)
    pose[:3, 3] = x, 0, 0.4
    return Body(label, TexturedMesh(np.asarray(mesh.vertices), np.asarray(mesh.faces)), pose)


def _at(x, y, z=1.2):
    return inverse(look_at((x, y, z), (0, 0, 0.4)))


@pytest.fixture
def robot():
    bodies = (_box("near", 0.8), _box("far", -0.8))
    camera = replace(SMALL, world_from_camera=_at(4, 0, 0.5))
    return Robot(Scene(bodies, camera, Light((0.3, 0.2, 0.9)), Surroundings(), Sensor(), (1.0, 1.0)))


@pytest.mark.parametrize(
    ("place", "told"),
    [
        (_at(0.8, 0.01, 0.5), "inside or nearer than 0.1 m to 'near'"),
        (_at(3, 0, 0.05), "above the floor"),
        (_at(30, 0), "outside the room"),
        (np.zeros((4, 4)), "rigid"),
    ],
)
def test_it_stays_where_it_is_where_it_cannot_go(robot, place, told):
    before = robot.world_from_camera
    with pytest.raises(SceneError, match=told):
        robot.move_to(place)
    assert np.array_equal(robot.world_from_camera, before)


def test_what_was_hidden_is_seen_from_elsewhere(robot):
    hidden = robot.scene().fractions[1]
    robot.move_to(_at(0, 4))
    assert robot.scene().fractions[1] > hidden + 0.3
    assert [b.label for b in robot.scene().bodies] == ["near", "far"]


def test_each_look_has_noise_of_its_own_and_the_same_looks_are_the_same(robot):
    first, second = (robot.look(1).image for _ in range(2))
    again = Robot(robot.scene()).look(1).image
    assert not np.array_equal(first, second)
    assert np.array_equal(first, again)


def test_a_ring_is_level_and_turned_to_the_middle(robot):
    places = robot.ring(6)
    eyes = np.array([p[:3, 3] for p in places])
    assert np.allclose(places[0][:3, 3], robot.world_from_camera[:3, 3])
    assert np.allclose(eyes[:, 2], eyes[0, 2])
    middle = np.array([inverse(p)[:3, :3] @ robot.middle + inverse(p)[:3, 3] for p in places])
    assert np.allclose(middle[:, :2], 0.0, atol=1e-9)
    assert len({tuple(np.round(e, 6)) for e in eyes}) == 6


def test_the_folder_of_a_way_holds_a_frame_a_place_and_its_poses(robot, tmp_path):
    places = [robot.world_from_camera, _at(0, 4)]
    write_tour(robot, places, tmp_path / "way", supersample=1)
    poses = read_poses(tmp_path / "way" / "poses.json")
    assert np.allclose([p.world_from_camera for p in poses], places)
    assert [p.frame for p in poses] == ["frame-000/image.png", "frame-001/image.png"]
    frame = tmp_path / "way" / "frame-001"
    assert cv2.imread(str(frame / "image.png")).shape == (72, 96, 3)
    assert np.allclose(json.loads((frame / "camera.json").read_text())["T_world_camera"], places[1])
    assert [o["label"] for o in json.loads((frame / "truth.json").read_text())["objects"]] == ["near", "far"]


def test_nothing_is_written_where_one_place_cannot_be_reached(robot, tmp_path):
    with pytest.raises(SceneError, match="move 2"):
        write_tour(robot, [_at(0, 4), _at(3, 0, 0.01)], tmp_path / "way", supersample=1)
    assert list(tmp_path.iterdir()) == []
