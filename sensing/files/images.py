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
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sensing.errors import ImageError
from sensing.files.image_bytes import damage

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LOG = logging.getLogger("plogic.sensing")
MAX_BYTES = 256 * 1024 * 1024
"""No image file may be larger than this."""
_RANGES = (255, 1023, 4095, 16383, 65535)
"""Greatest values of sensors of 8 to 16 bits, whose numbers are stored in 16."""


def read_image(path: str | Path) -> NDArray[np.uint8]:
    """Read an image file to (H, W, 3) uint8, blue first.

    What is converted (see the module) is said in the log (``plogic.sensing``, INFO). An orientation tag is not applied:
    the camera's K speaks of the stored pixels.

    Raises:
        ImageError: No such file, not an image, damaged or cut off, too large, or of floating-point numbers.
    """
    return image_from(_bytes(Path(path)), path)


def image_from(data: bytes, name: str | Path) -> NDArray[np.uint8]:
    """The same from an image file's bytes; ``name`` is what errors call it. Raises ImageError."""
    wrong = damage(data)
    if wrong is not None:
        raise ImageError(f"{name}: {wrong}")
    pixels = _decoded(data)
    if pixels is None:
        raise ImageError(f"{name}: is not an image that OpenCV can read ({len(data)} bytes)")
    return _as_bgr(pixels, name)


def _decoded(data: bytes) -> NDArray[Any] | None:
    """The file's own pixels, or None where OpenCV cannot tell; what it says on standard error is held back."""
    import cv2

    log: Any = cv2 if hasattr(cv2, "setLogLevel") else cv2.utils.logging  # OpenCV 4, OpenCV 5
    level = log.getLogLevel()
    log.setLogLevel(0)
    try:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return None
    finally:
        log.setLogLevel(level)
    return None if pixels is None else np.asarray(pixels)


def _bytes(path: Path) -> bytes:
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise ImageError(f"{path}: {size} bytes is more than the {MAX_BYTES} that an image may have")
        return path.read_bytes()
    except OSError as error:
        raise ImageError(f"{path}: cannot be read: {error.strerror}") from None


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
