"""What a picture's EXIF says of the camera that took it: the few tags of focal length, size and orientation.

EXIF is a small TIFF file within JPEG (APP1), PNG (eXIf) and WebP (EXIF); a TIFF picture has the tags itself. Files come
from strangers: no offset is trusted, two directories are read and no third, what makes no sense counts as not there.

* ``Exif(equivalent_mm=28.0, size=(4000, 3000))``
"""

import struct
from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from math import isfinite
from typing import NamedTuple

from geometry.field_of_view import focal_equivalent

_ORIENTATION, _DIRECTORY, _FOCAL, _WIDTH, _HEIGHT = 0x0112, 0x8769, 0x920A, 0xA002, 0xA003
_PLANE_RESOLUTION, _PLANE_UNIT, _EQUIVALENT = 0xA20E, 0xA210, 0xA405
_WANTED = {_ORIENTATION, _DIRECTORY, _FOCAL, _WIDTH, _HEIGHT, _PLANE_RESOLUTION, _PLANE_UNIT, _EQUIVALENT}
_UNITS = {2: 25.4, 3: 10.0, 4: 1.0, 5: 1e-3}  # mm of FocalPlaneResolutionUnit; inch where it is not stated
_NUMBERS = {3: "H", 4: "I", 5: "II", 11: "f", 12: "d"}  # SHORT, LONG, RATIONAL; FLOAT and DOUBLE, as Pillow writes too
_MARK = b"Exif\x00\x00"
_PLAUSIBLE = 4.0, 4000.0  # mm equivalent: from a fisheye to the longest zoom; no lens is beyond
MOST_ENTRIES = 512
"""Tags of a directory that are read; a camera writes some sixty."""
SAME_SHAPE = 0.01
"""How far two ratios of width to height may differ and count as one: a scaled side is rounded to a pixel."""


class Exif(NamedTuple):
    """What is not stated is None.

    ``equivalent_mm``: FocalLengthIn35mmFilm. ``focal_mm`` and ``px_per_mm``: the lens, and the sensor's pixels.
    ``size``: (width, height) as the camera stored the picture. ``orientation``: 1 to 8 of the pixels that are read, 1
    upright.
    """

    equivalent_mm: float | None = None
    focal_mm: float | None = None
    px_per_mm: float | None = None
    size: tuple[int, int] | None = None
    orientation: int = 1


class Guess(NamedTuple):
    """A focal length, px, and what it was made of: ``28 mm equivalent``."""

    f: float
    source: str


def exif_of(data: bytes) -> Exif:
    """What the bytes of a picture say; nothing where there is no EXIF, or none that can be read. Raises nothing."""
    for block in _blocks(data):
        tags = _Tags(block, _WANTED).read()
        if tags:
            found = _exif(tags)
            return found._replace(orientation=1) if block is data else found  # OpenCV turns a TIFF as it decodes it
    return Exif()


def focal_guess(exif: Exif, size: tuple[int, int]) -> Guess | None:
    """The focal length of a picture of ``size`` (width, height) as it is now; None where EXIF does not tell it.

    A picture of another shape than the camera stored was cut, and what was cut off is not known: None.
    """
    if is_cut(exif, size):
        return None
    if exif.equivalent_mm is not None:
        return Guess(focal_equivalent(size, exif.equivalent_mm), f"{exif.equivalent_mm:g} mm equivalent")
    if exif.focal_mm is None or exif.px_per_mm is None:
        return None
    f = exif.focal_mm * exif.px_per_mm * (1.0 if exif.size is None else max(size) / max(exif.size))
    shortest, longest = (focal_equivalent(size, mm) for mm in _PLAUSIBLE)
    if not shortest <= f <= longest:
        return None
    return Guess(f, f"{exif.focal_mm:g} mm on a sensor of {exif.px_per_mm:.4g} px/mm")


def is_cut(exif: Exif, size: tuple[int, int]) -> bool:
    """Whether a picture of ``size`` has another shape, upright or lying, than the camera stored."""
    if exif.size is None:
        return False
    ratio, stored = (max(sides) / min(sides) for sides in (size, exif.size))
    return abs(ratio / stored - 1.0) > SAME_SHAPE


