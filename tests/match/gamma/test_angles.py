"""Angles on the screen: wrapping, and the direction in which a line in space is seen.

The camera's own projection is the oracle.
"""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.camera import Camera
from plogic.match.gamma.grid import screen_angle, wrapped

CAMERA = Camera(100, 100, np.array([[80.0, 0.0, 50.0], [0.0, 80.0, 50.0], [0.0, 0.0, 1.0]]))
ANY = st.floats(-50.0, 50.0)
SMALL = st.floats(-1.0, 1.0)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(ANY, st.integers(-5, 5))
def test_wrapping_leaves_the_direction_and_forgets_whole_turns(angle, turns):
    got = float(wrapped(np.array(angle)))
    assert -np.pi - 1e-9 <= got <= np.pi + 1e-9
    assert np.allclose([np.cos(got), np.sin(got)], [np.cos(angle), np.sin(angle)], atol=1e-9)
    again = float(wrapped(np.array(angle + 2.0 * np.pi * turns)))
    assert np.allclose([np.cos(again), np.sin(again)], [np.cos(got), np.sin(got)], atol=1e-9)


def test_wrapping_keeps_what_is_no_number_and_what_is_empty():
    assert np.isnan(wrapped(np.array([np.nan]))).all()
    assert wrapped(np.zeros((0, 2))).shape == (0, 2)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.tuples(SMALL, SMALL, SMALL), st.tuples(SMALL, SMALL), st.floats(0.5, 5.0))
def test_a_direction_is_seen_where_a_point_a_little_along_it_is(direction, aside, depth):
    at, way = np.array([*aside, depth]), np.array(direction)
    step = CAMERA.project(at + 1e-6 * way) - CAMERA.project(at)
    if np.linalg.norm(step) < 1e-7:  # towards the camera, or no direction at all
        return
    expected = np.arctan2(step[1], step[0])
    assert abs(float(wrapped(screen_angle(way, at) - expected))) < 1e-2


def test_straight_ahead_a_direction_is_its_own_angle_clockwise():
    at = np.array([0.0, 0.0, 3.0])
    ways = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.5], [0.0, -1.0, -0.5]])
    assert np.allclose(screen_angle(ways, at), [0.0, np.pi / 2, np.pi, -np.pi / 2])


def test_what_lies_ahead_points_away_from_the_middle():
    assert np.isclose(screen_angle(np.array([0.0, 0.0, -1.0]), np.array([0.3, 0.3, 1.0])), np.pi / 4)
    assert np.isclose(screen_angle(np.array([0.0, 0.0, 1.0]), np.array([0.3, 0.3, 1.0])), -3 * np.pi / 4)
