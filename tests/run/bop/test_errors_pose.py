"""MSSD, MSPD, ADD and ADD-S by hand, and their laws."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from plogic.run.bop.json_files import Place
from plogic.run.bop.models import symmetry_motions
from plogic.run.bop.recalls import AT_ONCE, add, add_s, mspd, mssd

CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float) / 2
NONE = np.eye(4)[None]
X = Place(Path("x"))
K = np.array([[500.0, 0, 320], [0, 400, 240], [0, 0, 1]])
QUARTER = {"symmetries_discrete": [[0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]]}
"""A quarter turn about z, as in models_info.json."""
ROUND = {"symmetries_continuous": [{"axis": [0, 0, 1], "offset": [0, 0, 0]}]}

numbers = st.floats(-2, 2)
quats = st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: np.linalg.norm(q) > 0.1)


def pose(quat=(0, 0, 0, 1), t=(0, 0, 5)):
    return from_rotation_translation(rotation_from_quat_xyzw(quat), t)


def turn(degrees, t=(0, 0, 5)):
    """A turn about z."""
    half = np.radians(degrees) / 2
    return pose((0, 0, np.sin(half), np.cos(half)), t)


poses = st.builds(lambda q, t: pose(q, np.add(t, (0, 0, 9))), quats, st.tuples(numbers, numbers, numbers))


def test_a_cube_turned_about_its_axis_of_symmetry():
    """Without the symmetry every vertex of the unit cube travels a side (its chord over 90° at radius √½).

    With it, nothing.
    """
    assert mssd(turn(90), turn(0), CUBE, NONE) == pytest.approx(1.0)
    assert mssd(turn(90), turn(0), CUBE, symmetry_motions(QUARTER, X)) == pytest.approx(0.0, abs=1e-12)
    assert mspd(turn(90), turn(0), CUBE, NONE, K) > 1
    assert mspd(turn(90), turn(0), CUBE, symmetry_motions(QUARTER, X), K) == pytest.approx(0.0, abs=1e-9)
    assert add(turn(90), turn(0), CUBE) == pytest.approx(1.0)
    assert add_s(turn(90), turn(0), CUBE) == pytest.approx(0.0, abs=1e-12)


def test_a_symmetry_stands_on_the_side_of_the_object():
    """P̄S, not SP̄: with the truth turned about x, the quarter turn is still about the object's own z."""
    truth = pose((np.sqrt(0.5), 0, 0, np.sqrt(0.5)))
    assert mssd(truth @ turn(90, (0, 0, 0)), truth, CUBE, symmetry_motions(QUARTER, X)) == pytest.approx(0, abs=1e-12)
    back = mssd(truth @ turn(-90, (0, 0, 0)), truth, CUBE, symmetry_motions(QUARTER, X))
    assert back == pytest.approx(1), "the list is taken as it is, not as a group"


def test_a_translation():
    """Every vertex travels 3-4-12's 13."""
    moved, still = pose(t=(3, 4, 17)), pose()
    assert add(moved, still, CUBE) == pytest.approx(13)
    assert mssd(moved, still, CUBE, NONE) == pytest.approx(13)
    assert add_s(moved, still, np.zeros((1, 3))) == pytest.approx(13)


def test_add_is_the_mean_and_mssd_the_maximum():
    """A half turn about z of points at 1, 2 and 6 from the axis: they travel 2, 4 and 12."""
    points = np.array([[1.0, 0, 0], [2, 0, 0], [6, 0, 0]])
    assert add(turn(180), turn(0), points) == pytest.approx(6)
    assert mssd(turn(180), turn(0), points, NONE) == pytest.approx(12)


def test_add_s_goes_to_the_nearest():
    """Truth at 0 and 10, estimate at 4 and 14: 0 → 4 is 4, 10 → 14 is 4, ADD 4.

    At 9 and 19: 0 → 9 is 9, 10 → 9 is 1, ADD-S 5.
    """
    points = np.array([[0.0, 0, 0], [10, 0, 0]])
    assert add_s(pose(t=(4, 0, 5)), pose(), points) == pytest.approx(4)
    assert add_s(pose(t=(9, 0, 5)), pose(), points) == pytest.approx(5)
    assert add(pose(t=(9, 0, 5)), pose(), points) == pytest.approx(9)


