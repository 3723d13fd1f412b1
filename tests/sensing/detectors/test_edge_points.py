"""Points along edges: on a blurred step to about a tenth of a pixel, turned from dark to bright, one a cell.

And by a loop over all pixels.
"""

from __future__ import annotations

from math import atan2, cos, floor, pi, sin

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtr

from sensing.detectors.keypoint_detector import BORDER, LEAST, SMOOTH, edge_points

SIZE = 48
ALL = 10_000
ANGLES, SHIFTS = st.floats(0.0, 2 * pi), st.floats(-3.0, 3.0)
TEXTURES = st.tuples(st.integers(0, 9999), st.integers(6, 40), st.integers(6, 40))


def step(angle, shift, blur, low=40.0, high=200.0):
    """A step from dark to bright along ``angle``, ``shift`` pixels from the middle, blurred by a Gaussian."""
    v, u = np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2
    return np.rint(low + (high - low) * ndtr((u * cos(angle) + v * sin(angle) - shift) / blur)).astype(np.uint8)


def inner(uv):
    """(N,) where smoothing does not reach beyond the picture's margin."""
    return ((uv > 5) & (uv < SIZE - 6)).all(axis=1)


def texture(seed, height, width, grain=1.2):
    rng = np.random.default_rng(seed)
    rough = cv2.GaussianBlur(rng.normal(0, 1, (height, width)), (0, 0), grain)
    return np.clip(128 + 60 * rough / max(rough.std(), 1e-9), 0, 255).astype(np.uint8)