def _exif(tags: dict[int, float]) -> Exif:
    equivalent, focal, resolution = (_positive(tags.get(tag)) for tag in (_EQUIVALENT, _FOCAL, _PLANE_RESOLUTION))
    unit = _UNITS.get(int(tags.get(_PLANE_UNIT, 2)))
    width, height = (int(tags.get(tag, 0)) for tag in (_WIDTH, _HEIGHT))
    turn = int(tags.get(_ORIENTATION, 1))
    return Exif(
        equivalent if equivalent is not None and _PLAUSIBLE[0] <= equivalent <= _PLAUSIBLE[1] else None,
        focal,
        None if resolution is None or unit is None else resolution / unit,
        (width, height) if width > 0 and height > 0 else None,
        turn if 1 <= turn <= 8 else 1,
    )


def _positive(value: float | None) -> float | None:
    return value if value is not None and value > 0 else None


def tiff_tags(tiff: bytes, wanted: AbstractSet[int]) -> dict[int, float]:
    """The wanted tags of a TIFF's first directory, of one number each; none where it is no TIFF. Raises nothing."""
    return _Tags(tiff, wanted).first()


class _Tags:
    """The wanted tags of a TIFF's first directory and of its EXIF directory, as numbers."""

    def __init__(self, tiff: bytes, wanted: AbstractSet[int]) -> None:
        self._tiff, self._order = tiff, {b"II*\x00": "<", b"MM\x00*": ">"}.get(tiff[:4], "")
        self._wanted = wanted

    def first(self) -> dict[int, float]:
        """Those of the first directory, by tag; empty where the block is no TIFF."""
        return self._directory(self._number("I", 4) if self._order else None)

    def read(self) -> dict[int, float]:
        """Those of both."""
        tags = self.first()
        return tags | self._directory(tags.get(_DIRECTORY))

    def _directory(self, at: float | None) -> dict[int, float]:
        if at is None or (count := self._number("H", int(at))) is None:
            return {}
        places = (int(at) + 2 + 12 * n for n in range(min(int(count), MOST_ENTRIES)))
        entries = ((self._number("H", place), self._value(place)) for place in places)
        return {
            int(tag): value for tag, value in entries if tag in self._wanted and tag is not None and value is not None
        }

    def _value(self, place: int) -> float | None:
        """The one number of an entry; None of another type, of several, or past the end."""
        kind, count = self._number("H", place + 2), self._number("I", place + 4)
        shape = _NUMBERS.get(int(kind)) if kind is not None else None
        if shape is None or count != 1:
            return None
        at = self._number("I", place + 8) if struct.calcsize("=" + shape) > 4 else place + 8
        return None if at is None else self._number(shape, int(at))

    def _number(self, shape: str, at: int) -> float | None:
        if at < 0 or at + struct.calcsize("=" + shape) > len(self._tiff):
            return None
        number, *below = struct.unpack_from(self._order + shape, self._tiff, at)
        if below and below[0] == 0:
            return None
        value = float(number / below[0] if below else number)
        return value if isfinite(value) else None


def _blocks(data: bytes) -> Iterator[bytes]:
    """The EXIF blocks of a picture's file."""
    if data.startswith(b"\xff\xd8"):
        yield from (body[len(_MARK) :] for body in _of_jpeg(data) if body.startswith(_MARK))
    elif data.startswith(b"\x89PNG\r\n\x1a\n"):
        yield from _of_chunks(data, 8, ">", b"eXIf")
    elif data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        yield from (body.removeprefix(_MARK) for body in _of_chunks(data, 12, "<", b"EXIF"))
    elif data[:4] in (b"II*\x00", b"MM\x00*"):
        yield data


def _of_jpeg(data: bytes) -> Iterator[bytes]:
    """The APP1 segments before the picture itself begins."""
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF and data[at + 1] != 0xDA:
        if data[at + 1] == 0xFF:  # filling
            at += 1
            continue
        (size,) = struct.unpack_from(">H", data, at + 2)
        if data[at + 1] == 0xE1:
            yield data[at + 4 : at + 2 + size]
        at += 2 + max(size, 2)


def _of_chunks(data: bytes, at: int, order: str, wanted: bytes) -> Iterator[bytes]:
    """The bodies of chunks called ``wanted``: PNG's have size, name, body, checksum, and RIFF's name, size, body."""
    png = order == ">"
    while at + 8 <= len(data):
        (size,) = struct.unpack_from(f"{order}I", data, at + (0 if png else 4))
        name = at + (4 if png else 0)
        if data[name : name + 4] == wanted:
            yield data[at + 8 : at + 8 + size]
        at += 8 + size + (4 if png else size % 2)
