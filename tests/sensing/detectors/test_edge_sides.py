"""Sides of edges: both are at the edge, face away from each other, and say their own colour whatever is beyond."""

from __future__ import annotations

from math import cos, pi, sin

import cv2
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.special import ndtr

from kb.clouds.words import COLOURS as OWN
from sensing.detectors.keypoint_detector import (
    BLOCK,
    BROAD,
    DEPTHS,
    GAIN,
    LEAST,
    MOST,
    NOISY,
    WIDTH,
    edge_points,
    edge_sides,
    fairly,
    noise,
)
from sensing.detectors.keypoints import DARK, ratios

SIZE = 64
RIM = 13
"""Pixels of the margin where what is beyond the border may be seen."""
ANGLES, SHIFTS, BLURS = st.floats(0.0, 2 * pi), st.floats(-5.0, 5.0), st.floats(0.5, 1.2)
COLOURS = st.tuples(*[st.integers(30, 225)] * 3)
GREY = np.array([0.114, 0.587, 0.299])
"""Of blue, green and red."""


def halves(angle, shift, blur, near, far):
    """Colour ``near`` on the side that ``angle`` points to, ``far`` on the other.

    Their edge ``shift`` pixels from the middle.
    """
    v, u = np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2
    share = ndtr((u * cos(angle) + v * sin(angle) - shift) / blur)[..., None]
    return np.rint(share * np.array(near, float) + (1 - share) * np.array(far, float)).astype(np.uint8)


def told(angle, found):
    """(N,) bool: inner sides that face along ``angle``; and those that face against it."""
    inner = ((found.uv > RIM) & (found.uv < SIZE - 1 - RIM)).all(axis=1)
    facing = np.cos(found.angle - angle)
    return inner & (facing > 0.9), inner & (facing < -0.9)


def contrast(one, other):
    return int(np.abs(np.subtract(one, other)).max())


def seen(near, far, blur):
    """(5,) by hand: at each depth the mean colour under a Gaussian, of a straight edge of even colours; contrast."""
    beyond = [ndtr(-depth / np.hypot(BROAD, blur)) for depth in DEPTHS]
    levels = [share * np.array(far, float) + (1 - share) * np.array(near, float) for share in beyond]
    other = beyond[0] * np.array(near, float) + (1 - beyond[0]) * np.array(far, float)
    return np.array(
        [*ratios(np.array(levels)).ravel(), 128 + GAIN * np.log((levels[0].mean() + DARK) / (other.mean() + DARK))]
    )


def texture(seed, height=75, width=90):
    """Smooth noise, another in each channel."""
    rng = np.random.default_rng(seed)
    rough = cv2.GaussianBlur(rng.normal(0, 1, (height, width, 3)), (0, 0), 2.5)
    return np.clip(128 + 50 * rough / rough.std(), 0, 255).astype(np.uint8)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(ANGLES, SHIFTS, BLURS, COLOURS, COLOURS, st.integers(3, 9))
def test_both_sides_are_at_the_edge_and_say_what_colour_they_are_of(angle, shift, blur, one, other, cell):
    assume(contrast(one, other) > 50)
    found = edge_sides(halves(angle, shift, blur, one, other), cell)
    ahead, behind = told(angle, found)
    assert ahead.sum() == behind.sum() >= (SIZE - 2 * RIM) // cell - 2
    middle = (SIZE - 1) / 2
    for side, way, near, far in ((ahead, angle, one, other), (behind, angle + pi, other, one)):
        assert np.abs((found.uv[side] - middle) @ [cos(angle), sin(angle)] - shift).max() < 0.2
        assert np.degrees(np.abs(np.angle(np.exp(1j * (found.angle[side] - way)))).max()) < 3.0
        assert np.abs(found.looks[side] - seen(near, far, blur)).max() <= 4


