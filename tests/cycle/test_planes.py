"""Support planes abduced from proposals: the laws of formalism §9.9."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.bodies.resting import Plane, resting_faces
from geometry.bodies.standing import joined, ways
from geometry.frames import from_rotation_translation, look_at, turn_about
from plogic.cycle import planes
from plogic.cycle.planes import Bodies, supported

RESTS = 0.9
BOX = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.04, 0.04) for z in (-0.03, 0.03)])
FACES = resting_faces(BOX)
EYE = look_at(np.array([0.5, 0.3, 0.6]), np.zeros(3))
TABLE = Plane(EYE[:3, 2], float(-EYE[:3, 2] @ EYE[:3, 3]))
SPREAD = np.diag([0.01, 0.01, 0.01]) ** 2


SHARP = {"tilt": 0.01, "spread": SPREAD / 25.0}
"""Noise of poses known to half a degree and 2 mm."""


def pose(x, y, turn=0.0, height=0.0, tip=0.0):
    turned = turn_about([0.0, 0.0, 1.0], turn) @ turn_about([1.0, 0.0, 0.0], tip)
    return EYE @ from_rotation_translation(turned, (x, y, 0.03 + height))


def bodies(poses, odds, kinds=None, tilt=0.05, spread=SPREAD, put=()):
    stands = joined([ways(k, FACES, some, np.zeros(3), tilt, spread) for k, some in enumerate(poses)])
    names = tuple(f"t{k}" for k in range(len(poses)))
    return Bodies(
        names,
        np.arange(len(poses)) if kinds is None else np.array(kinds),
        np.array(odds, float),
        stands,
        np.isin(range(len(poses)), put),
    )


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.floats(-3.0, 8.0))
def test_one_alone_keeps_its_probability(seed, odds):
    rng = np.random.default_rng(seed)
    found = supported(bodies([pose(*rng.uniform(-0.2, 0.2, 2), rng.uniform(0, 6))], [odds]), RESTS)
    assert found.worth[0] == pytest.approx(0.0, abs=0.05)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(2, 5))
def test_naming_them_in_another_order_changes_nothing(seed, count):
    rng = np.random.default_rng(seed)
    poses = [pose(*rng.uniform(-0.2, 0.2, 2), rng.uniform(0, 6), rng.choice([0.0, 0.1])) for _ in range(count)]
    odds, order = rng.uniform(-2.0, 6.0, count), rng.permutation(count)
    found = supported(bodies(poses, odds), RESTS)
    again = supported(bodies([poses[k] for k in order], odds[order]), RESTS)
    np.testing.assert_allclose(again.worth, found.worth[order], atol=1e-6)


def test_several_find_the_plane_and_each_gains_by_the_others():
    poses = [pose(0.0, 0.0), pose(0.2, 0.1, 1.0), pose(-0.1, 0.15, 2.0)]
    found = supported(bodies(poses, [2.0, 2.0, 2.0]), RESTS)
    assert found.planes[0].known.plane.up @ TABLE.up > np.cos(np.radians(2.0))
    assert found.planes[0].known.plane.offset == pytest.approx(TABLE.offset, rel=0.02)
    assert found.probability[0] > 0.9
    assert found.planes[0].by == ("t0", "t1", "t2")
    assert (found.worth > 2.0).all()
    two = supported(bodies(poses[:2], [2.0, 2.0]), RESTS)
    assert (found.worth[:2] > two.worth).all()


def test_what_floats_beside_others_loses_what_resting_is_worth_and_is_free():
    poses = [pose(0.0, 0.0), pose(0.2, 0.1, 1.0), pose(-0.1, 0.15, 2.0), pose(0.1, -0.1, 0.5, 0.15, 0.5)]
    found = supported(bodies(poses, [4.0] * 4), RESTS)
    assert found.worth[3] == pytest.approx(np.log(1.0 - RESTS), abs=0.1)
    assert found.planes[0].by == ("t0", "t1", "t2")


def test_what_stands_on_another_gains_as_well():
    poses = [pose(0.0, 0.0), pose(0.2, 0.1, 1.0), pose(-0.1, 0.15, 2.0), pose(0.01, 0.0, 0.5, 0.06)]
    found = supported(bodies(poses, [4.0] * 4, **SHARP), RESTS)
    aside = supported(bodies([*poses[:3], pose(0.1, -0.1, 0.5, 0.06)], [4.0] * 4, **SHARP), RESTS)
    assert found.planes[0].by == ("t0", "t1", "t2")
    assert found.worth[3] > 2.0
    assert found.worth[3] - 1.0 > aside.worth[3] > 0.0  # level, but on nothing that is known
    leaning = supported(bodies([*poses[:3], pose(0.1, -0.1, 0.5, 0.06, 0.5)], [4.0] * 4, **SHARP), RESTS)
    assert leaning.worth[3] == pytest.approx(np.log(1.0 - RESTS), abs=0.1)


def test_stacks_of_three_stand_and_a_fourth_is_on_something_unknown():
    stack = [pose(0.01 * k, 0.0, 0.3 * k, 0.06 * k) for k in range(4)]
    three = [pose(0.2, 0.1, 1.0), pose(-0.1, 0.15, 2.0), *stack[:3]]
    found = supported(bodies(three, [4.0] * 5, **SHARP), RESTS)
    aside = supported(bodies([*three[:4], pose(0.1, -0.1, 0.5, 0.12)], [4.0] * 5, **SHARP), RESTS)
    assert found.worth[4] - 1.0 > aside.worth[4] > 0.0
    four = supported(bodies([*three, stack[3]], [4.0] * 6, **SHARP), RESTS)
    assert found.worth[4] - 1.0 > four.worth[5] > 0.0


def test_rivals_of_one_type_do_not_speak_for_a_plane_together():
    poses = [pose(0.0, 0.0), pose(0.2, 0.1, 1.0)]
    found = supported(bodies(poses, [2.0, 2.0], [0, 0]), RESTS)
    assert np.abs(found.worth).max() < 0.5


@pytest.mark.parametrize("chance", [0.05, 0.3, 0.9])
def test_what_would_stand_by_chance_gains_no_more_than_that_allows(monkeypatch, chance):
    poses = [pose(0.0, 0.0), pose(0.2, 0.1, 1.0), pose(-0.1, 0.15, 2.0), pose(0.1, -0.1, 0.5, 0.15, 0.5)]
    worth = []
    for part in (0.0, chance):
        monkeypatch.setattr(planes, "FREE", planes.Chance(part, 0.0))
        worth.append(supported(bodies(poses, [3.0] * 4), RESTS).worth)
    assert (worth[1][:3] <= np.log(RESTS / chance) + 0.01).all()
    np.testing.assert_array_less(worth[1][:3], worth[0][:3])


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.floats(0.1, 0.3))
def test_what_is_level_on_nothing_that_is_known_gains_less_than_what_stands(height):
    poses = [pose(0.0, 0.0), pose(0.2, 0.1, 1.0), pose(-0.1, 0.15, 2.0)]
    found = supported(bodies([*poses, pose(0.1, -0.1, 0.5, height)], [4.0] * 4, **SHARP), RESTS)
    most = np.log(RESTS * planes.RAISED / planes.FREE.level)
    assert 0.0 < found.worth[3] <= most + 0.01 < found.worth[:3].min()


def test_what_was_looked_for_on_a_plane_gains_by_standing_there_still_and_loses_where_it_left_or_the_plane_is_another():
    poses = [pose(0.0, 0.0), pose(0.2, 0.1, 1.0), pose(-0.1, 0.15, 2.0), pose(0.1, -0.1, 0.5)]
    sure = supported(bodies(poses, [4.0] * 4, put=[3]), RESTS)
    assert sure.probability[0] > 0.95
    assert -0.7 * np.log(planes.PUT.on) < sure.worth[3] <= -np.log(planes.PUT.on)
    left = supported(bodies([*poses[:3], pose(0.1, -0.1, 0.5, 0.15, 0.5)], [4.0] * 4, put=[3]), RESTS)
    assert left.worth[3] == pytest.approx(np.log((1.0 - RESTS) / (1.0 - sum(planes.PUT))), abs=0.1)
    tipped = [pose(0.0, 0.0, 0.0, 0.0, 0.9), pose(0.2, 0.1, 1.0, 0.0, 0.9), poses[3]]
    assert supported(bodies(tipped, [4.0, 4.0, 2.0], put=[2]), RESTS).worth[2] < 0.5


def of_table(found):
    return max(range(len(found.planes)), key=lambda k: found.planes[k].known.plane.up @ TABLE.up)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.floats(-2.0, 5.0))
def test_what_was_looked_for_on_a_plane_speaks_for_it_less_than_what_was_found_anywhere(odds):
    poses = [pose(0.0, 0.0), pose(0.2, 0.1, 1.0)]
    some, more = (supported(bodies(poses, [3.0, odds], put=put), RESTS) for put in ([1], []))
    said, free = (one.told[of_table(one), 1] - one.told[-1, 1] for one in (some, more))
    there = 1.0 / (1.0 + np.exp(-odds))
    assert 0.0 < said <= np.log(1.0 - there + there / planes.PUT.on) + 1e-9
    assert said <= free + 1e-6


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(2, 4))
def test_poses_off_by_little_give_the_plane_within_a_degree_and_five_millimetres(seed, count):
    rng = np.random.default_rng(seed)
    poses = [pose(0.3 * k - 0.4, rng.uniform(-0.2, 0.2), rng.uniform(0, 6)) for k in range(count)]
    for some in poses:
        axis = rng.normal(size=3)
        some[:3, :3] = turn_about(axis / np.linalg.norm(axis), 0.007 * rng.normal()) @ some[:3, :3]
        some[:3, 3] *= 1.0 + 0.003 * rng.normal()
    found = supported(bodies(poses, [9.0] * count, **SHARP), RESTS)
    plane, middle = found.planes[0].known.plane, np.mean([some[:3, 3] for some in poses], axis=0)
    assert found.planes[0].by == tuple(f"t{k}" for k in range(count))
    assert np.degrees(np.arccos(min(1.0, plane.up @ TABLE.up))) < 1.0
    assert abs(plane.height(middle) - TABLE.height(middle)) < 0.005


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.floats(-np.pi, np.pi))
def test_a_camera_turned_in_its_plane_turns_the_plane(roll):
    turn = from_rotation_translation(turn_about([0.0, 0.0, 1.0], roll), np.zeros(3))
    poses = [pose(0.0, 0.0), pose(0.2, 0.1, 1.0), pose(-0.1, 0.15, 2.0)]
    plain, turned = (
        supported(bodies([motion @ some for some in poses], [5.0] * 3), RESTS) for motion in (np.eye(4), turn)
    )
    np.testing.assert_allclose(turned.worth, plain.worth, atol=1e-6)
    np.testing.assert_allclose(
        turned.planes[0].known.plane.up, turn[:3, :3] @ plain.planes[0].known.plane.up, atol=1e-6
    )


@pytest.mark.parametrize("other", [pose(0.2, 0.1, 1.0, height=0.05), pose(0.2, 0.1, 1.0, tip=0.5)])
def test_two_that_begin_at_different_heights_or_lean_agree_on_no_plane(other):
    found = supported(bodies([pose(0.0, 0.0), other], [9.0, 9.0], **SHARP), RESTS)
    assert max(len(plane.by) for plane in found.planes) == 1


def test_nothing_stands_on_a_ceiling():
    below = look_at(np.array([0.5, 0.3, -0.6]), np.zeros(3)) @ np.linalg.inv(EYE)
    found = supported(bodies([below @ pose(0.0, 0.0), below @ pose(0.2, 0.1, 1.0)], [9.0, 9.0], **SHARP), RESTS)
    assert min((plane.known.plane.offset for plane in found.planes), default=1.0) > 0.0


def test_of_nothing_nothing_is_told():
    assert not len(supported(bodies([], []), RESTS).worth)
    assert supported(bodies([pose(0.0, 0.0)], [1.0]), 0.0).worth[0] == pytest.approx(0.0, abs=1e-9)
