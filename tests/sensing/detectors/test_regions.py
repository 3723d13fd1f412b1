"""Regions of one colour or brightness: found whole, described by their shape and colour, whatever lies behind."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kb.learning.features import ALIKE
from sensing.detectors.keypoint_detector import described
from sensing.detectors.keypoints import ratios
from sensing.detectors.regions import TURNS, regions

YELLOW, RED, BLUE = (30, 190, 220), (30, 30, 200), (190, 70, 20)
SHAPES = {
    "arrow": np.array([[-30, -8], [5, -8], [5, -22], [35, 0], [5, 22], [5, 8], [-30, 8]], float),
    "box": np.array([[-35, -15], [35, -15], [35, 15], [-35, 15]], float),
    "wedge": np.array([[-30, -20], [40, 0], [-30, 20]], float),
}


def scene(shape="arrow", colour=YELLOW, *, turn=0.0, size=1.0, at=(150.0, 110.0), floor=0, level=110.0, seed=0):
    """A shape on a grey floor with noise; ``floor``: how different the spots of the floor are."""
    rng = np.random.default_rng(seed)
    spots = cv2.resize(rng.normal(0, floor, (16, 20)).astype(np.float32), (320, 240), interpolation=cv2.INTER_CUBIC)
    image = np.repeat((level + spots)[..., None], 3, axis=2)
    R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    corners = size * SHAPES[shape] @ R.T + at
    cover = np.zeros((240, 320), np.uint8)
    cv2.fillPoly(cover, [np.rint(corners * 16).astype(np.int32)], 255, cv2.LINE_AA, 4)
    share = cover[..., None] / 255.0
    image = share * np.array(colour) + (1.0 - share) * image + rng.normal(0, 3.0, image.shape)
    return np.clip(np.rint(image), 0, 255).astype(np.uint8), cover > 127


def about(found, mask):
    """Indices of the regions that are the shape: their place and size are the mask's."""
    y, x = np.nonzero(mask)
    radius = np.sqrt(len(x) / np.pi)
    near = np.linalg.norm(found.uv - [x.mean(), y.mean()], axis=1) < 1.5
    return np.flatnonzero(near & (np.abs(found.scale / (2 * radius) - 1) < 0.15))


def apart(one, i, other, j):
    return np.linalg.norm(
        one.descriptors[i].astype(float)[:, None] - other.descriptors[j].astype(float)[None], axis=2
    ).min()


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    st.sampled_from(sorted(SHAPES)),
    st.floats(0, 6.28),
    st.floats(0.7, 1.6),
    st.sampled_from([YELLOW, RED, BLUE]),
    st.integers(0, 99),
)
def test_a_coloured_shape_is_found_whole(shape, turn, size, colour, seed):
    image, mask = scene(shape, colour, turn=turn, size=size, floor=15, seed=seed)
    found = regions(image)
    mine = about(found, mask)
    assert len(mine) >= 1
    seen = found.descriptors[mine[0], 128:].astype(int).reshape(-1, 2)
    assert np.abs(seen - ratios(np.array(colour, float)).astype(int)).max() <= 25  # its rim is mixed with the floor


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.sampled_from(["arrow", "wedge"]), st.floats(0, 6.28), st.floats(0.8, 1.8))
def test_turned_and_grown_it_looks_the_same_and_its_angle_turns_with_it(shape, turn, size):
    (image, mask), (other, its_mask) = scene(shape), scene(shape, turn=turn, size=size, seed=1)
    one, two = regions(image), regions(other)
    i, j = about(one, mask), about(two, its_mask)
    far = np.linalg.norm(one.descriptors[i].astype(float)[:, None] - two.descriptors[j].astype(float)[None], axis=2)
    mine, its = np.unravel_index(far.argmin(), far.shape)
    assert far[mine, its] < ALIKE[138]  # one appearance of a learned type
    turned = two.angle[j[its]] - one.angle[i[mine]] - turn
    assert abs((turned + np.pi) % (2 * np.pi) - np.pi) < 0.15


@pytest.mark.parametrize("shape", sorted(SHAPES))
@pytest.mark.parametrize(("level", "floor"), [(40.0, 5), (200.0, 5), (110.0, 30)])
def test_what_lies_behind_counts_for_nothing(shape, level, floor):
    """A shape before another floor is as like as two pictures of it may be.

    Two shapes are farther apart, whatever lies behind.
    """
    (image, mask), (other, its_mask) = scene(shape), scene(shape, level=level, floor=floor, seed=2)
    one, two = regions(image), regions(other)
    same = apart(one, about(one, mask), two, about(two, its_mask))
    assert same < 100.0
    for name in set(SHAPES) - {shape}:
        third, third_mask = scene(name, level=level, floor=floor, seed=3)
        three = regions(third)
        assert apart(one, about(one, mask), three, about(three, third_mask)) > 1.5 * same


def test_shading_does_not_split_a_colour():
    image, mask = scene("box", YELLOW, size=1.5)
    shade = np.linspace(1.0, 0.45, 320)[None, :, None]
    found = regions(np.clip(image * shade, 0, 255).astype(np.uint8))
    assert len(about(found, mask))


def test_without_colours_there_is_brightness_alone():
    image, mask = scene("arrow", (240, 240, 240))
    grey = np.ascontiguousarray(image[..., 0])
    found = regions(grey)
    assert found.descriptors.shape[1] == 128
    assert len(about(found, mask))
    assert regions(image).descriptors.shape[1] == 138


@pytest.mark.parametrize(
    "image", [np.zeros((240, 320, 3), np.uint8), np.full((2, 2, 3), 9, np.uint8), np.zeros((1, 40), np.uint8)]
)
def test_where_nothing_stands_out_there_are_none(image):
    found = regions(image)
    assert len(found) == 0
    assert found.descriptors.shape[0] == 0


def test_no_more_than_asked_for_and_always_the_same():
    image, _ = scene(floor=60)
    some, again, few = regions(image), regions(image.copy()), regions(image, 2)
    assert len(np.unique(few.uv, axis=0)) <= 2
    assert len(few) <= 2 * TURNS
    np.testing.assert_array_equal(some.descriptors, again.descriptors)
    np.testing.assert_array_equal(few.uv, some.uv[: len(few)])
    assert ((some.angle >= 0) & (some.angle < 2 * np.pi)).all()


def test_described_puts_them_last():
    image, _ = scene()
    found, own = described(image), regions(image)
    np.testing.assert_array_equal(found.uv[-len(own) :], own.uv)
    np.testing.assert_array_equal(found.descriptors[-len(own) :], own.descriptors)
