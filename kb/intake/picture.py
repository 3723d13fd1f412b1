"""Image files' bytes, held as they are and decoded only where they must be.

Vocabulary: ``Picture``, an image file, ``Picture("png", data)``.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.files.mesh_textures import textures_in

MAGIC = {b"\x89PNG": "png", b"\xff\xd8\xff": "jpg", b"BM": "bmp", b"RIFF": "webp", b"II*\0": "tif", b"MM\0*": "tif"}
PLAIN = ("png", "jpg")
"""What is kept as it is; every other kind becomes a PNG."""


@dataclass(frozen=True)
class Picture:
    """An image file: its ``suffix``, png or jpg or whatever it is, and its bytes."""

    suffix: str
    data: bytes


def picture_from(data: bytes) -> Picture | None:
    """The picture of an image file's bytes; None where they do not begin like one, or OpenCV cannot read them."""
    suffix = next((kind for magic, kind in MAGIC.items() if data.startswith(magic)), None)
    found = pixels(data) if suffix is not None else None
    if suffix is None or found is None:
        return None
    return Picture(suffix, data) if suffix in PLAIN else png(found)


def pixels(data: bytes) -> NDArray[np.uint8] | None:
    """The pixels (H, W, 3) uint8, blue first; None where OpenCV cannot read the bytes."""
    import cv2

    try:
        found: Any = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error:
        return None
    return None if found is None else np.asarray(found, dtype=np.uint8)


def png(image: NDArray[np.uint8]) -> Picture:
    """A PNG of pixels (H, W, 3), blue first."""
    import cv2

    return Picture("png", cv2.imencode(".png", image)[1].tobytes())


def textures_of(path: Path) -> tuple[dict[str, Picture], list[str]]:
    """The pictures by name of material, '' meaning every material, and a note on each that is missing."""
    found, notes = textures_in(path)
    pictures = {}
    for texture in found:
        picture = picture_from(texture.data) if texture.data is not None else None
        if picture is None:
            notes.append(f"the {texture.label} is missing or no picture: going on without")
        else:
            pictures[texture.material] = picture
    return pictures, list(dict.fromkeys(notes))
