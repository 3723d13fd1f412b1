"""Image files: what is read, and one clear line for what cannot be."""

from __future__ import annotations

import logging
import struct
import zlib

import cv2
import numpy as np
import pytest

from sensing.errors import ImageError
from sensing.files.images import image_from, read_image
from sensing.files.picture_heads import head_of

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


KINDS = {
    "png": "PNG", "jpg": "JPEG", "bmp": "BMP", "gif": "GIF", "tiff": "TIFF", "webp": "WebP", "pgm": "PNM", "ppm": "PNM", "pbm": "PNM",
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_the_head_tells_what_the_decoder_gives(tmp_path, kind):
    pixels = PIXELS[:, :, 0] if kind in ("pgm", "pbm") else PIXELS
    path = written(tmp_path / f"a.{kind}", pixels)
    assert head_of(path.read_bytes()) == (KINDS[kind], 32, 24)
    assert read_image(path).shape == (24, 32, 3)


@pytest.mark.parametrize("kind", ["hdr", "ras", "pfm"])
def test_a_kind_whose_head_is_not_read_is_not_decoded(tmp_path, kind):
    pixels = PIXELS.astype(np.float32) if kind in ("hdr", "pfm") else PIXELS
    with pytest.raises(ImageError, match=r"is not an image that can be read .*: PNG, JPEG, BMP"):
        read_image(written(tmp_path / f"a.{kind}", pixels))


def jpeg_of(width, height):
    """A JPEG that says so of 24 rows of 32 pixels."""
    data = bytearray(cv2.imencode(".jpg", PIXELS)[1].tobytes())
    at = data.find(b"\xff\xc0") + 5
    data[at : at + 4] = struct.pack(">HH", height, width)
    return bytes(data)


def bmp_of(width, height):
    data = cv2.imencode(".bmp", PIXELS)[1].tobytes()
    return data[:18] + struct.pack("<ii", width, height) + data[26:]


def ppm_of(width, height):
    return b"P6 # a comment\n%d\n%d 255\n" % (width, height) + PIXELS.tobytes()


def gif_of(width, height):
    data = cv2.imencode(".gif", PIXELS)[1].tobytes()
    return data[:6] + struct.pack("<HH", width, height) + data[10:]


@pytest.mark.parametrize("made", [jpeg_of, bmp_of, ppm_of, gif_of])
def test_a_picture_that_lies_about_its_size_is_refused(tmp_path, capfd, made):
    (tmp_path / "lie").write_bytes(made(30_000, 30_000))
    with pytest.raises(ImageError, match="says that it has 30000x30000 pixels, not 1 to"):
        read_image(tmp_path / "lie")
    (tmp_path / "lie").write_bytes(made(32, 24))
    assert read_image(tmp_path / "lie").shape == (24, 32, 3)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("made", [jpeg_of, bmp_of, ppm_of])
def test_a_picture_that_ends_before_its_rows_do_is_refused(tmp_path, capfd, made):
    (tmp_path / "lie").write_bytes(made(32, 60))
    with pytest.raises(ImageError, match=r"the file is damaged|is not an image that OpenCV can read"):
        read_image(tmp_path / "lie")
    assert capfd.readouterr().err == ""


def test_what_the_decoder_calls_corrupt_is_refused_and_says_nothing_itself(tmp_path, capfd):
    whole = cv2.imencode(".jpg", PIXELS)[1].tobytes()
    (tmp_path / "cut.jpg").write_bytes(whole[:-100] + b"\xff\xd9")
    with pytest.raises(ImageError, match=r"cut\.jpg: the file is damaged: Corrupt JPEG data: premature end"):
        read_image(tmp_path / "cut.jpg")
    (tmp_path / "more.jpg").write_bytes(whole[:-2] + b"some more\xff\xd9")  # as many cameras send it
    assert np.array_equal(read_image(tmp_path / "more.jpg"), cv2.imdecode(np.frombuffer(whole, np.uint8), 1))
    assert capfd.readouterr().err == ""


def test_a_jpeg_of_thousands_of_scans_is_not_decoded(tmp_path):
    scans = b"\xff\xda" * 3000
    with pytest.raises(ImageError, match="has 3001 scans of 1000x1000 pixels, more than 2000000000 in all"):
        image_from(jpeg_of(1000, 1000)[:-2] + scans + b"\xff\xd9", "bomb.jpg")
