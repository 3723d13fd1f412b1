"""Lobes: cone and range, both bounds inside; granularity (§2.7)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kb.clouds.lobes import (
    Feature,
    FeatureAppearance,
    Lobe,
    feature_in_lobe,
    in_lobe,
    lobe_table,
)

UP = np.array([0.0, 0, 1])


def a_feature(*lobes: Lobe, at=(0, 0, 0), rotation=None) -> Feature:
    looks = tuple(FeatureAppearance("patch", lobe) for lobe in lobes)
    return Feature("f", "patch", np.array(at), np.eye(3) if rotation is None else rotation, looks)


@pytest.mark.parametrize(
    ("viewpoint", "inside"),
    [
        ((0, 0, 1), True),
        ((0, 0, 2), True),  # r_max itself
        ((0, 0, 0.5), True),  # r_min itself
        ((0, 0, 2.001), False),
        ((0, 0, 0.499), False),
        ((1, 0, 1), True),  # 45 degrees, the half-angle itself
        ((1.01, 0, 1), False),
        ((0, 0, -1), False),
        ((0, 0, 0), False),  # the feature itself
    ],
)
def test_in_lobe(viewpoint, inside):
    table = lobe_table([a_feature(Lobe(UP, np.pi / 4, 0.5, 2.0))])
    assert in_lobe(table, viewpoint, 1.0)[0, 0] == inside


def test_a_longer_lens_sees_from_farther_and_none_asks_for_the_direction_alone():
    table = lobe_table([a_feature(Lobe(UP, 0.5, 0.5, 2.0))])
    assert in_lobe(table, [(0, 0, 3)], 2.0)[0, 0]
    assert not in_lobe(table, [(0, 0, 0.9)], 2.0)[0, 0]
    assert in_lobe(table, [(0, 0, 99)])[0, 0]


def test_the_axis_turns_with_the_feature_and_stands_at_it():
    quarter = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
    table = lobe_table([a_feature(Lobe(UP, 0.5, 0.5, 2.0), at=(5, 0, 0), rotation=quarter)])
    assert in_lobe(table, [(6, 0, 0), (5, 0, 1), (4, 0, 0)], 1.0)[:, 0].tolist() == [True, False, False]


def test_a_feature_is_in_a_lobe_if_in_one_of_its_lobes():
    two = a_feature(Lobe(UP, 0.5, 0.5, 2.0), Lobe(-UP, 0.5, 0.5, 2.0))
    table = lobe_table([two, a_feature(Lobe(UP, 0.5, 0.5, 2.0)), a_feature()])
    assert feature_in_lobe(table, [(0, 0, 1), (0, 0, -1), (1, 0, 0)], 1.0).tolist() == [
        [True, True, False],
        [True, False, False],
        [False, False, False],
    ]


@given(st.floats(0.1, 3.1), st.integers(0, 1000))
@settings(max_examples=50, deadline=None)
def test_in_lobe_is_the_definition(half_angle, seed):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    views = rng.normal(size=(50, 3)) * 3
    table = lobe_table([a_feature(Lobe(axis, half_angle, 1.0, 4.0))])
    distance = np.linalg.norm(views, axis=1)
    angle = np.arccos(np.clip(views @ axis / distance, -1, 1))
    wanted = (distance >= 1) & (distance <= 4) & (angle <= half_angle)
    assert np.array_equal(in_lobe(table, views, 1.0)[:, 0], wanted)
