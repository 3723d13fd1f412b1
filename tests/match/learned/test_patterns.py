"""Whether the image goes on like this: a checkered floor does, random sides and one or two more of a thing do not."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.camera import Camera
from plogic.match.gamma.data import data_of
from plogic.match.learned.sides import AWAY, CELL, OTHERS, SOME, TURNED, share_elsewhere
from sensing.appearance import Appearance

SEEDS = st.integers(0, 9999)
CAMERA = Camera(1200, 1200, np.array([[900.0, 0, 599.5], [0, 900, 599.5], [0, 0, 1]]), np.zeros(0))
BRIGHT, DARK = (90, 140, 95, 135, 170), (150, 110, 150, 110, 86)
MIDDLE = np.array([600.0, 600.0])


def gamma(uv, angle, looks):
    """Sides as data; those out of the image are left out."""
    inside = CAMERA.contains(uv)
    rows = zip(uv[inside].tolist(), np.mod(angle[inside], 2 * pi).tolist(), looks[inside], strict=True)
    return data_of(
        [
            Appearance(f"a{i}", "sift", (u, v), "made", angle=a, descriptor=b.tobytes())
            for i, ((u, v), a, b) in enumerate(rows)
        ],
        CAMERA,
    )


def square(size, step=5.9):
    """Sides of a square's edges, facing its middle: (N, 2) pixels from it, (N,) radians."""
    along = np.arange(step / 2 - size / 2, size / 2, step)
    top = np.column_stack([along, np.full(len(along), -size / 2)])
    turns = [np.array([[cos(a), -sin(a)], [sin(a), cos(a)]]) for a in (0.0, pi / 2, pi, 3 * pi / 2)]
    return np.concatenate([top @ turn.T for turn in turns]), np.repeat(
        [pi / 2 + k * pi / 2 for k in range(4)], len(along)
    )


def checkered(size=60.0, tiles=7):
    """All sides of all squares, the bright and the dark, about ``MIDDLE``: places, angles, looks."""
    own, way = square(size)
    tile = [(i, j) for i in range(-tiles, tiles + 1) for j in range(-tiles, tiles + 1)]
    uv = np.concatenate([MIDDLE + own + size * np.array(one) for one in tile])
    looks = np.concatenate([np.tile(DARK if (i + j) % 2 else BRIGHT, (len(own), 1)) for i, j in tile]).astype(np.uint8)
    return uv, np.tile(way, len(tile)), looks


def thing(rng, count=40, size=90.0):
    """A thing of no order."""
    return (
        rng.uniform(-size / 2, size / 2, (count, 2)),
        rng.uniform(0, 2 * pi, count),
        rng.integers(100, 156, (count, 5), np.uint8),
    )


def wide(looks, varied=0.0):
    """(N, 6) as a type has them."""
    return np.column_stack([looks, np.full(len(looks), varied)]).astype(np.float32)


def turned(uv, angle, roll, shift=(0.0, 0.0)):
    c, s = cos(roll), sin(roll)
    return (uv - MIDDLE) @ np.array([[c, s], [-s, c]]) + MIDDLE + np.asarray(shift), angle + roll


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SEEDS, st.floats(40.0, 70.0), st.floats(0.0, 2 * pi))
def test_a_checkered_floor_goes_on_like_each_of_its_squares(seed, size, roll):
    rng = np.random.default_rng(seed)
    uv, angle, looks = checkered(size)
    uv, angle = turned(uv, angle, roll)
    own, way = turned(MIDDLE + square(size)[0], square(size)[1], roll)
    data = gamma(uv + rng.normal(0, 0.4, uv.shape), angle + rng.normal(0, 0.05, len(angle)), looks)
    bright = share_elsewhere(own, way, wide(np.tile(BRIGHT, (len(own), 1))), data)
    assert bright > 0.9
    other = share_elsewhere(own, way, wide(np.tile((10, 240, 10, 240, 128), (len(own), 1))), data)
    assert other == 0.0  # such colours are nowhere


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SEEDS, st.integers(100, 1500))
def test_random_sides_are_no_pattern(seed, count):
    rng = np.random.default_rng(seed)
    own, way, looks = thing(rng)
    more = rng.uniform(0, 1199, (count, 2)), rng.uniform(0, 2 * pi, count), rng.integers(100, 156, (count, 5), np.uint8)
    data = gamma(*(np.concatenate(both) for both in zip((MIDDLE + own, way, looks), more, strict=True)))
    assert share_elsewhere(MIDDLE + own, way, wide(looks), data) < 0.35


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SEEDS, st.integers(0, OTHERS + 2))
def test_only_what_is_shown_at_several_other_places_is_a_pattern(seed, copies):
    """A row of things of one type; the others stand beside the one that is asked about, all at once in reach."""
    rng = np.random.default_rng(seed)
    own, way, looks = thing(rng)
    diagonal = np.linalg.norm(np.ptp(own, axis=0))
    assert 2 * AWAY[0] < AWAY[1]
    turns = rng.uniform(0, 2 * pi) + 2 * pi * np.arange(copies) / max(copies, 1)
    shifts = np.concatenate([np.zeros((1, 2)), 1.1 * diagonal * np.column_stack([np.cos(turns), np.sin(turns)])])
    uv = np.concatenate([MIDDLE + own + shift for shift in shifts])
    data = gamma(uv, np.tile(way, copies + 1), np.tile(looks, (copies + 1, 1)))
    share = share_elsewhere(MIDDLE + own, way, wide(looks), data)
    assert (share > 0.95) if copies >= OTHERS else (share < 0.35)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SEEDS, st.floats(0.05, 0.95), st.floats(-200, 200), st.floats(-200, 200), st.floats(-pi, pi))
