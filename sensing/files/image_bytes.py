"""Whether an image file's bytes are whole, told before they are decoded: decoders fill in what is missing, or complain on standard error."""

from __future__ import annotations

import struct
import zlib

MAX_PIXELS = 200_000_000
"""No image may have more; a PNG of a few bytes can claim any number."""
_PNG, _JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"


def damage(data: bytes) -> str | None:
    """What is wrong with a file's bytes as one clause; None where nothing shows, which is all that can be said of kinds other than PNG and JPEG."""
    if not data:
        return "is empty"
    if data.startswith(_JPEG):
        return None if b"\xff\xd9" in data[-4096:] else f"the JPEG file is cut off after {len(data)} bytes"
    return _png_damage(data) if data.startswith(_PNG) else None


def _png_damage(data: bytes) -> str | None:
    """As ``damage``: a PNG is a chain of chunks, each with its length, its name and a checksum, from IHDR to IEND."""
    at, name = len(_PNG), b""
    while name != b"IEND":
        if at + 12 > len(data):
            return f"the PNG file is cut off after {len(data)} bytes"
        size, name = struct.unpack_from(">I4s", data, at)
        if at == len(_PNG) and (wrong := _header_damage(data, size, name)):
            return wrong
        if at + 12 + size > len(data):
            return f"the PNG file is cut off after {len(data)} bytes"
        body = memoryview(data)[at + 4 : at + 8 + size]
        if zlib.crc32(body) != struct.unpack_from(">I", data, at + 8 + size)[0]:
            return f"the PNG file is damaged: the checksum of the part at byte {at} is wrong"
        at += 12 + size
    return None


def _header_damage(data: bytes, size: int, name: bytes) -> str | None:
    if name != b"IHDR" or size != 13:
        return "the PNG file is damaged: it does not begin with its header"
    if len(data) < len(_PNG) + 16:
        return f"the PNG file is cut off after {len(data)} bytes"
    width, height = struct.unpack_from(">II", data, len(_PNG) + 8)
    if not 0 < width * height <= MAX_PIXELS:
        return f"the PNG file says that it has {width}x{height} pixels, not 1 to {MAX_PIXELS}"
    return None
