"""Patches from drawn pixels: dark quadrilaterals at known places."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from drawn import quads

from sensing.detectors.junctions import JunctionDetector
from sensing.detectors.patches import PatchDetector, find_patches

ANGLES = np.radians([0.0, 17.0, 40.0, 63.0, 85.0])


def rectangle(centre, width, height, angle=0.0, skew=0.0):
    corners = np.array(
        [[-width / 2, -height / 2], [width / 2, -height / 2], [width / 2, height / 2], [-width / 2, height / 2]]
    )
    corners[:, 1] += skew * corners[:, 0]
    cos, sin = np.cos(angle), np.sin(angle)
    return corners @ np.array([[cos, sin], [-sin, cos]]) + centre


def grid(width, height, angle, skew=0.0):
    """Nine windows, well apart, at broken places."""
    apart = 1.9 * max(width, height)
    centres = [(50.3 + apart * i, 40.7 + apart * j) for i in range(3) for j in range(3)]
    return np.array([rectangle(c, width, height, angle, skew) for c in centres])


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("size", [(6, 8), (7, 9), (12, 16), (20, 14)])
def test_every_window_is_found_in_its_place_and_no_other(size, angle):
    corners = grid(*size, angle)
    found = PatchDetector().detect(quads(corners))
    assert len(found) == 9
    uv = np.array([a.uv for a in found])
    errors = np.array([np.linalg.norm(uv - c, axis=1).min() for c in corners.mean(axis=1)])
    assert np.median(errors) < 0.15
    assert errors.max() < 0.5


@pytest.mark.parametrize("skew", [-0.6, 0.3, 0.8])
def test_windows_seen_from_the_side_are_found(skew):
    corners = np.array([rectangle((60 + 25 * i, 80), 11, 18, 0, skew) for i in range(3)])
    uv = sorted(a.uv for a in PatchDetector().detect(quads(corners)))
    assert np.array(uv) == pytest.approx(corners.mean(axis=1), abs=0.3)


def test_the_place_is_where_the_diagonals_meet_and_not_the_centroid():
    trapezium = np.array([[60.0, 40], [120, 55], [120, 85], [60, 100]])
    found = find_patches(quads([trapezium], size=(400, 300))[:, :, 0])
    t = 60 / (60 + 30)  # the sides are 60 and 30 long
    assert found.centre[0] == pytest.approx([60 + 60 * t, 70], abs=0.3)
    assert abs(found.centre[0, 0] - trapezium[:, 0].mean()) > 5


def test_scale_and_angle_are_those_of_the_rectangle():
    (found,) = PatchDetector().detect(quads([rectangle((100, 80), 30, 20, 0.3)]))
    assert found.scale == pytest.approx(np.sqrt(600) * 2 / np.sqrt(np.pi), rel=0.03)
    assert found.angle is not None
    assert abs(np.angle(np.exp(4j * (found.angle - 0.3)))) / 4 < 0.03


def test_brighter_light_or_another_wall_moves_nothing():
    corners = grid(9, 12, 0.2)
    first, second = (PatchDetector().detect(quads(corners, *light)) for light in ((190, 45), (110, 30)))
    assert len(first) == 9
    here, there = (np.array([a.uv for a in found]) for found in (first, second))
    assert np.linalg.norm(here[:, None] - there[None], axis=2).min(axis=1).max() < 0.3


def test_bright_spots_discs_and_slopes_are_no_patches():
    slope = np.repeat(np.linspace(30, 220, 200)[None, :, None], 160, axis=0).repeat(3, axis=2).astype(np.uint8)
    assert PatchDetector().detect(slope) == []
    assert PatchDetector().detect(quads([rectangle((100, 80), 14, 14)], wall=60, dark=200)) == []


@pytest.mark.parametrize("level", [0, 128, 255])
def test_nothing_is_seen_in_a_constant_image(level):
    assert PatchDetector().detect(np.full((100, 100, 3), level, np.uint8)) == []


def test_a_tiny_image_is_no_error():
    for shape in ((1, 1, 3), (3, 5, 3), (20, 2, 3)):
        grain = np.random.default_rng(0).integers(0, 255, shape).astype(np.uint8)
        assert len(PatchDetector().detect(grain)) <= 1


def test_windows_corners_are_no_junctions():
    image = quads(grid(9, 12, 0.1))
    assert len(PatchDetector().detect(image)) == 9
    assert len(JunctionDetector().detect(image)) <= 1


@pytest.mark.parametrize("seed", [501, 982, 1125])
@pytest.mark.filterwarnings("error")
def test_sides_that_turn_out_to_be_parallel_make_no_patch(seed):
    random, image = np.random.default_rng(seed), np.zeros((100, 140), np.uint8)
    for _ in range(30):
        triangle = random.integers(0, [140, 100]) + random.integers(-40, 40, (3, 2))
        cv2.fillConvexPoly(image, triangle.astype(np.int32), int(random.integers(0, 256)))
    assert np.isfinite(find_patches(image).corners).all()
