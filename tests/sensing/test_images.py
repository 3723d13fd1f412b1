"""Image files: what is read, and one clear line for what cannot be."""

from __future__ import annotations

import logging

import cv2
import numpy as np
import pytest

from sensing.errors import ImageError
from sensing.images import read_image

PIXELS = np.random.default_rng(0).integers(0, 256, (24, 32, 3)).astype(np.uint8)


def written(path, pixels):
    assert cv2.imwrite(str(path), pixels)
    return path


def test_colour_is_read_as_it_is(tmp_path):
    assert np.array_equal(read_image(written(tmp_path / "a.png", PIXELS)), PIXELS)


def test_grey_and_alpha_are_converted_and_it_is_said(tmp_path, caplog):
    caplog.set_level(logging.INFO, "plogic.sensing")
    grey = read_image(written(tmp_path / "g.png", PIXELS[:, :, 0]))
    assert np.array_equal(grey, np.repeat(PIXELS[:, :, :1], 3, axis=2))
    alpha = read_image(written(tmp_path / "t.png", np.dstack([PIXELS, PIXELS[:, :, 0]])))
    assert np.array_equal(alpha, PIXELS)
    assert "grey" in caplog.text
    assert "alpha" in caplog.text


def test_sixteen_bits_are_refused(tmp_path):
    with pytest.raises(ImageError, match=r"deep\.png: has 16 bits a channel"):
        read_image(written(tmp_path / "deep.png", PIXELS.astype(np.uint16) * 256))


@pytest.mark.parametrize("kind", ["png", "jpg"])
def test_a_cut_off_file_is_refused(tmp_path, kind):
    whole = written(tmp_path / f"a.{kind}", PIXELS).read_bytes()
    (tmp_path / f"b.{kind}").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ImageError, match="cut off"):
        read_image(tmp_path / f"b.{kind}")


@pytest.mark.parametrize(("data", "why"), [(b"", "is empty"), (b"not an image", "is not an image")])
def test_what_is_no_image_is_refused(tmp_path, data, why):
    (tmp_path / "x.png").write_bytes(data)
    with pytest.raises(ImageError, match=why):
        read_image(tmp_path / "x.png")


def test_a_missing_file_or_a_folder_is_one_clear_line(tmp_path):
    for path in (tmp_path / "none.png", tmp_path):
        with pytest.raises(ImageError, match="cannot be read"):
            read_image(path)
