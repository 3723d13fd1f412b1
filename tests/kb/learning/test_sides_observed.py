"""Sides that come again, stretches of edges, and what is seen of a plain plate from its front.

Its outline, from within.
"""

from __future__ import annotations

from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_sides import DIAMETER, PIXEL, an_edge, towards
from painted_cube import PIXELS, sizes

from geometry.camera import Camera
from geometry.frames import look_at
from kb.clouds.words import COLOURS, SIDE
from kb.learning.again import (
    ACROSS,
    ALONG,
    STRETCH,
    TINTED,
    TURNED,
    VARIED,
    WIDE,
    sides_again,
)
from kb.learning.features import PIXELS_WIDE, SAME_WAY, side_places
from kb.learning.observations import ALWAYS, PICTURES_OF_SIDES, joined, observed
from sensing.detectors.keypoint_detector import described, edge_sides

SEEDS = st.integers(0, 9999)
RED = (40, 50, 190)
"""Blue first."""
HALF, AWAY, F, SIZE = 0.05, 1.0, 4000.0, 480
"""Of the plate: half its side, its distance; of its picture: the focal length, the side. It is 400 pixels wide."""


def sides(rng, count, room=20.0):
    uv, angle = rng.uniform(0, room, (count, 2)), rng.uniform(0, 2 * np.pi, count)
    return SimpleNamespace(uv=uv, angle=np.round(angle, 1), looks=rng.integers(100, 140, (count, SIDE), np.uint8))


def comes_again(one, i, other):
    """By a loop over all sides of the other picture."""
    for place, angle, looks in zip(other.uv, other.angle, other.looks, strict=True):
        right, down = place - one.uv[i]
        cos, sin = np.cos(one.angle[i]), np.sin(one.angle[i])
        turned = abs(np.angle(np.exp(1j * (angle - one.angle[i]))))
        tinted = np.linalg.norm(looks[:COLOURS].astype(float) - one.looks[i, :COLOURS])
        if (
            abs(right * cos + down * sin) < ACROSS
            and abs(down * cos - right * sin) < ALONG
            and turned < TURNED
            and tinted < TINTED
        ):
            return True
    return False


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, st.integers(0, 40), st.lists(st.integers(0, 60), max_size=3))
def test_sides_come_again_where_a_loop_finds_them(seed, count, others):
    rng = np.random.default_rng(seed)
    first, rest = sides(rng, count), [sides(rng, number) for number in others]
    expected = [sum(comes_again(first, i, other) for other in rest) / max(len(rest), 1) for i in range(count)]
    assert sides_again(first, rest) == pytest.approx(expected)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, st.integers(1, 40))
def test_what_is_the_same_comes_always_and_what_faces_away_never(seed, count):
    first = sides(np.random.default_rng(seed), count, room=5000.0)
    away = SimpleNamespace(uv=first.uv, angle=first.angle + np.pi, looks=first.looks)
    assert sides_again(first, [first, first]).tolist() == [1.0] * count
    assert sides_again(first, [away]).tolist() == [0.0] * count


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SEEDS, st.integers(1, 4), st.integers(1, 3))
def test_stretches_share_out_all_sides_and_none_is_longer_or_wider_than_one(seed, times, edges):
    rng = np.random.default_rng(seed)
    views = [towards(rng.normal(size=3), 12.0) for _ in range(edges)]
    seen = joined(
        [an_edge(rng, some, times, along=0.1, across=0.002, middle=rng.uniform(-0.1, 0.1, 3)) for some in views]
    )
    which = np.flatnonzero(rng.random(len(seen)) < 0.8)
    groups = side_places(seen, which, DIAMETER)
    assert sorted(i for group in groups for i in group.tolist()) == which.tolist()
    for group in groups:
        off, up = seen.at[group][:, None] - seen.at[group][None], seen.up[group]
        reach = np.linalg.norm(off, axis=2).max(axis=1)
        wide = np.abs(np.einsum("ijk,jk->ij", off, up)).max(axis=0)
        alike = (up @ up.T).min(axis=1)
        first = (
            (reach <= STRETCH * DIAMETER)
            & (wide <= max(WIDE * DIAMETER, PIXELS_WIDE * PIXEL))
            & (alike > SAME_WAY - 1e-12)
        )
        assert first.any(), "all are near to one of them"


def test_no_sides_have_no_stretches():
    assert (
        side_places(an_edge(np.random.default_rng(0), towards((0, 0, 1), 12.0)), np.zeros(0, np.intp), DIAMETER) == []
    )


