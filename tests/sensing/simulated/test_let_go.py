"""Bodies let go by physics: concave ones by their parts, gently however they reach into each other."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sensing.simulated.physics import has_physics
from sensing.simulated.settling import Loose, filled, let_go

physics = pytest.mark.skipif(not has_physics(), reason="pybullet is not installed")
FEW = settings(max_examples=10, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


def box(*sides):
    return np.array(list(product(*sides)), float)


def at(x, y, z):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


CUBE = (box((-0.05, 0.05), (-0.05, 0.05), (0, 0.1)),)
ANGLE = box((0, 0.1), (0, 0.1), (0, 0.02)), box((0, 0.02), (0, 0.1), (0.02, 0.2))
"""An L: a foot and a wall."""


def test_the_mass_of_parts_is_theirs_together():
    mass = filled(ANGLE)
    volumes = np.array([0.1 * 0.1 * 0.02, 0.02 * 0.1 * 0.18])
    assert mass.volume == pytest.approx(volumes.sum())
    np.testing.assert_allclose(mass.middle, volumes @ [[0.05, 0.05, 0.01], [0.01, 0.05, 0.11]] / volumes.sum())
    assert filled([np.zeros((4, 3)), CUBE[0][:4] * [1, 1, 0]]) is None


@physics
def test_nothing_becomes_of_nothing():
    assert let_go([]) == {}


@physics
def test_a_thing_stands_in_the_corner_of_a_concave_one():
    """The hull of the L would throw it out."""
    fates = let_go([Loose("l", ANGLE, at(0, 0, 0)), Loose("c", CUBE, at(0.071, 0.05, 0.02))])
    for name, pose in (("l", at(0, 0, 0)), ("c", at(0.071, 0.05, 0.02))):
        np.testing.assert_allclose(fates[name].after, pose, atol=0.001)
        assert fates[name].still


@physics
@FEW
@given(st.floats(-0.09, 0.09), st.floats(-0.09, 0.09), st.floats(0.0, 0.09))
def test_however_deep_two_reach_into_each_other_they_are_moved_apart_and_rest(x, y, z):
    """They do not fly: neither leaves the other by more than its own size."""
    fates = let_go([Loose("a", CUBE, at(0, 0, 0)), Loose("b", CUBE, at(x, y, z))])
    a, b = ((fates[name].after @ [0, 0, 0.05, 1])[:3] for name in "ab")
    assert fates["a"].still
    assert fates["b"].still
    assert np.abs(b - a).max() >= 0.099
    assert np.abs(b - a).max() < 0.2
    assert min(a[2], b[2]) > 0.049


@physics
@FEW
@given(st.floats(0.1, 100.0))
def test_size_changes_nothing(size):
    """Small things and large ones stand as firmly, but large ones fall no faster."""
    fates = let_go(
        [Loose("a", (CUBE[0] * size,), at(0, 0, 0)), Loose("b", (CUBE[0] * size,), at(0.02 * size, 0, 0.1 * size))]
    )
    for name, x, z in (("a", 0.0, 0.0), ("b", 0.02, 0.1)):
        np.testing.assert_allclose(fates[name].after[:3] / [1, 1, 1, size], at(x, 0, z)[:3], atol=0.004)
