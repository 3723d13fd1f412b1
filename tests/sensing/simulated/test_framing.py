"""Scenes of any size: the same scene in other units, things that cover a fair part of the picture."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.frames import transform_points
from sensing.errors import SceneError
from sensing.simulated.framing import COVER, Framing, framing_of, resized
from sensing.simulated.robot import Robot
from sensing.simulated.scene import box, random_scene


def shapes(size: float):
    rng = np.random.default_rng(0)
    mesh = box(np.array([0.6, 0.6, 1.5]), rng, painted=True), box(np.array([0.8, 0.7, 1.0]), rng, painted=False)
    return [("tall", resized(mesh[0], size)), ("low", resized(mesh[1], size))]


@pytest.mark.parametrize("unit", [1 / 32, 4.0])
def test_a_scene_in_another_unit_is_the_same_picture_with_all_lengths_in_proportion(unit):
    one = random_scene(shapes(1.0), 2, decoys=1)
    other = random_scene(shapes(unit), 2, decoys=1, framing=Framing(unit))
    first, second = one.photograph(1), other.photograph(1)
    assert np.array_equal(first.image, second.image)
    assert np.array_equal(np.float32(unit) * first.depth, second.depth)
    assert np.array_equal(one.camera_from_bodies[:, :3, :3], other.camera_from_bodies[:, :3, :3])
    assert np.allclose(unit * one.camera_from_bodies[:, :3, 3], other.camera_from_bodies[:, :3, 3], rtol=1e-12)
    assert one.visible_shares() == other.visible_shares() == other.fractions
    assert other.bodies[0].mesh.vertices == pytest.approx(shapes(unit)[0][1].vertices)


@pytest.mark.parametrize("size", [0.03, 0.2, 1.1, 40.0])
def test_things_of_any_size_cover_a_fair_part_of_the_picture(size):
    things = shapes(size)
    spans = [np.ptp(mesh.vertices, axis=0) for _, mesh in things]
    framing = framing_of(
        max(float(np.linalg.norm(span)) for span in spans), max(float(np.linalg.norm(span[:2])) for span in spans)
    )
    assert np.log2(framing.unit) == round(np.log2(framing.unit))
    scene = random_scene(things, 1, framing=framing)
    rows = zip(scene.camera_from_bodies, scene.bodies, strict=True)
    heights = [np.ptp(scene.camera.project(transform_points(pose, b.mesh.vertices))[:, 1]) / 480 for pose, b in rows]
    low, high = COVER if framing.unit != 1.0 else (0.05, 1.0)
    assert len(heights) == 2
    assert low - 0.01 <= min(heights) <= max(heights) <= high + 0.01


def test_towers_have_the_unit_of_a_metre_and_are_asked_for_no_share_of_the_height():
    assert framing_of(1.8, 1.0) == Framing()


def test_a_camera_that_is_told_where_to_stand_stands_there_or_says_that_it_cannot():
    away = random_scene(shapes(1.0)[:1], 0, framing=Framing(distance=(6.5, 6.5), reach=None))
    middle = away.bodies[0].vertices_world.mean(axis=0)
    assert away.camera.world_from_camera is not None
    assert np.linalg.norm(away.camera.world_from_camera[:3, 3] - middle) == pytest.approx(6.5, abs=0.1)
    with pytest.raises(SceneError, match="at another distance, with fewer or with another seed, there may be room"):
        random_scene(shapes(1.0), 0, framing=Framing(distance=(0.3, 0.3), reach=None))


def test_a_robot_s_room_is_as_large_as_the_scene():
    robot = Robot(random_scene(shapes(1 / 32), 3, framing=Framing(1 / 32)))
    start = np.array(robot.world_from_camera)
    assert robot.why_not(start) is None
    below, beyond = start.copy(), start.copy()
    below[2, 3], beyond[0, 3] = 0.002, 0.7
    assert robot.why_not(below) == "is 0.00 m above the floor; 0.003125 m are the least"
    assert robot.why_not(beyond) == "is outside the room, which reaches 0.625 m from the middle of the scene"


def test_more_things_have_a_larger_floor():
    scene = random_scene([*shapes(1.0), *shapes(1.0), *shapes(1.0)][:5], 1)
    assert len(scene.bodies) == 5
    assert min(scene.fractions) > 0.97
