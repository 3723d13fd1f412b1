"""Junctions from drawn pixels: every kind at many rotations, with its place, its arms and its angle."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import sectors

from sensing.detectors.junctions import TYPES, JunctionDetector, kind

KINDS = {
    "l_junction": ([0, 100], [200, 90]),
    "y_junction": ([0, 115, 235], [200, 140, 80]),
    "arrow_junction": ([0, 50, 105], [150, 200, 80]),
    "t_junction": ([0, 80, 180], [140, 90, 200]),
    "multi_junction": ([0, 70, 150, 235], [200, 150, 90, 40]),
}
ROTATIONS = np.arange(7.0, 360.0, 30.0)


def apart(a, b) -> float:
    return float(abs(np.angle(np.exp(1j * (a - b)))))


def nearest(found, place):
    return min(found, key=lambda a: np.hypot(a.uv[0] - place[0], a.uv[1] - place[1]))


@pytest.mark.parametrize("name", KINDS)
def test_each_kind_is_found_in_its_place_at_every_rotation(name):
    degrees, levels = KINDS[name]
    place, right, errors = (80.3, 79.6), 0, []
    for i, turn in enumerate(ROTATIONS):
        arms = np.radians(np.asarray(degrees) + turn)
        best = nearest(JunctionDetector().detect(sectors(arms, levels, place, seed=i)), place)
        errors.append(np.hypot(best.uv[0] - place[0], best.uv[1] - place[1]))
        right += best.type == name
    assert max(errors) < 1.0
    assert np.median(errors) < 0.3
    assert right >= len(ROTATIONS) - 1


@pytest.mark.parametrize("turn", ROTATIONS)
def test_the_arms_lie_along_the_edges(turn):
    arms = np.radians(np.array([0, 115, 235]) + turn)
    best = nearest(JunctionDetector().detect(sectors(arms, [200, 140, 80])), (80, 80))
    assert len(best.arms) == 3
    assert max(min(apart(a, b) for b in best.arms) for a in arms) < np.radians(4)
    assert list(best.arms) == sorted(best.arms)


def test_the_table_of_kinds():
    assert len(KINDS) > 3
    for name, (degrees, _) in KINDS.items():
        for turn in np.radians(np.arange(0.0, 360, 15)):
            arms = np.sort(np.mod(np.radians(degrees) + turn, 2 * np.pi))
            found = kind(arms)
            assert found is not None
            assert found[0] == name


def test_angles_turn_with_the_picture():
    at = {"l_junction": 50.0, "arrow_junction": 50.0, "t_junction": 80.0}
    for name, expected in at.items():
        for turn in np.arange(0.0, 360, 15):
            arms = np.sort(np.mod(np.radians(np.asarray(KINDS[name][0]) + turn), 2 * np.pi))
            found = kind(arms)
            assert found is not None
            assert apart(found[1], np.radians(expected + turn)) < 1e-6


def test_a_y_s_angle_is_the_arm_nearest_to_straight_down():
    found = kind(np.radians([85.0, 200.0, 320.0]))
    assert found is not None
    assert found == ("y_junction", pytest.approx(np.radians(85)))


@pytest.mark.parametrize("degrees", [[], [40], [10, 190], [10, 195]])
def test_no_junction_of_fewer_than_two_arms_or_of_a_straight_line(degrees):
    assert kind(np.radians(np.array(degrees, float))) is None


@pytest.mark.parametrize("level", [0, 77, 255])
def test_nothing_is_seen_in_a_constant_image(level):
    assert JunctionDetector().detect(np.full((120, 160, 3), level, np.uint8)) == []


def test_next_to_nothing_is_seen_in_sensor_noise_alone():
    noise = np.random.default_rng(0).normal(120, 3.5, (480, 640, 3))
    assert len(JunctionDetector().detect(np.clip(noise, 0, 255).astype(np.uint8))) <= 3


def test_a_tiny_image_is_no_error():
    for shape in ((1, 1, 3), (3, 5, 3), (20, 2, 3)):
        grain = np.random.default_rng(0).integers(0, 255, shape).astype(np.uint8)
        assert {a.type for a in JunctionDetector().detect(grain)} <= set(TYPES)


def test_an_edge_between_equally_bright_colours_is_seen():
    image = np.full((160, 160, 3), (120, 120, 120), np.uint8)
    image[50:, 60:] = (60, 123, 146)  # warmer; 0.114 B + 0.587 G + 0.299 R is 120 again
    grain = np.random.default_rng(0).normal(0, 2, image.shape)
    found = JunctionDetector().detect(np.clip(image + grain, 0, 255).astype(np.uint8))
    best = nearest(found, (59.5, 49.5))
    assert best.type == "l_junction"
    assert np.hypot(best.uv[0] - 59.5, best.uv[1] - 49.5) < 1.0