def test_a_known_shift_in_pixels():
    """0.1 m to the right at 5 m is 500 · 0.1 / 5 = 10 px, 0.1 m down 400 · 0.1 / 5 = 8 px, of a flat model."""
    flat = np.array([[0.0, 0, 0], [0.3, 0, 0], [0, 0.4, 0]])
    assert mspd(pose(t=(0.1, 0, 5)), pose(), flat, NONE, K) == pytest.approx(10)
    assert mspd(pose(t=(0, 0.1, 5)), pose(), flat, NONE, K) == pytest.approx(8)


def test_mspd_takes_the_worst_vertex():
    """A step to 10 m: the vertex 1 m off the axis moves from 100 px to 50 px, that on the axis not at all."""
    points = np.array([[0.0, 0, 0], [1, 0, 0]])
    assert mspd(pose(t=(0, 0, 10)), pose(), points, NONE, K) == pytest.approx(50)


def test_behind_the_camera_there_is_no_projection():
    assert mspd(pose(t=(0, 0, -5)), pose(), CUBE, NONE, K) == np.inf
    assert mspd(pose(), pose(t=(0, 0, -5)), CUBE, NONE, K) == np.inf
    assert mspd(pose(t=(0, 0, 0.1)), pose(), CUBE, NONE, K) == np.inf


def ring(count=200, radius=0.5):
    angles = np.arange(count) * 2 * np.pi / count
    circle = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    return np.concatenate([np.insert(circle, 2, z, axis=1) for z in (-1, 1)])


def test_a_cylinder_may_turn_as_it_likes():
    """Half a step of the 315 turns is all that is left: radius 0.5 times its chord."""
    own = symmetry_motions(ROUND, X)
    assert len(own) == 315
    assert mssd(turn(37), turn(0), ring(), NONE) == pytest.approx(2 * 0.5 * np.sin(np.radians(37) / 2))
    assert mssd(turn(37), turn(0), ring(), own) <= 2 * 0.5 * np.sin(np.pi / 315 / 2) + 1e-12
    assert mssd(turn(360 / 315 * 7), turn(0), ring(), own) == pytest.approx(0, abs=1e-12)
    assert mspd(turn(37), turn(0), ring(), own, K) <= 500 * 0.5 * 2 * np.sin(np.pi / 315 / 2) / 4 + 1e-9
    tilted = turn(37) @ pose((np.sin(0.1), 0, 0, np.cos(0.1)), (0, 0, 0))
    assert mssd(tilted, turn(0), ring(), own) > 0.1


def test_an_axis_beside_the_origin():
    """About x = 100 mm, a half turn takes the origin to 200 mm."""
    own = symmetry_motions({"symmetries_continuous": [{"axis": [0, 0, 2], "offset": [100, 0, 0]}]}, X, step=np.pi / 4)
    assert len(own) == 4
    assert own[:, :3, 3] == pytest.approx(np.array([[0, 0, 0], [0.1, -0.1, 0], [0.2, 0, 0], [0.1, 0.1, 0]]), abs=1e-12)


def test_turns_and_a_flip_are_multiplied():
    flip = [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1]
    own = symmetry_motions({"symmetries_discrete": [flip], **ROUND}, X, step=np.pi / 8)
    assert len(own) == 16
    assert np.abs(own - np.eye(4)).max(axis=(1, 2)).min() == 0
    estimate = turn(45) @ from_rotation_translation(np.diag([1.0, -1, -1]), np.zeros(3))
    assert mssd(estimate, turn(0), CUBE, own) == pytest.approx(0, abs=1e-12)


def test_poses_are_broadcast():
    a = np.array([turn(0), turn(90), turn(0, (1, 0, 5))])[:, None]
    b = np.array([turn(0), turn(90)])[None]
    for measure in (lambda a, b: mssd(a, b, CUBE, NONE), lambda a, b: add(a, b, CUBE)):
        table = measure(a, b)
        assert table.shape == (3, 2)
        assert [table[i][j] for i, j in ((0, 0), (0, 1), (1, 0), (1, 1), (2, 0))] == pytest.approx(
            [0, 1, 1, 0, 1], abs=1e-12
        )
        assert table[2, 1] == measure(a[2, 0], b[0, 1])
    assert mspd(a, b, CUBE, NONE, K).shape == add_s(a, b, CUBE).shape == (3, 2)
    assert add(np.zeros((0, 4, 4)), turn(0), CUBE).shape == (0,)


