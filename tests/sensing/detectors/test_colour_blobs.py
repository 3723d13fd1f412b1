"""Blobs of colour: their hue, middle and size, whatever the light's gain."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from sensing.detectors.colour_blobs import HUES, TYPES, ColourBlobDetector

COLOURS = {
    "red": (170, 30, 35), "orange": (185, 100, 25), "yellow": (180, 165, 30), "green": (40, 150, 60),
    "cyan": (30, 170, 175), "blue": (35, 60, 180), "magenta": (170, 40, 150),
}  # fmt: skip


def discs(placed, gain=1.0, size=(240, 160), noise=2.0, wall=(130, 128, 125)):
    """Discs (colour as R, G, B, place, radius) on a grey wall, drawn four times finer and averaged down."""
    fine = np.full((size[1] * 4, size[0] * 4, 3), wall, np.float32)
    for colour, (u, v), radius in placed:
        middle = (round((u * 4 + 1.5) * 16), round((v * 4 + 1.5) * 16))
        cv2.circle(fine, middle, round(radius * 64), [float(c) for c in colour], -1, cv2.LINE_8, 4)
    picture = cv2.resize(fine, size, interpolation=cv2.INTER_AREA)[:, :, ::-1] * gain
    return np.clip(np.rint(picture + np.random.default_rng(0).normal(0, noise, picture.shape)), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("gain", [0.7, 1.0, 1.3])
@pytest.mark.parametrize("name", list(COLOURS))
def test_a_disc_of_each_colour_at_any_gain(name, gain):
    (found,) = ColourBlobDetector().detect(discs([(COLOURS[name], (101.3, 70.8), 14.0)], gain))
    assert found.type == f"blob_{name}"
    assert found.uv == pytest.approx((101.3, 70.8), abs=0.4)
    assert found.scale == pytest.approx(28, rel=0.1)
    assert 0.4 < found.score <= 1


def test_two_discs_of_one_colour_are_two_and_neighbours_of_other_colours_stay_apart():
    placed = [(COLOURS["red"], (50, 80), 12), (COLOURS["red"], (120, 80), 12), (COLOURS["blue"], (180, 80), 15)]
    assert sorted(a.type for a in ColourBlobDetector().detect(discs(placed))) == ["blob_blue", "blob_red", "blob_red"]


def test_grey_small_and_cut_off_regions_are_none():
    placed = [((90, 85, 88), (60, 80), 15), (COLOURS["red"], (120, 80), 2), (COLOURS["blue"], (239, 80), 15)]
    assert ColourBlobDetector().detect(discs(placed)) == []


def test_a_shift_by_whole_pixels_shifts_the_blobs():
    image = discs([(COLOURS["green"], (101.3, 70.8), 14.0)])
    (a,), (b,) = ColourBlobDetector().detect(image), ColourBlobDetector().detect(image[5:, 9:].copy())
    assert b.uv == pytest.approx((a.uv[0] - 9, a.uv[1] - 5), abs=1e-6)
    assert b.scale == a.scale


@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (8, 8), (120, 160)])
def test_constant_and_tiny_images_have_none(shape):
    assert ColourBlobDetector().detect(np.full((*shape, 3), (20, 20, 200), np.uint8)) == []


def test_the_hues_are_the_circle():
    bounds = list(HUES.values())
    assert all(a[1] == b[0] for a, b in zip(bounds, bounds[1:] + bounds[:1], strict=True))
    assert len(TYPES) == len(HUES) == 7