def test_moving_and_turning_all_changes_little(seed, kept, right, down, roll):
    """Of a floor of which a share is not found; all of it is in the image."""
    rng = np.random.default_rng(seed)
    size = 41.3  # differences of places are not at the borders of cells
    uv, angle, looks = checkered(size, 6)
    some = rng.random(len(uv)) < kept
    uv, angle, looks = uv[some], angle[some], looks[some]
    own, way = square(size)
    asked = wide(np.tile(BRIGHT, (len(own), 1)))
    plain = share_elsewhere(MIDDLE + own, way, asked, gamma(uv, angle, looks))
    moved = [turned(one, ways, 0.0, (right, down)) for one, ways in ((uv, angle), (MIDDLE + own, way))]
    assert share_elsewhere(*moved[1], asked, gamma(*moved[0], looks)) == pytest.approx(plain, abs=0.05)
    rolled = [turned(one, ways, roll) for one, ways in ((uv, angle), (MIDDLE + own, way))]
    assert share_elsewhere(*rolled[1], asked, gamma(*rolled[0], looks)) == pytest.approx(plain, abs=0.2)


@pytest.mark.parametrize(("more", "pattern"), [(0.0, True), (0.5 * TURNED, True), (1.5 * TURNED, False), (pi, False)])
def test_what_faces_another_way_is_not_found(more, pattern):
    """A thing whose sides all face one way."""
    rng = np.random.default_rng(0)
    own, _, looks = thing(rng)
    shifts = 110.0 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    uv, way = np.concatenate([MIDDLE + own + shift for shift in shifts]), np.full(4 * len(own), 1.0)
    share = share_elsewhere(MIDDLE + own, way[: len(own)] + more, wide(looks), gamma(uv, way, np.tile(looks, (4, 1))))
    assert (share > 0.95) if pattern else (share == 0.0)


def test_of_few_sides_and_of_one_place_nothing_is_said():
    uv, angle, looks = checkered()
    data = gamma(uv, angle, looks)
    own, way = MIDDLE + square(60.0)[0], square(60.0)[1]
    for count in (0, 1):
        assert share_elsewhere(own[:count], way[:count], wide(looks[:count]), data) == 0.0
    tiny = MIDDLE + (own - MIDDLE) / 60.0 * CELL
    assert share_elsewhere(tiny, way, wide(np.tile(BRIGHT, (len(own), 1))), data) == 0.0
    assert (
        share_elsewhere(own, way, wide(np.tile(BRIGHT, (len(own), 1))), data.only(np.zeros(len(data.ids), bool))) == 0.0
    )


def test_of_many_sides_some_are_looked_for():
    """As many, evenly chosen: others than these change nothing."""
    rng = np.random.default_rng(1)
    own, way, looks = thing(rng, 4 * SOME)
    data = gamma(*checkered())
    some = np.unique(np.linspace(0, len(own) - 1, SOME).round().astype(int))
    rest = ~np.isin(np.arange(len(own)), some)
    plain = share_elsewhere(MIDDLE + own, way, wide(looks), data)
    other = np.where(rest[:, None], 0, looks)
    assert share_elsewhere(MIDDLE + own, way, wide(other), data) == plain