@settings(max_examples=40, deadline=None, derandomize=True)
@given(ANGLES, SHIFTS, BLURS, COLOURS, st.lists(COLOURS, min_size=2, max_size=2))
def test_what_is_beyond_changes_the_near_colours_by_a_few_bytes_and_those_farther_in_not_at_all(
    angle, shift, blur, own, others
):
    assume(all(contrast(own, other) > 50 for other in others))
    colours = []
    for other in others:
        found = edge_sides(halves(angle, shift, blur, own, other), 5)
        side = found.looks[told(angle, found)[0], :OWN].astype(int)
        assert len(side) > 4
        colours.append(np.median(side, axis=0))
        assert np.abs(side[:, 2:] - ratios(np.array(own, float))).max() <= 1
    assert np.abs(colours[0] - colours[1])[:2].max() <= 30  # of strong contrasts: the blurs let up to a tenth through
    assert np.abs(colours[0] - colours[1])[2:].max() <= 1


@settings(max_examples=40, deadline=None, derandomize=True)
@given(ANGLES, SHIFTS, BLURS, COLOURS, st.integers(35, 90), st.booleans())
def test_colours_of_one_brightness_have_an_edge_between_them(angle, shift, blur, one, more, blue):
    """Red or blue is added, and so much green taken away that their grey stays."""
    rise, fall = (0 if blue else 2), more * (GREY[0] if blue else GREY[2]) / GREY[1]
    other = np.array(one, float)
    other[rise] += more
    other[1] -= fall
    assume(other.min() >= 0)
    assume(other.max() <= 255)
    image = halves(angle, shift, blur, one, other)
    grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    assert len(edge_points(grey, 5, 10_000).uv) == 0
    found = edge_sides(image, 5)
    ahead, behind = told(angle, found)
    assert ahead.sum() == behind.sum() > 4
    assert np.abs((found.uv[ahead] - (SIZE - 1) / 2) @ [cos(angle), sin(angle)] - shift).max() < 0.3


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(2, 9))
def test_sides_come_in_pairs_that_face_away_from_each_other_the_strongest_of_each_block_before_its_others(seed, cell):
    found = edge_sides(texture(seed), cell)
    assert len(found) > 20
    assert len(found) % 2 == 0
    assert np.array_equal(found.uv[::2], found.uv[1::2])
    assert np.array_equal(found.rise[::2], found.rise[1::2])
    np.testing.assert_allclose(np.cos(found.angle[::2] - found.angle[1::2]), -1.0)
    assert ((found.angle >= 0) & (found.angle < 2 * pi)).all()
    blocks = found.uv // BLOCK
    for block in np.unique(blocks, axis=0):
        assert (np.diff(found.rise[(blocks == block).all(axis=1)]) <= 0).all()
    assert found.rise[0] == found.rise.max()
    assert (found.rise > LEAST).all()
    assert found.looks.shape == (len(found), WIDTH)
    assert found.looks.dtype == np.uint8


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(2, 9), st.integers(0, 40))
def test_they_are_at_the_points_of_edges_and_fewer_are_the_first_of_more(seed, cell, most):
    image = texture(seed)
    points = edge_points(image, cell, image.size, max(LEAST, NOISY * noise(image)))
    every, few = edge_sides(image, cell), edge_sides(image, cell, most)
    order = fairly(points.uv, BLOCK)[:MOST]
    assert np.array_equal(every.uv[::2], points.uv[order])
    np.testing.assert_allclose(np.exp(1j * every.angle[::2]), np.exp(1j * points.angle[order]), atol=1e-9)
    assert len(few) == 2 * min(most, len(points.uv))
    for name in ("uv", "angle", "rise", "looks"):
        assert np.array_equal(getattr(few, name), getattr(every, name)[: 2 * most])


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(3, 7), st.integers(11, 16))
def test_a_picture_turned_by_a_quarter_has_its_sides_turned(seed, cell, cells):
    """A square of whole cells, whose cells are turned too."""
    image = texture(seed, cell * cells, cell * cells)
    one, other = edge_sides(image, cell), edge_sides(np.ascontiguousarray(np.rot90(image, -1)), cell)
    place = np.column_stack([cell * cells - 1 - one.uv[:, 1], one.uv[:, 0]])  # clockwise: (u, v) goes to (h - 1 - v, u)
    far = np.linalg.norm(place[:, None] - other.uv[None], axis=2) + np.abs(
        np.exp(1j * (one.angle[:, None] + pi / 2 - other.angle[None])) - 1
    )
    twin = far.argmin(axis=1)
    same = far[np.arange(len(one)), twin] < 0.01
    assert len(one) > 20
    assert same.mean() > 0.95  # rounding decides between equals
    assert np.abs(one.looks[same].astype(int) - other.looks[twin[same]]).max() <= 1
    np.testing.assert_allclose(one.rise[same], other.rise[twin[same]], rtol=1e-3)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(ANGLES, SHIFTS, st.tuples(COLOURS, COLOURS), st.floats(0.7, 1.1))