def test_many_points_in_parts_are_the_same():
    """More points and symmetries than are moved in one go: against the definition written out."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(3000, 3))
    own = symmetry_motions(ROUND, X)
    a, b = turn(30), pose((0.1, 0, 0, 1), (0.1, 0, 5))
    assert len(points) * len(own) > AT_ONCE
    moved = points @ a[:3, :3].T + a[:3, 3]
    there = [points @ (b @ s)[:3, :3].T + (b @ s)[:3, 3] for s in own]
    assert mssd(a, b, points, own) == pytest.approx(min(np.linalg.norm(moved - other, axis=1).max() for other in there))
    small = points / 10
    pixels = [(small @ T[:3, :3].T + T[:3, 3]) @ K.T for T in (a, *(b @ own))]
    pixels = [p[:, :2] / p[:, 2:] for p in pixels]
    assert mspd(a, b, small, own, K) == pytest.approx(
        min(np.linalg.norm(pixels[0] - p, axis=1).max() for p in pixels[1:])
    )
    nearest = np.array([np.linalg.norm(moved - point, axis=1).min() for point in there[0]])
    assert add_s(a, b, points) == pytest.approx(nearest.mean())


@settings(max_examples=40, deadline=None)
@given(poses, st.sampled_from(range(4)))
def test_zero_up_to_symmetry(truth, quarters):
    group = np.array([turn(90 * i, (0, 0, 0)) for i in range(4)])
    same = truth @ group[quarters]
    assert mssd(same, truth, CUBE, group) == pytest.approx(0, abs=1e-9)
    assert mspd(same, truth, CUBE, group, K) == pytest.approx(0, abs=1e-6)
    assert add_s(same, truth, CUBE) == pytest.approx(0, abs=1e-9)
    assert (float(add(same, truth, CUBE)) < 1e-9) == (quarters == 0)


@settings(max_examples=40, deadline=None)
@given(poses, poses)
def test_not_zero_where_poses_differ(a, b):
    group = np.array([turn(90 * i, (0, 0, 0)) for i in range(4)])
    apart = min(np.abs(a - b @ s).max() for s in group)
    error = float(mssd(a, b, CUBE, group))
    assert error <= 4 * apart + 1e-9
    assert error >= apart / 2 - 1e-9


@settings(max_examples=40, deadline=None)
@given(poses, poses, poses)
def test_a_common_motion_changes_no_distance_in_space(a, b, motion):
    group = np.array([turn(90 * i, (0, 0, 0)) for i in range(4)])
    assert mssd(motion @ a, motion @ b, CUBE, group) == pytest.approx(mssd(a, b, CUBE, group), abs=1e-9)
    assert add(motion @ a, motion @ b, CUBE) == pytest.approx(add(a, b, CUBE), abs=1e-9)
    assert add_s(motion @ a, motion @ b, CUBE) == pytest.approx(add_s(a, b, CUBE), abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(poses, poses)
def test_which_error_is_the_smaller(a, b):
    group = np.array([turn(90 * i, (0, 0, 0)) for i in range(4)])
    assert add_s(a, b, CUBE) <= add(a, b, CUBE) + 1e-9
    assert add(a, b, CUBE) <= mssd(a, b, CUBE, NONE) + 1e-9
    assert mssd(a, b, CUBE, group) <= mssd(a, b, CUBE, NONE)
    assert mspd(a, b, CUBE, group, K) <= mspd(a, b, CUBE, NONE, K)


def test_wrong_shapes():
    with pytest.raises(ValueError, match=r"\(N >= 1, 3\)"):
        add(turn(0), turn(0), np.zeros((0, 3)))
    with pytest.raises(ValueError, match=r"\(\.\.\., 4, 4\)"):
        mssd(np.eye(3), turn(0), CUBE, NONE)
