"""Reading an image file to pixels: 8 bits, three channels, blue first.

=====================  =======================================================================
the file's pixels      what becomes of them
=====================  =======================================================================
8 bits, colour         as they are; a palette is looked up
grey, 1 bit            three equal channels
with transparency      the alpha channel is dropped
16 bits                scaled by the smallest range that holds them: 255, 1023, 4095, 16383 or
                       65535 becomes 255; one factor for the whole image, so ratios stay
floating point         refused
=====================  =======================================================================

Whether an image file's bytes are whole, and how large it is, is told before they are decoded: decoders fill in what is
missing, and reserve what is claimed. What a decoder calls corrupt is refused.
"""

import logging
import os
import re
import struct
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from geometry.diverted import DIVERTED
from geometry.files.plain_files import content_of
from sensing.errors import ImageError
from sensing.files.picture_heads import JPEG_START, KINDS, PNG_START, head_of

MAX_PIXELS = 200_000_000
"""No image may have more."""
MAX_SCANNED = 10 * MAX_PIXELS
"""Pixels of all the scans of a JPEG: cameras and programs write ten at most, a file could have thousands."""
_CORRUPT = re.compile(r"(Corrupt JPEG data|Premature end of JPEG|Inconsistent progression)(?!.* before marker 0xd9).*")
"""What libjpeg says of a picture that it fills up by guess; bytes before the end's marker are sent by many cameras."""

_LOG = logging.getLogger("plogic.sensing")
MAX_BYTES = 256 * 1024 * 1024
"""No image file may be larger than this."""
_RANGES = (255, 1023, 4095, 16383, 65535)
"""Greatest values of sensors of 8 to 16 bits, whose numbers are stored in 16."""


def read_image(path: str | Path) -> NDArray[np.uint8]:
    """Read an image file to (H, W, 3) uint8, blue first.

    What is converted (see the module) is said in the log (``plogic.sensing``, INFO). An orientation tag is not applied:
    the camera's K speaks of the stored pixels; but of TIFF, whose decoder turns them as it reads.

    Raises:
        ImageError: No such file, not an image, damaged or cut off, too large, or of floating-point numbers.
    """
    return image_from(content_of(path, MAX_BYTES, ImageError), path)


def image_from(data: bytes, name: str | Path) -> NDArray[np.uint8]:
    """The same from an image file's bytes; ``name`` is what errors call it. Raises ImageError."""
    width, height = size_of(data, name)
    pixels, said = _decoded(data)
    if pixels is None:
        raise ImageError(f"{name}: is not an image that OpenCV can read ({len(data)} bytes)")
    if (corrupt := _CORRUPT.search(said)) is not None:
        raise ImageError(f"{name}: the file is damaged: {corrupt[0]:.100}")
    if pixels.shape[:2] != (height, width):
        held = f"{pixels.shape[1]}x{pixels.shape[0]}"
        raise ImageError(f"{name}: the file is damaged: it says that it has {width}x{height} pixels, and holds {held}")
    return _as_bgr(pixels, name)


def size_of(data: bytes, name: str | Path) -> tuple[int, int]:
    """Width and height, pixels, of an image file's bytes, which are not decoded.

    Raises:
        ImageError: No image, damaged or cut off as far as it shows, or too large.
    """
    head, wrong = head_of(data), damage(data)
    if wrong is not None:
        raise ImageError(f"{name}: {wrong}")
    if head is None:
        raise ImageError(f"{name}: is not an image that can be read ({len(data)} bytes): {KINDS} are")
    size, scans = f"{head.width}x{head.height}", data.count(b"\xff\xda") if head.kind == "JPEG" else 1
    if not 0 < head.width * head.height <= MAX_PIXELS:
        raise ImageError(f"{name}: the {head.kind} file says that it has {size} pixels, not 1 to {MAX_PIXELS}")
    if head.width * head.height * scans > MAX_SCANNED:
        raise ImageError(f"{name}: the JPEG file has {scans} scans of {size} pixels, more than {MAX_SCANNED} in all")
    return head.width, head.height


