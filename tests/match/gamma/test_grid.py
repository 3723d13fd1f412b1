"""Data by place and direction, against a look at all pairs; and which data of Γ are sides."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import CAMERA

from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import CELL, TURNS, grid_of
from plogic.match.learned.sides import TURNED
from sensing.appearance import Appearance

SIZES = st.tuples(st.integers(1, 200), st.integers(1, 200))
COUNTS = st.integers(0, 120)
PART = 2 * pi / TURNS
ARRAYS = ("uv", "ideal", "angle", "scale", "descriptors", "described", "sided", "looks")


def places(rng, count, size):
    """(N, 2) pixels anywhere in an image, some of them at its border and some at those of cells.

    (N,) angles, some at the seam.
    """
    uv = rng.uniform(-0.5, np.array(size) - 0.5, (count, 2))
    edge = rng.random((count, 2))
    uv = np.where(edge < 0.1, -0.5, np.where(edge > 0.9, np.array(size) - 0.5, uv))
    uv = np.where(np.abs(edge - 0.5) < 0.1, np.minimum(np.round(uv / CELL) * CELL, np.array(size) - 0.5), uv)
    seam = rng.choice([0.0, -0.0, -1e-17, 1e-12, 2 * pi, np.nextafter(2 * pi, 0), PART, pi], count)
    return uv, np.where(rng.random(count) < 0.3, seam, rng.uniform(0, 2 * pi, count))


def close(uv, angle, sides, facing, reach):
    """Pairs (place, side) within ``reach`` pixels, and within a part of the circle.

    At a hair's breadth of it neither.
    """
    far = np.linalg.norm(uv[:, None] - sides[None], axis=2)
    turned = np.abs(np.angle(np.exp(1j * (angle[:, None] - facing[None]))))
    return set(
        zip(*(i.tolist() for i in np.nonzero((far <= reach[:, None] - 1e-9) & (turned <= PART - 1e-9))), strict=True)
    )


def asked(grid, uv, reach, angle=None):
    place, datum = grid.near(uv, reach, angle)
    assert (np.diff(place) >= 0).all()
    return list(zip(place.tolist(), datum.tolist(), strict=True))


REACHES = st.floats(0.0, 60.0) | st.sampled_from([1e12, 1e300])


@settings(max_examples=80, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, COUNTS, COUNTS, REACHES)
def test_every_pair_within_reach_and_a_part_of_the_circle_is_found_once(seed, size, count, others, most):
    rng = np.random.default_rng(seed)
    (uv, facing), (ask, angle), reach = (
        places(rng, count, size),
        places(rng, others, size),
        rng.uniform(0, most, others),
    )
    pairs = asked(grid_of(np.arange(count), uv, size, facing), ask, reach, angle)
    assert len(pairs) == len(set(pairs))
    assert close(ask, angle, uv, facing, reach) <= set(pairs)


@settings(max_examples=80, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, COUNTS, COUNTS, REACHES)
def test_by_place_alone_nothing_within_reach_is_missed_whichever_way_it_faces(seed, size, count, others, most):
    rng = np.random.default_rng(seed)
    (uv, facing), (ask, _), reach = places(rng, count, size), places(rng, others, size), rng.uniform(0, most, others)
    near = close(ask, np.zeros(others), uv, np.zeros(count), reach)
    by_place = asked(grid_of(np.arange(count), uv, size), ask, reach)
    assert near <= set(by_place)
    assert len(by_place) == len(set(by_place))
    assert set(asked(grid_of(np.arange(count), uv, size, facing), ask, reach, np.zeros(others))) <= set(by_place)
    assert set(asked(grid_of(np.arange(count), uv, size, facing), ask, reach)) == set(
        by_place
    )  # by direction too, but not asked for


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, COUNTS, COUNTS, REACHES)
def test_no_pair_is_farther_than_a_cell_more_and_two_parts(seed, size, count, others, reach):
    rng = np.random.default_rng(seed)
    (uv, facing), (ask, angle) = places(rng, count, size), places(rng, others, size)
    place, side = grid_of(np.arange(count), uv, size, facing).near(ask, reach, angle)
    assert (np.abs(ask[place] - uv[side]) <= reach + CELL + 1e-9).all()
    assert (np.abs(np.angle(np.exp(1j * (angle[place] - facing[side])))) <= 2 * PART + 1e-9).all()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, st.integers(1, 60), st.floats(-80.0, 80.0), st.floats(-80.0, 80.0), REACHES)
def test_places_beyond_the_border_find_what_is_near_them_too(seed, size, count, right, down, most):
    rng = np.random.default_rng(seed)
    uv, facing = places(rng, count, size)
    ask, angle = places(rng, count, size)
    ask += [right, down]
    reach = np.full(count, most)
    pairs = asked(grid_of(np.arange(count), uv, size, facing), ask, most, angle)
    assert len(pairs) == len(set(pairs))
    assert close(ask, angle, uv, facing, reach) <= set(pairs)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, COUNTS)
def test_anywhere_in_the_image_what_faces_alike_is_found_once(seed, size, count):
    rng = np.random.default_rng(seed)
    (uv, facing), (_, angle) = places(rng, count, size), places(rng, 7, size)
    place, side = grid_of(np.arange(count), uv, size, facing).facing(angle)
    pairs = list(zip(place.tolist(), side.tolist(), strict=True))
    assert len(pairs) == len(set(pairs))
    assert close(np.zeros((7, 2)), angle, np.zeros((count, 2)), facing, np.ones(7)) <= set(pairs)
    assert (np.abs(np.angle(np.exp(1j * (angle[place] - facing[side])))) <= 2 * PART + 1e-9).all()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 9999), SIZES, COUNTS, st.integers(-3, 3))
def test_data_are_named_as_they_were_given_and_whole_turns_change_nothing(seed, size, count, turns):
    rng = np.random.default_rng(seed)
    (uv, facing), names = places(rng, count, size), rng.permutation(1000)[:count]
    angle = rng.uniform(0.1, PART - 0.1, count) + PART * rng.integers(0, TURNS, count)
    plain = asked(grid_of(np.arange(count), uv, size, facing), uv, 9.0, angle)
    named = asked(grid_of(names, uv, size, facing), uv, 9.0, angle + 2 * pi * turns)
    assert {(place, int(names[side])) for place, side in plain} == set(named)
    assert len(plain) == len(named)


def test_a_part_of_the_circle_is_wider_than_what_looks_right_may_turn():
    assert PART >= TURNED


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
    rows = [
        Appearance(f"a{i}", "sift", tuple(rng.uniform(0, [639, 479]).tolist()), "made", **KINDS[kind])
        for i, kind in enumerate(kinds)
    ]
    turned = [
        replace(row, angle=float(rng.uniform(0, 2 * pi))) if kind == SIDE else row
        for row, kind in zip(rows, kinds, strict=True)
    ]
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
        place, side = data.sides.near(data.uv[data.sided], 0.0, data.angle[data.sided])
        mine = np.flatnonzero(data.sided)
        assert data.sided[side].all()
        assert {(i, int(mine[i])) for i in range(len(mine))} <= set(zip(place.tolist(), side.tolist(), strict=True))
        assert data.sides is data.sides
