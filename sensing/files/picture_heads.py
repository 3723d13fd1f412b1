"""What the head of a picture's file says before anything of it is decoded: its kind, its width and its height.

A file of some hundred bytes can claim any size, and a decoder reserves and fills it: so the size is held to a limit,
and to the camera, first. Kinds that no head is read of are not decoded at all.

* ``head_of(data) == Head("PNG", 640, 480)``
"""

import re
import struct
from collections.abc import Callable
from typing import NamedTuple

from sensing.files.exif import tiff_tags

KINDS = "PNG, JPEG, BMP, GIF, TIFF, WebP, PBM, PGM and PPM"
"""What is read, for people."""
PNG_START, JPEG_START = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"
LONGEST_HEAD = 65_536
"""Bytes of comments and white space within which the numbers of a PNM stand."""
_ORIENTATION, _WIDTH, _HEIGHT = 0x0112, 0x0100, 0x0101
_SPACE = rb"(?:\s|#[^\r\n]*[\r\n])+"
_PNM = re.compile(rb"P[1-6]" + _SPACE + rb"(\d{1,9})" + _SPACE + rb"(\d{1,9})\s")
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers of JPEG whose segment tells the size."""


class Head(NamedTuple):
    """``kind``: PNG, say. ``width`` and ``height``: pixels, as they will be decoded."""

    kind: str
    width: int
    height: int


def head_of(data: bytes) -> Head | None:
    """What the head of a picture's file says; None of any other kind, or where the head cannot be read."""
    for start, kind, size_of in _HEADS:
        if data.startswith(start):
            try:
                size = size_of(data)
            except struct.error:  # cut off
                return None
            return None if size is None else Head(kind, *size)
    return None


Size = tuple[int, int] | None


def _of_png(data: bytes) -> Size:
    width, height = struct.unpack_from(">II", data, 16)
    return width, height


def _of_jpeg(data: bytes) -> Size:
    """The first segment that tells a size; what stands between segments is passed over, as decoders do."""
    at = 2
    while (at := data.find(b"\xff", at)) >= 0:
        mark = struct.unpack_from("B", data, at + 1)[0]
        if mark in _FRAMES:
            height, width = struct.unpack_from(">HH", data, at + 5)
            return width, height
        if mark in (0xD9, 0xDA):  # the end, or pixels before any size
            return None
        alone = mark in (0x00, 0x01, 0xFF) or 0xD0 <= mark <= 0xD8
        at += (1 if mark == 0xFF else 2) if alone else 2 + max(2, struct.unpack_from(">H", data, at + 2)[0])
    return None


def _of_bmp(data: bytes) -> Size:
    old = struct.unpack_from("<I", data, 14)[0] == 12
    width, height = struct.unpack_from("<HH" if old else "<ii", data, 18)
    return width, abs(height)  # from the top where it is negative


def _of_gif(data: bytes) -> Size:
    width, height = struct.unpack_from("<HH", data, 6)
    return width, height


def _of_tiff(data: bytes) -> Size:
    """The decoder turns a picture by its orientation."""
    tags = tiff_tags(data, {_ORIENTATION, _WIDTH, _HEIGHT})
    if _WIDTH not in tags or _HEIGHT not in tags:
        return None
    width, height = int(tags[_WIDTH]), int(tags[_HEIGHT])
    return (height, width) if 5 <= tags.get(_ORIENTATION, 1) <= 8 else (width, height)


def _of_webp(data: bytes) -> Size:
    name = data[12:16]
    if data[8:12] != b"WEBP":
        return None
    if name == b"VP8X":
        wide, high = data[24:27], data[27:30]
        return (int.from_bytes(wide, "little") + 1, int.from_bytes(high, "little") + 1) if len(high) == 3 else None
    if name == b"VP8L":
        bits = struct.unpack_from("<I", data, 21)[0]
        return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    width, height = struct.unpack_from("<HH", data, 26)
    return (width & 0x3FFF, height & 0x3FFF) if name == b"VP8 " else None


def _of_pnm(data: bytes) -> Size:
    found = _PNM.match(data, 0, LONGEST_HEAD)
    return None if found is None else (int(found[1]), int(found[2]))


_HEADS: tuple[tuple[bytes, str, Callable[[bytes], Size]], ...] = (
    (PNG_START, "PNG", _of_png),
    (JPEG_START, "JPEG", _of_jpeg),
    (b"BM", "BMP", _of_bmp),
    (b"GIF8", "GIF", _of_gif),
    (b"II*\0", "TIFF", _of_tiff),
    (b"MM\0*", "TIFF", _of_tiff),
    (b"RIFF", "WebP", _of_webp),
    (b"P", "PNM", _of_pnm),
)
