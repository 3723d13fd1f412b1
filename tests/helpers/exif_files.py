"""Pictures with EXIF, made byte by byte: ``jpeg(pixels, exif({EQUIVALENT: 28}))``."""

from __future__ import annotations

import struct
import zlib

import cv2
import numpy as np

ORIENTATION, DIRECTORY, FOCAL, WIDTH, HEIGHT = 0x0112, 0x8769, 0x920A, 0xA002, 0xA003
RESOLUTION, UNIT, EQUIVALENT = 0xA20E, 0xA210, 0xA405
SHORT, LONG, RATIONAL = 3, 4, 5


def exif(inner, first=None, order="<"):
    """A TIFF of two directories: numbers are SHORT up to 65535, and pairs are RATIONAL."""
    first = {**(first or {}), DIRECTORY: 0}
    start = 8 + 2 + 12 * len(first) + 4
    at = start + 8 * sum(isinstance(value, tuple) for value in first.values())
    first[DIRECTORY] = at
    head = (b"II*\x00" if order == "<" else b"MM\x00*") + struct.pack(order + "I", 8)
    return head + _directory(first, 8, order) + _directory(inner, at, order)


def _directory(tags, at, order):
    spare = at + 2 + 12 * len(tags) + 4
    entries, pairs = b"", b""
    for tag, value in sorted(tags.items()):
        kind = RATIONAL if isinstance(value, tuple) else LONG if tag == DIRECTORY or value > 65535 else SHORT
        if kind == RATIONAL:
            stored = struct.pack(order + "I", spare + len(pairs))
            pairs += struct.pack(order + "II", *value)
        else:
            stored = struct.pack(order + ("I" if kind == LONG else "HH"), *([value] if kind == LONG else [value, 0]))
        entries += struct.pack(order + "HHI", tag, kind, 1) + stored
    return struct.pack(order + "H", len(tags)) + entries + b"\x00" * 4 + pairs


def tiff(pixels, orientation):
    """A TIFF of grey pixels (H, W), with its orientation tag."""
    (height, width), at = pixels.shape, 8 + 2 + 12 * 9 + 4
    tags = {
        256: width,
        257: height,
        258: 8,
        259: 1,
        262: 1,
        273: at,
        ORIENTATION: orientation,
        278: height,
        279: pixels.size,
    }
    return b"II*\x00" + struct.pack("<I", 8) + _directory(tags, 8, "<") + pixels.tobytes()


def grey(width, height):
    return np.full((height, width, 3), 90, np.uint8)


def jpeg(pixels, block):
    whole = cv2.imencode(".jpg", pixels)[1].tobytes()
    body = b"Exif\x00\x00" + block
    return whole[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + whole[2:]


def png(pixels, block):
    whole = cv2.imencode(".png", pixels)[1].tobytes()
    name = b"eXIf" + block
    chunk = struct.pack(">I", len(block)) + name + struct.pack(">I", zlib.crc32(name))
    return whole[:33] + chunk + whole[33:]


def webp(pixels, block):
    whole = cv2.imencode(".webp", pixels)[1].tobytes()
    body = whole[12:] + b"EXIF" + struct.pack("<I", len(block)) + block + b"\x00" * (len(block) % 2)
    return b"RIFF" + struct.pack("<I", len(body) + 4) + b"WEBP" + body
