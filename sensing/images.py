"""Reading an image file to pixels: 8 bits, three channels, blue first."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sensing.errors import ImageError

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LOG = logging.getLogger("plogic.sensing")
_ENDINGS = {b"\x89PNG": (b"IEND\xaeB`\x82", "PNG"), b"\xff\xd8\xff": (b"\xff\xd9", "JPEG")}
MAX_BYTES = 256 * 1024 * 1024
"""No image file may be larger than this."""


def read_image(path: str | Path) -> NDArray[np.uint8]:
    """Read an image file to (H, W, 3) uint8, blue first.

    A grey image becomes three equal channels and an alpha channel is dropped; either is said in the log (``plogic.sensing``, INFO). An
    orientation tag is not applied: the camera's K speaks of the stored pixels.

    Raises:
        ImageError: No such file, not an image, cut off, or not 8 bits a channel.
    """
    import cv2

    data = _bytes(Path(path))
    try:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        pixels = None
    if pixels is None:
        raise ImageError(f"{path}: is not an image that OpenCV can read ({len(data)} bytes)")
    return _as_bgr(np.asarray(pixels), path)


def _bytes(path: Path) -> bytes:
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise ImageError(f"{path}: {size} bytes is more than the {MAX_BYTES} that an image may have")
        data = path.read_bytes()
    except OSError as error:
        raise ImageError(f"{path}: cannot be read: {error.strerror}") from None
    for start, (end, kind) in _ENDINGS.items():
        if data.startswith(start) and end not in data[-4096:]:
            raise ImageError(f"{path}: the {kind} file is cut off after {len(data)} bytes")
    if not data:
        raise ImageError(f"{path}: is empty")
    return data


def _as_bgr(pixels: NDArray[Any], path: str | Path) -> NDArray[np.uint8]:
    if pixels.dtype != np.uint8:
        raise ImageError(f"{path}: has {pixels.dtype.itemsize * 8} bits a channel ({pixels.dtype}); only 8-bit images are read")
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