def plate(paint=None):
    """A view of a square plate in the plane z = 0, from above; all red, or painted."""
    camera_from_plate = look_at(np.array([0.0, 0.0, AWAY]), np.zeros(3), (0.0, 1.0, 0.0))
    middle = (SIZE - 1) / 2
    camera = Camera(
        SIZE,
        SIZE,
        np.array([[F, 0, middle], [0, F, middle], [0, 0, 1]]),
        world_from_camera=np.linalg.inv(camera_from_plate),
    )
    mask = np.zeros((SIZE, SIZE), bool)
    inside = slice(round(middle + 0.5 - F * HALF / AWAY), round(middle + 0.5 + F * HALF / AWAY))
    mask[inside, inside] = True
    image = np.zeros((SIZE, SIZE, 3), np.uint8)
    image[mask] = RED if paint is None else paint[mask]
    return SimpleNamespace(
        image=image, mask=mask, depth=np.full((SIZE, SIZE), AWAY, np.float32), camera=camera, pixels=2 * HALF * F / AWAY
    )


def detect(image, calm, cell, where, like):
    return described(image, cell=cell, calm=calm, where=where, like=like)


def look(image, cell, where):
    return edge_sides(image, cell, where=where)


@pytest.mark.parametrize("seed", [0, 1])
def test_sides_of_a_plain_plate_are_on_its_rim_and_face_its_middle(seed):
    with sizes():
        whole = observed(plate(), 7, detect, seed, look)
    on_plate = np.abs(whole.at[:, :2]).max(axis=1)
    assert np.abs(whole.at[whole.sided][:, 2]).max() < 1e-6
    assert (on_plate < HALF + 1.5 * whole.pixel)[whole.sided].all()
    rows = np.flatnonzero(whole.sided & (on_plate > HALF - 4 * whole.pixel))  # within there are those of noise alone
    assert len(rows) > 60
    at, up, pixel = whole.at[rows, :2], whole.up[rows], whole.pixel[rows]
    assert np.quantile(np.abs(on_plate[rows] - HALF) / pixel, 0.9) < 1.0
    straight = np.abs(at).min(axis=1) < HALF - 6 * pixel
    inward = np.where(np.abs(at) == np.abs(at).max(axis=1, keepdims=True), -np.sign(at), 0.0)
    assert np.quantile((up[:, :2] * inward).sum(axis=1)[straight], 0.05) > 0.9
    assert np.abs((up * whole.direction[rows]).sum(axis=1)).max() < 1e-9
    assert ((whole.hit[whole.sided] >= ALWAYS) & (whole.hit[whole.sided] <= 1)).all()
    assert set((whole.hit[rows] * (PICTURES_OF_SIDES - 1)).round(9).tolist()) <= set(range(PICTURES_OF_SIDES))
    assert set(whole.level[rows].tolist()) == set(range(len(PIXELS)))
    assert set(whole.view[rows].tolist()) == {7}
    assert not whole.descriptor[rows, :128].any()
    assert not whole.descriptor[rows, VARIED:].any()
    red, blue = whole.descriptor[rows, 130], whole.descriptor[rows, 131]
    assert np.quantile(red, 0.1) > 170  # far redder than green, whatever the light
    assert np.median(np.abs(blue - 128)) < 30


def test_where_nobody_needs_to_look_nothing_that_counts_is_missed():
    """All of every picture is looked at by the one, what is on the object and may come again by the other."""
    paint = np.random.default_rng(1).integers(0, 256, (SIZE // 8, SIZE // 8, 3), np.uint8)
    paint = paint.repeat(8, axis=0).repeat(8, axis=1)

    def everywhere(image, calm, cell, *_):
        return described(image, cell=cell, calm=calm)

    with sizes():
        here = observed(plate(paint), 3, detect, 5, look)
        whole = observed(plate(paint), 3, everywhere, 5, lambda image, cell, _: edge_sides(image, cell))
    assert 0 < here.sided.sum() < len(here)
    assert ordered(here) == ordered(whole)


def ordered(some):
    """The observations as rows, in an order of their own: that of sides is of all that a picture has."""
    return sorted(np.column_stack([getattr(some, f.name) for f in fields(some)]).tolist())


def test_looking_at_sides_changes_nothing_of_keypoints():
    paint = (
        np.random.default_rng(0)
        .integers(0, 256, (SIZE // 8, SIZE // 8, 3), np.uint8)
        .repeat(8, axis=0)
        .repeat(8, axis=1)
    )
    with sizes():
        plain, both = (observed(plate(paint), 3, detect, 5, *more) for more in ((), (look,)))
        again = observed(plate(paint), 3, detect, 5, look)
    points = ~both.sided
    assert 0 < points.sum() < len(both)
    assert not plain.sided.any()
    for f in fields(plain):
        assert np.array_equal(getattr(both, f.name)[points], getattr(plain, f.name)), f.name
        assert np.array_equal(getattr(both, f.name), getattr(again, f.name)), f.name