def by_loop(grey, cell):
    """(pixel, place, angle, rise) of the strongest ridge in each cell, the strongest first, pixel after pixel."""
    smooth = cv2.GaussianBlur(grey.astype(np.float32), (0, 0), SMOOTH)
    gx, gy = (cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3) / 8 for order in ((1, 0), (0, 1)))
    rise = np.hypot(gx, gy)

    def between(x, y):
        i, j = floor(x), floor(y)
        return sum(
            float(rise[j + dj, i + di]) * (x - i if di else 1 - x + i) * (y - j if dj else 1 - y + j)
            for di in (0, 1)
            for dj in (0, 1)
        )

    best = {}
    for y in range(BORDER, grey.shape[0] - BORDER):
        for x in range(BORDER, grey.shape[1] - BORDER):
            here = float(rise[y, x])
            if here <= LEAST:
                continue
            dx, dy = float(gx[y, x]) / here, float(gy[y, x]) / here
            ahead, behind = between(x + dx, y + dy), between(x - dx, y - dy)
            if here < ahead or here <= behind:
                continue
            off = min(max(0.5 * (behind - ahead) / min(ahead + behind - 2 * here, -1e-6), -0.5), 0.5)
            place = (y // cell, x // cell)
            if place not in best or best[place][3] < here:
                best[place] = ((x, y), (x + off * dx, y + off * dy), atan2(dy, dx), here)
    return sorted(best.values(), key=lambda one: (-one[3], one[0][1], one[0][0]))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(ANGLES, SHIFTS, st.floats(0.5, 1.5), st.integers(3, 9))
def test_points_of_a_blurred_step_lie_on_it_and_are_turned_from_dark_to_bright(angle, shift, blur, cell):
    found = edge_points(step(angle, shift, blur), cell, ALL)
    some = inner(found.uv)
    off = np.abs((found.uv - (SIZE - 1) / 2) @ [cos(angle), sin(angle)] - shift)[some]
    turned = np.abs(np.angle(np.exp(1j * (found.angle - angle))))[some]
    assert some.sum() >= (SIZE - 12) // cell - 1
    assert off.max() < 0.15
    assert np.degrees(turned.max()) < 2.0


def test_nine_points_of_ten_are_within_a_twentieth_of_a_pixel_or_so_and_nearly_all_within_a_tenth():
    rng, off = np.random.default_rng(1), []
    for _ in range(150):
        angle, shift = rng.uniform(0, 2 * pi), rng.uniform(-3, 3)
        found = edge_points(step(angle, shift, rng.uniform(0.5, 1.5)), 5, ALL)
        off += np.abs((found.uv - (SIZE - 1) / 2) @ [cos(angle), sin(angle)] - shift)[inner(found.uv)].tolist()
    assert np.quantile(off, 0.5) < 0.03
    assert np.quantile(off, 0.9) < 0.07
    assert np.quantile(off, 0.98) < 0.1


@settings(max_examples=25, deadline=None, derandomize=True)
@given(TEXTURES, st.integers(1, 9))
def test_points_are_those_of_a_loop_over_all_pixels(size, cell):
    grey = texture(*size)
    found, expected = edge_points(grey, cell, ALL), by_loop(grey, cell)
    assert len(found.uv) == len(found.angle) == len(found.rise) == len(expected)
    if expected:
        np.testing.assert_allclose(found.uv, [one[1] for one in expected], atol=1e-4)
        np.testing.assert_allclose(
            np.exp(1j * found.angle), np.exp(1j * np.array([one[2] for one in expected])), atol=1e-5
        )
        np.testing.assert_allclose(found.rise, [one[3] for one in expected], rtol=1e-6)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(TEXTURES, st.integers(1, 12), st.integers(0, 30))
def test_the_strongest_come_first_and_fewer_are_the_first_of_more(size, cell, most):
    grey = texture(*size)
    every, few = edge_points(grey, cell, ALL), edge_points(grey, cell, most)
    height, width = grey.shape
    assert len(every.uv) <= -(-height // cell) * -(-width // cell)
    assert (np.diff(every.rise) <= 0).all()
    assert (every.rise > LEAST).all()
    assert ((every.uv >= BORDER - 0.5) & (every.uv <= np.array([width, height]) - BORDER - 0.5)).all()
    assert len(few.uv) == min(most, len(every.uv))
    for name in ("uv", "angle", "rise"):
        assert np.array_equal(getattr(few, name), getattr(every, name)[:most])


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(2, 9), st.integers(0, 3), st.integers(0, 3))
def test_a_picture_shifted_by_whole_cells_has_its_points_shifted(seed, cell, right, down):
    patch = np.full((28, 28), 128, np.uint8)
    patch[4:24, 4:24] = texture(seed, 20, 20)
    before, after = np.full((2, 90, 90), 128, np.uint8)
    before[18:46, 18:46] = patch
    after[18 + down * cell : 46 + down * cell, 18 + right * cell : 46 + right * cell] = patch
    one, other = edge_points(before, cell, ALL), edge_points(after, cell, ALL)
    assert len(one.uv) > 3
    np.testing.assert_allclose(other.uv, one.uv + cell * np.array([right, down]), atol=1e-9)
    assert np.array_equal(other.angle, one.angle)
    assert np.array_equal(other.rise, one.rise)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(TEXTURES, st.integers(1, 4), st.integers(2, 3))
def test_larger_cells_keep_some_of_what_smaller_ones_have(size, cell, times):
    """The strongest of a cell is the strongest of that of its parts in which it lies."""
    grey = texture(*size)
    dense, sparse = ({tuple(uv) for uv in edge_points(grey, c, ALL).uv.tolist()} for c in (cell, times * cell))
    assert sparse <= dense


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (5, 50), (50, 5), (6, 6), (50, 50)])
@pytest.mark.parametrize("grey", [0, 77, 255])
def test_a_constant_picture_has_none(shape, grey):
    found = edge_points(np.full(shape, grey, np.uint8), 5, ALL)
    assert found.uv.shape == (0, 2)
    assert found.angle.shape == found.rise.shape == (0,)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(1, 5), st.integers(1, 60), st.booleans())
def test_a_tiny_picture_has_none(seed, short, long, lying):
    grey = np.random.default_rng(seed).integers(0, 256, (short, long), np.uint8)
    assert len(edge_points(grey.T if lying else grey, 5, ALL).uv) == 0


def test_the_same_picture_gives_the_same_points():
    one, other = (edge_points(texture(3, 80, 90), 5, ALL) for _ in range(2))
    assert len(one.uv) > 50
    for name in ("uv", "angle", "rise"):
        assert np.array_equal(getattr(one, name), getattr(other, name))


@settings(max_examples=20, deadline=None, derandomize=True)
@given(ANGLES, SHIFTS)
def test_a_negative_turns_every_point_about(angle, shift):
    one = edge_points(step(angle, shift, 1.0), 5, ALL)
    other = edge_points(255 - step(angle, shift, 1.0), 5, ALL)
    for found, way in ((one, 0.0), (other, pi)):
        some = inner(found.uv)
        assert some.sum() > 3
        assert np.degrees(np.abs(np.angle(np.exp(1j * (found.angle - angle - way))))[some].max()) < 2.0
