"""EXIF: what is read of it, what focal length it tells, and that no file can do harm."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from exif_files import (
    EQUIVALENT,
    FOCAL,
    HEIGHT,
    ORIENTATION,
    RESOLUTION,
    UNIT,
    WIDTH,
    exif,
    grey,
    jpeg,
    png,
    tiff,
    webp,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from sensing.files.exif import Exif, exif_of, focal_guess
from sensing.files.images import image_from

TAGS = {FOCAL: (425, 100), WIDTH: 4000, HEIGHT: 3000, RESOLUTION: (70000, 10), UNIT: 3, EQUIVALENT: 28}
READ = Exif(28.0, 4.25, 700.0, (4000, 3000), 6)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("kind", [jpeg, png, webp])
def test_it_is_read_of_every_kind_of_picture_and_the_picture_still_is(kind, order):
    data = kind(grey(40, 30), exif(TAGS, {ORIENTATION: 6}, order))
    assert exif_of(data) == READ
    assert image_from(data, "a").shape == (30, 40, 3)


def test_a_tiff_has_the_tags_itself():
    assert exif_of(exif(TAGS, {ORIENTATION: 6}, ">")) == READ._replace(orientation=1)


@pytest.mark.parametrize(("orientation", "turned"), [(1, lambda p: p), (2, np.fliplr), (3, lambda p: p[::-1, ::-1])])
def test_a_tiff_is_turned_as_it_is_read(orientation, turned):
    half = grey(40, 30)[:, :, 0]
    half[:10, :20] = 200
    data = tiff(half, orientation)
    assert np.array_equal(image_from(data, "a")[:, :, 0], turned(half))
    assert exif_of(data).orientation == 1


def test_a_double_where_the_standard_has_a_ratio_is_read():
    block = bytearray(exif({FOCAL: (0, 1)}))
    at = block.index(struct.pack("<HHI", FOCAL, 5, 1))
    block[at : at + 4] = struct.pack("<HH", FOCAL, 12)
    block[-8:] = struct.pack("<d", 4.2)
    assert exif_of(jpeg(grey(8, 6), bytes(block))).focal_mm == 4.2


def test_an_orientation_tag_turns_no_pixels():
    half = grey(40, 30)
    half[:, :20] = 200
    plain, tagged = (image_from(jpeg(half, exif({}, first)), "a") for first in ({}, {ORIENTATION: 6}))
    assert np.array_equal(plain, tagged)


@pytest.mark.parametrize(
    ("tags", "size", "f"),
    [
        ({EQUIVALENT: 28}, (4000, 3000), 5000 * 28 / 43.266615),  # the diagonal of 36 x 24 mm
        ({EQUIVALENT: 28}, (3000, 4000), 5000 * 28 / 43.266615),
        ({EQUIVALENT: 50}, (36, 24), 50.0),
        ({EQUIVALENT: 28, FOCAL: (99, 1)}, (400, 300), 500 * 28 / 43.266615),
        ({FOCAL: (18, 1), RESOLUTION: (4000, 1), UNIT: 3}, (6000, 4000), 7200.0),  # per cm
        ({FOCAL: (18, 1), RESOLUTION: (10160, 1)}, (6000, 4000), 7200.0),  # per inch, where nothing is stated
        ({FOCAL: (18, 1), RESOLUTION: (400, 1), UNIT: 4, WIDTH: 6000, HEIGHT: 4000}, (3000, 2000), 3600.0),  # scaled
    ],
)
def test_the_focal_length_by_hand(tags, size, f):
    assert focal_guess(exif_of(exif(tags)), size).f == pytest.approx(f, rel=1e-6)


@pytest.mark.parametrize(
    ("tags", "size"),
    [
        ({}, (400, 300)),
        ({EQUIVALENT: 0}, (400, 300)),  # unknown, by the standard
        ({EQUIVALENT: 1}, (400, 300)),
        ({EQUIVALENT: 60000}, (400, 300)),
        ({FOCAL: (18, 1)}, (400, 300)),
        ({FOCAL: (18, 0), RESOLUTION: (400, 1)}, (400, 300)),
        ({FOCAL: (18, 1), RESOLUTION: (0, 0)}, (400, 300)),
        ({FOCAL: (18, 1), RESOLUTION: (400, 1), UNIT: 9}, (400, 300)),
        ({FOCAL: (4_000_000_000, 1), RESOLUTION: (4_000_000_000, 1)}, (400, 300)),
        ({EQUIVALENT: 28, WIDTH: 4000, HEIGHT: 3000}, (2000, 2000)),  # cut, nobody knows where
        ({EQUIVALENT: 28, WIDTH: 4000, HEIGHT: 3000}, (4000, 2250)),
    ],
)
def test_what_tells_no_focal_length(tags, size):
    assert focal_guess(exif_of(exif(tags)), size) is None


@pytest.mark.parametrize("kind", [jpeg, png, webp])
@given(st.data())
@settings(max_examples=150, deadline=None)
def test_no_bytes_do_harm(kind, data):
    whole = bytearray(kind(grey(8, 6), exif(TAGS, {ORIENTATION: 6})))
    for at in data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=8)):
        whole[at] = data.draw(st.integers(0, 255))
    found = exif_of(bytes(whole[: data.draw(st.integers(0, len(whole)))]))
    guess = focal_guess(found, (800, 600))
    assert guess is None or 0.0 < guess.f < 1e6
    assert 1 <= found.orientation <= 8


def test_a_directory_that_leads_to_itself_or_claims_much_ends():
    block = bytearray(exif({}, {}))
    block[8:10] = b"\xff\xff"  # 65535 entries
    assert exif_of(bytes(block) + bytes(10**6)) == Exif()
    circle = exif({}, {}).replace((26).to_bytes(4, "little"), (8).to_bytes(4, "little"))
    assert exif_of(circle) == Exif()
