"""Sides of edges by place and direction, against a look at all pairs; and which data of Γ are sides."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from learnt_scenes import CAMERA

from plogic.search.data import data_of
from plogic.search.learnt.side_grid import CELL, TURNS, side_grid
from sensing.appearance import Appearance

SIZES = st.tuples(st.integers(1, 200), st.integers(1, 200))
COUNTS = st.integers(0, 120)
PART = 2 * pi / TURNS
ARRAYS = ("uv", "ideal", "angle", "scale", "descriptors", "described", "sided", "looks")


def places(rng, count, size):
    """(N, 2) pixels anywhere in an image, some of them at its border and some at those of cells; (N,) angles, some at the seam."""
    uv = rng.uniform(-0.5, np.array(size) - 0.5, (count, 2))
    edge = rng.random((count, 2))
    uv = np.where(edge < 0.1, -0.5, np.where(edge > 0.9, np.array(size) - 0.5, uv))
    uv = np.where(np.abs(edge - 0.5) < 0.1, np.minimum(np.round(uv / CELL) * CELL, np.array(size) - 0.5), uv)
    seam = rng.choice([0.0, -0.0, -1e-17, 1e-12, 2 * pi, np.nextafter(2 * pi, 0), PART, pi], count)
    return uv, np.where(rng.random(count) < 0.3, seam, rng.uniform(0, 2 * pi, count))


def close(uv, angle, sides, facing):
    """Pairs (place, side) within a cell in both directions, and within a part of the circle; at a hair's breadth of it neither."""
    far = np.abs(uv[:, None] - sides[None]).max(axis=2)
    turned = np.abs(np.angle(np.exp(1j * (angle[:, None] - facing[None]))))
    return set(zip(*np.nonzero((far <= CELL - 1e-9) & (turned <= PART - 1e-9)), strict=True))


def asked(grid, uv, angle):
    place, datum = grid.near(uv, angle)
    return list(zip(place.tolist(), datum.tolist(), strict=True))


@settings(max_examples=80, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, COUNTS, COUNTS)
def test_every_pair_within_a_cell_and_a_part_of_the_circle_is_found_once(seed, size, count, others):
    rng = np.random.default_rng(seed)
    (uv, facing), (ask, angle) = places(rng, count, size), places(rng, others, size)
    pairs = asked(side_grid(np.arange(count), uv, facing, size), ask, angle)
    assert len(pairs) == len(set(pairs))
    assert close(ask, angle, uv, facing) <= set(pairs)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, COUNTS, COUNTS)
def test_no_pair_is_farther_than_two_cells_and_two_parts(seed, size, count, others):
    rng = np.random.default_rng(seed)
    (uv, facing), (ask, angle) = places(rng, count, size), places(rng, others, size)
    place, side = side_grid(np.arange(count), uv, facing, size).near(ask, angle)
    assert (np.abs(ask[place] - uv[side]) <= 2 * CELL + 1).all()  # half a pixel of the border belongs to the cells at it
    assert (np.abs(np.angle(np.exp(1j * (angle[place] - facing[side])))) <= 2 * PART + 1e-9).all()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, st.integers(1, 60), st.floats(-40.0, 40.0), st.floats(-40.0, 40.0))
def test_places_beyond_the_border_find_what_is_near_them_too(seed, size, count, right, down):
    rng = np.random.default_rng(seed)
    uv, facing = places(rng, count, size)
    ask, angle = places(rng, count, size)
    ask += [right, down]
    pairs = asked(side_grid(np.arange(count), uv, facing, size), ask, angle)
    assert len(pairs) == len(set(pairs))
    assert close(ask, angle, uv, facing) <= set(pairs)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, COUNTS, st.integers(-3, 3))
def test_sides_are_named_as_they_were_given_and_whole_turns_change_nothing(seed, size, count, turns):
    rng = np.random.default_rng(seed)
    (uv, facing), names = places(rng, count, size), rng.permutation(1000)[:count]
    angle = rng.uniform(0.1, PART - 0.1, count) + PART * rng.integers(0, TURNS, count)
    plain = asked(side_grid(np.arange(count), uv, facing, size), uv, angle)
    named = asked(side_grid(names, uv, facing, size), uv, angle + 2 * pi * turns)
    assert {(place, int(names[side])) for place, side in plain} == set(named)
    assert len(plain) == len(named)


def test_a_cell_is_thirty_two_pixels_and_a_part_twenty_degrees():
    assert CELL == 32
    assert np.degrees(PART) == 20.0


KINDS = (
    {"angle": 1.0, "scale": 4.0, "descriptor": bytes(range(128))},
    {"angle": 2.0, "descriptor": b"\x05\x80\xff\x01\x90"},  # the only side
    {"angle": 2.0, "scale": 3.0, "descriptor": b"\x05\x80\xff\x01\x90"},
    {"descriptor": b"\x05\x80\xff\x01\x90"},
    {"angle": 0.5, "descriptor": bytes(range(32))},
    {"arms": (0.1, 2.0)},
)
SIDE = 1


def made(kinds, seed=0):
    rng = np.random.default_rng(seed)
    rows = [Appearance(f"a{i}", "sift", tuple(rng.uniform(0, [639, 479]).tolist()), "made", **KINDS[kind]) for i, kind in enumerate(kinds)]
    turned = [replace(row, angle=float(rng.uniform(0, 2 * pi))) if kind == SIDE else row for row, kind in zip(rows, kinds, strict=True)]
    return data_of(turned, CAMERA)


MIXED = st.lists(st.integers(0, len(KINDS) - 1), max_size=20)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(MIXED)
def test_sides_of_edges_are_data_with_an_angle_and_five_bytes_and_no_scale(kinds):
    data = made(kinds)
    assert data.sided.tolist() == [kind == SIDE for kind in kinds]
    assert data.looks.tolist() == [[5, 128, 255, 1, 144] if kind == SIDE else [0] * 5 for kind in kinds]
    assert data.described.tolist() == [kind == 0 for kind in kinds]
    assert data.looks.dtype == np.uint8


@settings(max_examples=40, deadline=None, derandomize=True)
@given(MIXED, st.lists(st.booleans(), min_size=20, max_size=20), st.integers(0, 9999))
def test_a_part_of_the_data_has_its_own_sides(kinds, choice, seed):
    keep = np.array(choice[: len(kinds)], bool)
    whole = made(kinds, seed)
    part, rows = whole.only(keep), np.flatnonzero(keep)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[rows])
    for data in (whole, part):
        place, side = data.sides.near(data.uv[data.sided], data.angle[data.sided])
        mine = np.flatnonzero(data.sided)
        assert data.sided[side].all()
        assert {(i, int(mine[i])) for i in range(len(mine))} <= set(zip(place.tolist(), side.tolist(), strict=True))
        assert data.sides is data.sides