def test_brightness_changes_colours_little(angle, shift, both, gain):
    assume(contrast(*both) > 50)
    image = halves(angle, shift, 0.8, *both)
    one, other = edge_sides(image, 5), edge_sides(np.clip(np.rint(image * gain), 0, 255).astype(np.uint8), 5)
    assert len(told(angle, one)) == 2
    for some, its in zip(told(angle, one), told(angle, other), strict=True):
        assert its.sum() > 4
        assert np.abs(np.median(one.looks[some], axis=0) - np.median(other.looks[its], axis=0)).max() <= 8


@pytest.mark.parametrize(("bright", "dark"), [(200, 60), (90, 60), (225, 30), (255, 0)])
def test_the_contrast_of_two_levels_is_the_logarithm_of_their_ratio(bright, dark):
    """Two and a half pixels from a sharp step a Gaussian of 1.5 pixels lets 4.8 % of the other level through."""
    image = halves(0.0, 0.0, 1e-3, (bright,) * 3, (dark,) * 3)
    ours, theirs = 0.952 * bright + 0.048 * dark, 0.952 * dark + 0.048 * bright
    apart = 40.0 * np.log((ours + 16.0) / (theirs + 16.0))
    found = edge_sides(image, 5)
    for side, expected in zip(told(0.0, found), (128 + apart, 128 - apart), strict=True):
        assert side.sum() > 4
        assert np.abs(found.looks[side, OWN] - expected).max() <= 2


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(2, 9))
def test_the_contrasts_of_both_sides_of_an_edge_are_opposite(seed, cell):
    contrast = edge_sides(texture(seed), cell).looks[:, OWN].astype(int)
    assert np.ptp(contrast) > 20
    assert np.abs(contrast[::2] + contrast[1::2] - 256).max() <= 1  # each is rounded


@pytest.mark.parametrize("shape", [(1, 1, 3), (5, 50, 3), (50, 5, 3), (11, 11, 3), (50, 60, 3)])
def test_a_constant_picture_has_none(shape):
    found = edge_sides(np.full(shape, (20, 90, 200), np.uint8), 5)
    assert len(found) == 0
    assert found.uv.shape == (0, 2)
    assert found.looks.shape == (0, WIDTH)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(0, 2), st.integers(2, 9))
def test_points_of_a_picture_that_rises_in_one_channel_are_those_of_that_channel(seed, channel, cell):
    grey = texture(seed)[..., 0]
    image = np.full((*grey.shape, 3), 77, np.uint8)
    image[..., channel] = grey
    one, other = edge_points(grey, cell, 10_000), edge_points(image, cell, 10_000)
    assert len(one.uv) > 20
    for name in ("uv", "angle", "rise"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), atol=1e-5)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.floats(2.0, 12.0))
def test_noise_is_measured_and_makes_hardly_an_edge(seed, sigma):
    rng = np.random.default_rng(seed)
    image = np.clip(np.rint(120.0 + rng.normal(0.0, sigma, (120, 160, 3))), 0, 255).astype(np.uint8)
    assert 0.6 * sigma < noise(image) < 1.1 * sigma
    cells = (120 // 5) * (160 // 5)
    assert len(edge_sides(image, 5)) <= 0.12 * 2 * cells


def test_a_strong_texture_does_not_drown_a_plain_block():
    image = np.full((128, 256, 3), 110, np.uint8)
    image[:, :200] = np.random.default_rng(0).integers(0, 256, (128, 200, 3))
    image[40:90, 215:245] = 130
    found = edge_sides(image, 5, 200)
    assert (edge_points(image, 5, 200).uv[:, 0] < 205).all()  # of the strongest none is there
    assert (found.uv[:, 0] > 205).sum() >= 16
