"""Image files: what is read, and one clear line for what cannot be."""

from __future__ import annotations

import logging
import struct
import zlib

import cv2
import numpy as np
import pytest

from sensing.errors import ImageError
from sensing.files.images import read_image

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


@pytest.mark.parametrize(("factor", "greatest"), [(257, 65535), (16, 4095), (4, 1023), (1, 255)])
def test_sixteen_bits_are_scaled_by_their_sensor_s_range_and_it_is_said(tmp_path, caplog, factor, greatest):
    caplog.set_level(logging.INFO, "plogic.sensing")
    found = read_image(written(tmp_path / "deep.png", PIXELS.astype(np.uint16) * factor))
    assert np.abs(found.astype(int) - PIXELS).max() <= 1
    assert f"16 bits a channel, 0 to {greatest} scaled" in caplog.text


def test_sixteen_bits_of_grey_with_alpha(tmp_path):
    deep = np.dstack([PIXELS[:, :, 0].astype(np.uint16) * 257] * 3 + [np.full(PIXELS.shape[:2], 65535, np.uint16)])
    assert np.array_equal(read_image(written(tmp_path / "deep.png", deep)), np.repeat(PIXELS[:, :, :1], 3, axis=2))


def test_floating_point_is_refused(tmp_path):
    with pytest.raises(ImageError, match=r"f\.tiff: its pixels are float32"):
        read_image(written(tmp_path / "f.tiff", PIXELS.astype(np.float32)))


def png(width, height, depth, colour, rows, *extra):
    """A PNG file's bytes from its raw rows; ``extra`` are (name, data) of further chunks."""
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    parts = [(b"IHDR", header), *extra, (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    whole = [struct.pack(">I", len(d)) + n + d + struct.pack(">I", zlib.crc32(n + d)) for n, d in parts]
    return b"\x89PNG\r\n\x1a\n" + b"".join(whole)


def test_a_palette_is_looked_up_and_one_bit_is_grey(tmp_path):
    palette = (b"PLTE", bytes([255, 0, 0, 0, 255, 0]))
    (tmp_path / "p.png").write_bytes(png(2, 1, 8, 3, b"\0\0\1", palette))
    (tmp_path / "t.png").write_bytes(png(2, 1, 8, 3, b"\0\0\1", palette, (b"tRNS", b"\0\xff")))
    for name in ("p.png", "t.png"):
        assert read_image(tmp_path / name).tolist() == [[[0, 0, 255], [0, 255, 0]]]
    (tmp_path / "b.png").write_bytes(png(8, 1, 1, 0, b"\0\xf0"))
    assert read_image(tmp_path / "b.png")[0, :, 1].tolist() == [255] * 4 + [0] * 4


def test_an_orientation_tag_is_not_applied(tmp_path):
    jpeg = written(tmp_path / "a.jpg", PIXELS).read_bytes()
    tag = b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"
    (tmp_path / "b.jpg").write_bytes(jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(tag) + 2) + tag + jpeg[2:])
    assert np.array_equal(read_image(tmp_path / "b.jpg"), read_image(tmp_path / "a.jpg"))


def test_a_damaged_png_is_refused_and_nothing_is_said_on_standard_error(tmp_path, capfd):
    whole = bytearray(written(tmp_path / "a.png", PIXELS).read_bytes())
    whole[len(whole) // 2] ^= 0xFF
    (tmp_path / "b.png").write_bytes(whole)
    with pytest.raises(ImageError, match=r"b\.png: the PNG file is damaged: the checksum"):
        read_image(tmp_path / "b.png")
    bmp = written(tmp_path / "a.bmp", PIXELS).read_bytes()
    (tmp_path / "b.bmp").write_bytes(bmp[: len(bmp) // 2])
    with pytest.raises(ImageError, match=r"b\.bmp: is not an image"):
        read_image(tmp_path / "b.bmp")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("size", [(100_000, 100_000), (0, 5)])
def test_a_png_that_claims_too_many_pixels_or_none_is_refused(tmp_path, size):
    (tmp_path / "b.png").write_bytes(png(*size, 8, 2, b"\0"))
    with pytest.raises(ImageError, match=f"says that it has {size[0]}x{size[1]} pixels"):
        read_image(tmp_path / "b.png")


@pytest.mark.parametrize("kind", ["png", "jpg"])
def test_a_cut_off_file_is_refused(tmp_path, kind):
    whole = written(tmp_path / f"a.{kind}", PIXELS).read_bytes()
    (tmp_path / f"b.{kind}").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ImageError, match="cut off"):
        read_image(tmp_path / f"b.{kind}")


@pytest.mark.parametrize(
    ("data", "why"), [(b"", "is empty"), (b"not an image", "is not an image"), (b"\x89PNG\r\n\x1a\nxx", "cut off")]
)
def test_what_is_no_image_is_refused(tmp_path, data, why):
    (tmp_path / "x.jpg").write_bytes(data)
    with pytest.raises(ImageError, match=why) as caught:
        read_image(tmp_path / "x.jpg")
    assert "\n" not in str(caught.value)


def test_a_missing_file_or_a_folder_is_one_clear_line(tmp_path):
    for path in (tmp_path / "none.png", tmp_path):
        with pytest.raises(ImageError, match="cannot be read"):
            read_image(path)
