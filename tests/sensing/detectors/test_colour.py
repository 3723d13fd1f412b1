"""Colours about keypoints: ratios of channels at five cells of a keypoint's own frame."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sensing.detectors.keypoint_detector import described
from sensing.detectors.keypoints import CELLS, DARK, GAIN, REACH, WIDTH, colours, is_grey
from sensing.detectors.regions import regions

RED, GREEN, BLUE, WHITE = (30, 30, 200), (40, 160, 30), (180, 60, 20), (220, 220, 220)


def plain(colour, side=96):
    return np.full((side, side, 3), colour, np.uint8)


def painted(seed, side=160):
    """Squares of random colours, 20 pixels wide."""
    cells = np.random.default_rng(seed).integers(20, 230, (side // 20, side // 20, 3), np.uint8)
    return np.repeat(np.repeat(cells, 20, axis=0), 20, axis=1)


def one(image, u, v, angle=0.0, scale=8.0):
    return colours(image, np.array([[u, v]]), np.array([angle]), np.array([scale]))[0].astype(int)


@pytest.mark.parametrize("colour", [RED, GREEN, BLUE, WHITE])
@pytest.mark.parametrize("scale", [2.0, 8.0, 40.0, 400.0])
def test_of_one_colour_every_cell_says_that_colour(colour, scale):
    blue, green, red = (np.log(value + DARK) for value in colour)
    expected = np.clip(np.rint(128 + GAIN * np.array([red - green, blue - green])), 0, 255)
    assert one(plain(colour), 47.5, 47.5, 0.3, scale).reshape(-1, 2).tolist() == [expected.tolist()] * len(CELLS)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.floats(0.0, 6.2), st.floats(4.0, 16.0))
def test_they_turn_with_the_image(seed, angle, scale):
    """An image turned by a right angle, and its keypoints with it.

    Nearly the same bytes (smaller pictures are of every other pixel).
    """
    image = painted(seed)
    u, v = 71.0, 88.0
    turned = np.ascontiguousarray(np.rot90(image, -1))  # clockwise: (u, v) goes to (h - 1 - v, u)
    apart = one(image, u, v, angle, scale) - one(turned, len(image) - 1 - v, u, angle + np.pi / 2, scale)
    assert np.linalg.norm(apart) < 15.0  # a tenth of what two pictures of one thing differ in SIFT


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.floats(0.7, 1.1))
def test_brightness_changes_them_little(seed, gain):
    image = painted(seed)
    darker = np.clip(np.rint(image * gain), 0, 255).astype(np.uint8)
    apart = one(image, 71.0, 88.0) - one(darker, 71.0, 88.0)
    assert np.linalg.norm(apart) < 60.0  # a third of what two pictures of one thing differ in SIFT


def test_each_cell_is_where_its_corner_is():
    """Turned by its angle, a keypoint sees a red square ahead on its left in the cell that says so, and there alone."""
    assert len(CELLS) == 5
    image = plain(WHITE, 200)
    scale, angle = 10.0, 0.5
    for number, (along, across) in enumerate(CELLS):
        u = 100 + REACH * scale * (np.cos(angle) * along - np.sin(angle) * across)
        v = 100 + REACH * scale * (np.sin(angle) * along + np.cos(angle) * across)
        spot = image.copy()
        spot[round(v) - 4 : round(v) + 5, round(u) - 4 : round(u) + 5] = RED
        reds = one(spot, 100.0, 100.0, angle, scale)[0::2]
        assert reds.argmax() == number
        assert reds[number] > 128 + GAIN / 4


def test_stickers_of_two_colours_are_not_alike():
    apart = one(plain(RED), 47.0, 47.0) - one(plain(GREEN), 47.0, 47.0)
    assert np.linalg.norm(apart) > 270.0


def test_at_and_beyond_the_border_there_are_colours_too():
    rng = np.random.default_rng(0)
    uv = np.array([[-0.5, -0.5], [159.5, 0.0], [80.0, 159.5]])
    found = colours(painted(1), uv, rng.uniform(0, 6, 3), np.full(3, 60.0))
    assert found.shape == (3, WIDTH)
    assert colours(painted(1), np.zeros((0, 2)), np.zeros(0), np.zeros(0)).shape == (0, WIDTH)


@pytest.mark.parametrize(
    ("image", "grey"),
    [
        (plain(WHITE), True),
        (plain(RED), False),
        (plain(WHITE)[..., 0], True),
        (painted(2), False),
        (np.repeat(painted(2)[..., :1], 3, axis=2), True),
    ],
    ids=["white", "red", "one channel", "painted", "grey in three channels"],
)
def test_grey_is_what_has_three_equal_channels(image, grey):
    assert is_grey(image) is grey


def test_descriptors_have_colours_where_the_image_has_them():
    """The bytes before them are SIFT's own, and ORB's stay as they are."""
    coloured, grey = described(painted(3)), described(np.ascontiguousarray(painted(3)[..., 0]))
    assert coloured.descriptors.shape == (len(coloured), 128 + WIDTH)
    assert grey.descriptors.shape == (len(grey), 128)
    assert described(painted(3), "orb").descriptors.shape[1] == 32
    local = len(coloured) - len(regions(painted(3)))
    expected = colours(painted(3), coloured.uv[:local], coloured.angle[:local], coloured.scale[:local])
    np.testing.assert_array_equal(coloured.descriptors[:local, 128:], expected)
