"""Fields of view and focal lengths: by hand, there and back, and as a camera sees."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.camera import centred_camera
from geometry.field_of_view import focal_across, focal_diagonal, focal_equivalent, fov_across

SIDES, ANGLES = st.integers(1, 65536), st.floats(0.1, 179.0)


def test_by_hand():
    assert focal_across(2000, 90.0) == pytest.approx(1000.0)
    assert focal_diagonal((4000, 3000), 90.0) == pytest.approx(2500.0)
    assert focal_equivalent((3600, 2400), 50.0) == pytest.approx(5000.0)


@given(SIDES, ANGLES)
def test_there_and_back(side, fov):
    assert fov_across(side, focal_across(side, fov)) == pytest.approx(fov, rel=1e-9)


@given(SIDES, SIDES, ANGLES)
def test_the_outer_edges_of_a_picture_are_seen_under_the_angle(width, height, fov):
    for f, corner in ((focal_across(width, fov), False), (focal_diagonal((width, height), fov), True)):
        middle = (height - 1) / 2
        ends = [(-0.5, -0.5 if corner else middle), (width - 0.5, height - 0.5 if corner else middle)]
        one, other = centred_camera((width, height), f).rays(ends)
        angle = 2 * np.arctan2(np.linalg.norm(one - other), np.linalg.norm(one + other))
        assert np.degrees(angle) == pytest.approx(fov, rel=1e-6)


@given(SIDES, SIDES, st.floats(4.0, 4000.0))
def test_an_equivalent_sees_from_corner_to_corner_what_it_sees_on_film(width, height, mm):
    film = fov_across(np.hypot(36.0, 24.0), mm)
    assert focal_diagonal((width, height), film) == pytest.approx(focal_equivalent((width, height), mm), rel=1e-9)
