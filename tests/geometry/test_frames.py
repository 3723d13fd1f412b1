import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from geometry.errors import GeometryError
from geometry.frames import (
    compose,
    from_rotation_translation,
    inverse,
    is_rigid,
    look_at,
    pose_error,
    quat_xyzw_from_rotation,
    rotate,
    rotation_angle,
    rotation_from_quat_xyzw,
    transform_points,
)

numbers = st.floats(-10, 10)
quats = arrays(float, 4, elements=numbers).filter(lambda q: np.linalg.norm(q) > 1e-3)
vectors = arrays(float, 3, elements=numbers)
poses = st.builds(lambda q, t: from_rotation_translation(rotation_from_quat_xyzw(q), t), quats, vectors)


def about_z(angle):
    return rotation_from_quat_xyzw([0, 0, np.sin(angle / 2), np.cos(angle / 2)])


@settings(deadline=None)
@given(poses)
def test_inverse_after_pose_is_identity(pose):
    assert np.allclose(inverse(pose) @ pose, np.eye(4), atol=1e-9)
    assert is_rigid(pose)


@settings(deadline=None)
@given(poses, poses, vectors)
def test_composition_is_one_after_the_other(a_from_b, b_from_c, point):
    along = transform_points(a_from_b, transform_points(b_from_c, point[None]))
    assert np.allclose(transform_points(compose(a_from_b, b_from_c), point[None]), along, atol=1e-8)


@settings(deadline=None)
@given(poses, vectors, vectors)
def test_directions_are_differences_of_points(pose, p, q):
    ends = transform_points(pose, np.stack([p, q]))
    assert np.allclose(rotate(pose, (q - p)[None])[0], ends[1] - ends[0], atol=1e-8)


@settings(deadline=None)
@given(quats)
def test_quaternion_round_trip_keeps_the_rotation(quat):
    R = rotation_from_quat_xyzw(quat)
    back = quat_xyzw_from_rotation(R)
    assert np.allclose(rotation_from_quat_xyzw(back), R, atol=1e-9)
    assert back[3] >= 0
    assert np.isclose(np.linalg.norm(back), 1)


def test_quaternion_order_is_x_y_z_w():
    assert np.allclose(rotation_from_quat_xyzw([0, 0, 1, 1]), [[0, -1, 0], [1, 0, 0], [0, 0, 1]])


@settings(deadline=None)
@given(st.floats(0, np.pi))
def test_rotation_angle_is_the_angle_turned(angle):
    assert np.isclose(rotation_angle(about_z(angle)), angle, atol=1e-7)


@pytest.mark.parametrize("angle", [1e-9, 1e-4, np.pi - 1e-6, np.pi])
def test_rotation_angle_is_exact_at_its_ends(angle):
    assert np.isclose(rotation_angle(about_z(angle)), angle, rtol=1e-6, atol=1e-12)


@settings(deadline=None)
@given(poses, st.integers(0, 3))
def test_symmetric_poses_are_one_pose(pose, quarter):
    turns = np.stack([from_rotation_translation(about_z(k * np.pi / 2), [0, 0, 0]) for k in range(4)])
    rotation, translation = pose_error(pose @ turns[quarter], pose, turns)
    assert rotation < 1e-6
    assert translation < 1e-9


@settings(deadline=None)
@given(poses, poses)
def test_pose_error_is_symmetric_and_zero_on_itself(a, b):
    assert np.allclose(pose_error(a, b), pose_error(b, a), atol=1e-8)
    assert np.allclose(pose_error(a, a), 0, atol=1e-7)


def test_pose_error_of_a_known_turn_and_move():
    a = from_rotation_translation(np.eye(3), [0, 0, 5])
    b = from_rotation_translation(about_z(0.3), [0, 3, 9])
    assert np.allclose(pose_error(a, b), (0.3, 5.0))
    assert [e.shape for e in pose_error(np.stack([a, b]), b)] == [(2,), (2,)]


def test_look_at_puts_the_target_ahead_and_the_sky_above():
    camera_from_world = look_at([3, 0, 1], [0, 0, 1])
    target, above, left = transform_points(camera_from_world, [[0, 0, 1], [0, 0, 2], [0, -1, 1]])
    assert np.allclose(target, [0, 0, 3])
    assert np.allclose(above, [0, -1, 3])  # y is down
    assert np.allclose(left, [-1, 0, 3])


@pytest.mark.parametrize(
    ("eye", "target"), [((0, 0, 1), (0, 0, 1)), ((0, 0, 1), (0, 0, 5)), ((0, 0, np.nan), (1, 0, 0))]
)
def test_look_at_nowhere_is_refused(eye, target):
    with pytest.raises(GeometryError, match="line of sight"):
        look_at(eye, target)


@pytest.mark.parametrize(
    "matrix",
    [np.eye(3), np.diag([1, 1, -1, 1]), np.diag([2, 1, 1, 1]), np.full((4, 4), np.nan), np.eye(4) + np.eye(4)[3:]],
)
def test_what_is_not_rigid(matrix):
    assert not is_rigid(matrix)


def test_wrong_shapes_and_zero_quaternions_are_named():
    with pytest.raises(GeometryError, match=r"points must have the shape \(..., N, 3\), not \(2, 2\)"):
        transform_points(np.eye(4), np.zeros((2, 2)))
    with pytest.raises(GeometryError, match="not zero"):
        rotation_from_quat_xyzw([0, 0, 0, 0])
