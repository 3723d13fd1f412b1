"""Support, where the knowledge base says that gravity holds.

Which plane things stand on, what is found there, and what is not lost by it.
"""

from dataclasses import replace

import numpy as np
import pytest
from painted_cube import CAMERA, SIDE, cloud, picture, seen, write_knowledge

from geometry.bodies.resting import Plane
from geometry.bodies.standing import Known
from geometry.frames import from_rotation_translation, look_at, pose_error, transform_points
from kb.files.read import read_kb
from plogic.match.gamma.data import data_of
from plogic.match.learned.keypoints import pairs_of
from plogic.match.learned.learned_poses import resting, set_down
from plogic.run.perceive import Perceiver
from sensing.detectors.detector import detect

EYE = look_at(np.array([0.42, 0.34, 0.38]), np.zeros(3))
"""camera_from_table: the table's plane is z = 0."""
TABLE = Plane(EYE[:3, 2], float(-EYE[:3, 2] @ EYE[:3, 3]))
PLACES = (0.06, -0.09), (-0.09, 0.06), (-0.02, -0.24)


def standing(x, y, degrees=0.0, height=0.0, tip=0.0):
    """camera_from_cube of a cube on the table, its own z axis up.

    ``height`` (m) above it, tipped by so many degrees.
    """
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    ct, st_ = np.cos(np.radians(tip)), np.sin(np.radians(tip))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, ct, -st_], [0, st_, ct]])
    return EYE @ from_rotation_translation(turn, (x, y, SIDE / 2 + height))


@pytest.fixture(scope="module")
def knowledge(tmp_path_factory):
    folder = write_knowledge(tmp_path_factory.mktemp("kb"), {"cube": cloud(seen())})
    (folder / "kb.yaml").write_text((folder / "kb.yaml").read_text() + "gravity: true\n")
    return read_kb(folder)


@pytest.fixture(scope="module")
def perceiver(knowledge):
    return Perceiver(knowledge)


@pytest.fixture(scope="module")
def index(perceiver):
    return perceiver.models["cube"]


def looked(perceiver, poses, seed=0):
    kb = perceiver.kb
    return perceiver(detect(picture(poses, seed=seed), CAMERA, kb.appearance_types, kb.words))


def accepted(document):
    return [np.array(h["T_camera_object"]) for h in document["hypotheses"] if h["status"] == "accepted"]


def steps(document):
    return [step["why"] for step in document["trace"] if step["event"] == "support"]


def same(found, truth):
    turned, moved = pose_error(found, truth)
    return turned < np.radians(5.0) and moved < 0.05 * np.linalg.norm(truth[:3, 3])


def test_everything_that_is_set_down_stands_on_a_face(perceiver, index):
    kb = perceiver.kb
    gamma = detect(picture([standing(*PLACES[0])]), CAMERA, kb.appearance_types, kb.words)
    data = data_of(gamma.appearances, CAMERA, perceiver.width)
    poses = set_down(index, pairs_of(index, data), TABLE, data)
    assert len(poses) > 10
    for pose in poses:
        heights = np.sort(TABLE.height(transform_points(pose, index.object_type.surface.vertices)))
        np.testing.assert_allclose(heights[[0, 3]], 0.0, atol=2e-3)


def test_on_the_plane_the_search_finds_what_stands_there_and_nothing_where_it_is_taken(perceiver, index):
    kb, truth = perceiver.kb, standing(*PLACES[0], 10.0)
    data = data_of(detect(picture([truth]), CAMERA, kb.appearance_types, kb.words).appearances, CAMERA, perceiver.width)
    found = resting(index, Known(TABLE, np.eye(3) * 1e-6), data, kb, np.zeros((0, 4)))
    assert any(same(posed.camera_from_object, truth) for _, posed in found)
    assert resting(
        index, Known(TABLE, np.eye(3) * 1e-6), data, kb, np.array([[*truth[:3, 3], index.inner_radius]])
    ) == [
        (worth, posed)
        for worth, posed in found
        if np.linalg.norm(posed.camera_from_object[:3, 3] - truth[:3, 3]) > 2.0 * index.inner_radius
    ]


def test_the_plane_is_told_and_a_floating_thing_is_not_lost(perceiver):
    truths = [standing(*PLACES[0]), standing(*PLACES[1], 12.0), standing(*PLACES[2], -8.0, 0.06, 15.0)]
    document = looked(perceiver, truths, seed=4)
    poses = accepted(document)
    assert len(poses) == 3
    assert all(any(same(pose, truth) for pose in poses) for truth in truths)
    assert steps(document)
    assert steps(document)[0].startswith("cube, cube stand on a plane (P ")
    assert "), 0.38 m below the camera: " in steps(document)[0]


def test_where_gravity_is_not_said_to_hold_nothing_is_asked_of_planes(perceiver, monkeypatch):
    truths = [standing(*PLACES[0]), standing(*PLACES[1], 12.0)]
    told = looked(perceiver, truths)
    assert steps(told)
    monkeypatch.setattr("plogic.cycle.support.supported", None)  # would not be callable
    untold = looked(Perceiver(replace(perceiver.kb, gravity=False)), truths)
    assert not steps(untold)
    assert [h["status"] for h in untold["hypotheses"]] == [h["status"] for h in told["hypotheses"]]


def test_the_tops_of_what_is_accepted_are_asked_as_well(perceiver):
    truths = [standing(*PLACES[0]), standing(*PLACES[1], 12.0), standing(*PLACES[0], 30.0, SIDE)]
    document = looked(perceiver, truths, seed=4)
    assert any(
        ", or on cube, cube, are tried" in why or ", or on cube, cube, cube, are tried" in why
        for why in steps(document)
    )
    assert all(any(same(pose, truth) for pose in accepted(document)) for truth in truths)
