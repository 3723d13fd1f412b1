"""Pictures in a row: each whole, however the bytes come; what is between them or damaged is passed over."""

from __future__ import annotations

import io

import cv2
import numpy as np
import pytest

from sensing.errors import ImageError
from sensing.files import picture_stream
from sensing.files.images import image_from
from sensing.files.picture_stream import pictures_in

RNG = np.random.default_rng(0)
PICTURES = [RNG.integers(0, 256, (40 + n, 60, 3)).astype(np.uint8) for n in range(3)]
KINDS = {
    "png": (".png", []),
    "jpeg": (".jpg", []),
    "progressive": (".jpg", [cv2.IMWRITE_JPEG_PROGRESSIVE, 1]),
    "restarts": (".jpg", [cv2.IMWRITE_JPEG_RST_INTERVAL, 2]),
    "ppm": (".ppm", []),
}
PART = b"\r\n--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 1234\r\n\r\n"


class Slow:
    """A stream that gives a few bytes at a time."""

    def __init__(self, data: bytes, most: int) -> None:
        self._data, self._most = io.BytesIO(data), most

    def read1(self, size: int) -> bytes:
        """The next bytes."""
        return self._data.read(min(size, self._most))


def coded(kind):
    ending, options = KINDS[kind]
    return [cv2.imencode(ending, picture, options)[1].tobytes() for picture in PICTURES]


@pytest.mark.parametrize("between", [b"", PART], ids=["nothing", "heads"])
@pytest.mark.parametrize("most", [7, 10**6])
@pytest.mark.parametrize("kind", KINDS)
def test_each_picture_comes_whole(kind, most, between):
    whole = coded(kind)
    assert list(pictures_in(Slow(b"".join(between + one for one in whole), most), "s")) == whole


def test_a_thumbnail_in_a_jpeg_is_no_picture_of_its_own():
    (first, second, _) = coded("jpeg")
    thumb = b"\xff\xe1" + (len(second[:3000]) + 2).to_bytes(2) + second[:3000]
    outer = first[:2] + thumb + first[2:]
    assert list(pictures_in(io.BytesIO(outer + first), "s")) == [outer, first]


def test_of_a_jpeg_that_breaks_off_the_next_one_is_found():
    first, second, third = coded("jpeg")
    found = list(pictures_in(io.BytesIO(first + second[:2000] + third), "s"))
    assert found == [first, second[:2000], third]
    with pytest.raises(ImageError, match="cut off"):
        image_from(found[1], "s: picture 1")


def test_after_a_damaged_png_pictures_are_found_again():
    first, second, third = coded("png")
    broken = second[:40] + b"\0" * 500
    found = list(pictures_in(io.BytesIO(first + broken + third), "s"))
    assert (found[0], found[-1]) == (first, third)


@pytest.mark.parametrize("kind", KINDS)
def test_a_stream_that_ends_within_a_picture_gives_what_came(kind):
    first, second, _ = coded(kind)
    found = list(pictures_in(io.BytesIO(first + second[:900]), "s"))
    assert found == [first, second[:900]]
    with pytest.raises(ImageError, match="s: picture 1"):
        image_from(found[1], "s: picture 1")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"no picture at all, but a text", "has no JPEG, PNG or PNM picture"),
        (b"\x1aE\xdf\xa3" + bytes(50), r"is a video \(Matroska\)"),
        (b"\0\0\0\x18ftypisom" + bytes(50), r"is a video \(MP4\)"),
        (b"RIFF" + bytes(50), r"is a video \(AVI\)"),
    ],
)
def test_what_is_no_stream_of_pictures_is_told_with_a_remedy(data, said):
    with pytest.raises(ImageError, match=f"^s: {said}.*ffmpeg -i INPUT -f image2pipe"):
        list(pictures_in(io.BytesIO(data), "s"))


def test_an_empty_stream_has_no_pictures():
    assert list(pictures_in(io.BytesIO(b""), "s")) == []


def test_a_stream_of_nothing_useful_is_left_after_a_while(monkeypatch):
    monkeypatch.setattr(picture_stream, "BETWEEN", 1000)
    (first, *_) = coded("png")
    with pytest.raises(ImageError, match="within 1000 bytes after 1 pictures"):
        list(pictures_in(Slow(first + bytes(5000), 100), "s"))


@pytest.mark.parametrize(
    "claim", [b"P6 20000 20000 255\n", b"\x89PNG\r\n\x1a\n\x7f\xff\xff\xffIHDR"], ids=["ppm", "png"]
)
def test_a_picture_that_claims_too_much_is_refused_before_it_comes(claim):
    with pytest.raises(ImageError, match="picture 0 has more than the"):
        list(pictures_in(io.BytesIO(claim + bytes(50)), "s"))