def _decoded(data: bytes) -> tuple[NDArray[Any] | None, str]:
    """The file's own pixels, or None where OpenCV cannot tell, and what the decoder said, which nobody sees."""
    import cv2

    log: Any = cv2 if hasattr(cv2, "setLogLevel") else cv2.utils.logging  # OpenCV 4, OpenCV 5
    with _said() as said:
        level = log.getLogLevel()
        log.setLogLevel(0)
        try:
            pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        except (cv2.error, MemoryError):
            pixels = None
        finally:
            log.setLogLevel(level)
    return None if pixels is None else np.asarray(pixels), "".join(said)


@contextmanager
def _said() -> Iterator[list[str]]:
    """Hold back what decoders, which know no other way, write to standard error; it is in the list afterwards.

    Where there is no standard error, or no room for what is held back, nothing is.
    """
    said: list[str] = []
    with DIVERTED, ExitStack() as stack:
        with suppress(OSError):
            held = stack.enter_context(tempfile.TemporaryFile())
            kept = os.dup(2)
            stack.callback(_given_back, kept, held, said)
            os.dup2(held.fileno(), 2)
        yield said


def _given_back(kept: int, held: IO[bytes], said: list[str]) -> None:
    os.dup2(kept, 2)
    os.close(kept)
    held.seek(0)
    said.append(held.read().decode(errors="replace"))


def _as_bgr(pixels: NDArray[Any], path: str | Path) -> NDArray[np.uint8]:
    if pixels.dtype == np.uint16:
        pixels = _to_eight_bits(pixels, path)
    if pixels.dtype != np.uint8:
        raise ImageError(f"{path}: its pixels are {pixels.dtype}; only images of 8 or 16 bits a channel are read")
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    if channels == 3:
        return pixels
    if channels == 1:
        _LOG.info("%s: grey, read as three equal channels", path)
        return np.repeat(pixels.reshape(*pixels.shape[:2], 1), 3, axis=2)
    if channels == 4:
        _LOG.info("%s: the alpha channel is dropped", path)
        return np.ascontiguousarray(pixels[:, :, :3])
    raise ImageError(f"{path}: has {channels} channels; 1, 3 or 4 can be read")


def _to_eight_bits(pixels: NDArray[np.uint16], path: str | Path) -> NDArray[np.uint8]:
    colour = pixels[:, :, :3] if pixels.ndim == 3 else pixels
    greatest = next(r for r in _RANGES if int(colour.max()) <= r)
    _LOG.info("%s: 16 bits a channel, 0 to %d scaled to 0 to 255", path, greatest)
    return np.asarray(np.rint(np.minimum(pixels, greatest) * (255.0 / greatest)), np.uint8)


def damage(data: bytes) -> str | None:
    """What is wrong with a file's bytes as one clause.

    None where nothing shows, which is all that can be said of kinds other than PNG and JPEG.
    """
    if not data:
        return "is empty"
    if data.startswith(JPEG_START):
        return None if b"\xff\xd9" in data[-4096:] else f"the JPEG file is cut off after {len(data)} bytes"
    return _png_damage(data) if data.startswith(PNG_START) else None


def _png_damage(data: bytes) -> str | None:
    """As ``damage``: a PNG is a chain of chunks, each with its length, its name and a checksum, from IHDR to IEND."""
    at, name = len(PNG_START), b""
    while name != b"IEND":
        if at + 12 > len(data):
            return f"the PNG file is cut off after {len(data)} bytes"
        size, name = struct.unpack_from(">I4s", data, at)
        if at == len(PNG_START) and (wrong := _header_damage(data, size, name)):
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
    if len(data) < len(PNG_START) + 16:
        return f"the PNG file is cut off after {len(data)} bytes"
    return None
