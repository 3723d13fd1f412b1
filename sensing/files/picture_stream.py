"""Pictures that come one after the other from a stream, as ``ffmpeg -f image2pipe`` and MJPEG cameras send them.

JPEG, PNG, and PNM as ``-c:v ppm`` writes it: each says itself where it ends, and all of a stream are of the first one's
kind. What stands between two, as the heads of HTTP's multipart streams do, is passed over; so is the rest of a damaged
one.

* ``for data in pictures_in(sys.stdin.buffer, "<stdin>"): image_from(data, "<stdin>")``
"""

import re
import struct
from collections.abc import Iterator
from typing import Protocol

from sensing.errors import ImageError
from sensing.files.images import MAX_BYTES

BETWEEN = 16 * 2**20
"""Bytes between two pictures that are passed over."""
PIECE = 2**20
"""Bytes that are asked for at a time; what has come by then is taken."""
_PNG, _JPEG, _PNM = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"P"
_STARTS = {_PNG: re.compile(re.escape(_PNG)), _JPEG: re.compile(re.escape(_JPEG)), _PNM: re.compile(rb"P[56]\s")}
_FIRST = re.compile(b"|".join(start.pattern for start in _STARTS.values()))
_PNM_HEAD = re.compile(rb"P([56])\s+(\d{1,6})\s+(\d{1,6})\s+(\d{1,5})\s")
_MARKER = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]")
"""What ends the coded pixels of a JPEG: all but a coded 255, a restart, and filling."""
_LONGEST_START, _LONGEST_HEAD = len(_PNG), 64
_CONTAINERS = {b"\x1aE\xdf\xa3": "Matroska", b"RIFF": "AVI", b"FLV": "FLV", b"OggS": "Ogg", b"YUV4MPEG2": "YUV4MPEG"}
REMEDY = "send its frames as pictures: ffmpeg -i INPUT -f image2pipe -c:v ppm -"


class Stream(Protocol):
    """What bytes come from."""

    def read1(self, size: int, /) -> bytes:
        """At most so many bytes, as soon as there are some; none at the end."""


def pictures_in(stream: Stream, name: str) -> Iterator[bytes]:
    """The bytes of each picture, whole or as far as they came; ``name`` is what errors call the stream.

    Raises:
        ImageError: It is a video's container, no picture begins within ``BETWEEN`` bytes, or one is too large.
    """
    come = _Come(stream, name)
    while come.to_start():
        yield come.picture()


class _Come:
    """The bytes that have come and belong to no picture yet."""

    def __init__(self, stream: Stream, name: str) -> None:
        self._stream, self._name, self._data, self._number = stream, name, bytearray(), 0
        self._start = _FIRST
        self._has(_LONGEST_START + 4)
        kind = next((kind for start, kind in _CONTAINERS.items() if self._data.startswith(start)), None)
        kind = "MP4" if self._data[4:8] == b"ftyp" else kind
        if kind is not None:
            raise ImageError(f"{name}: is a video ({kind}) and no stream of pictures: {REMEDY}")

    def to_start(self) -> bool:
        """Drop what stands before the next picture; False where the stream ends first."""
        passed = 0
        while (found := self._start.search(self._data)) is None and passed <= BETWEEN:
            drop = max(0, len(self._data) - _LONGEST_START + 1)
            passed += drop
            del self._data[:drop]
            if not self._more():
                if self._number == 0 and passed + len(self._data):
                    raise ImageError(f"{self._name}: has no JPEG, PNG or PNM picture: {REMEDY}")
                return False
        if found is None:
            after = f" after {self._number} pictures" if self._number else ""
            raise ImageError(f"{self._name}: has no JPEG, PNG or PNM picture within {BETWEEN} bytes{after}: {REMEDY}")
        del self._data[: found.start()]
        return True

    def picture(self) -> bytes:
        """The picture that the bytes begin with."""
        self._number += 1
        kind = next(start for start in _STARTS if self._data.startswith(start))
        self._start = _STARTS[kind]
        end = {_PNG: self._end_of_png, _JPEG: self._end_of_jpeg, _PNM: self._end_of_pnm}[kind]()
        picture = bytes(self._data[:end])
        del self._data[:end]
        return picture

    def _end_of_png(self) -> int:
        """A chain of chunks; where a name is none, the chain is damaged there."""
        at, name = len(_PNG), b""
        while name != b"IEND" and self._has(at + 8):
            size, name = struct.unpack_from(">I4s", self._data, at)
            if not name.isalpha():
                break
            at += 12 + size
        self._has(at)
        return at

    def _end_of_jpeg(self) -> int:
        """Segments, and the coded pixels after each start of a scan, up to the end's marker or the next picture's."""
        at = 2
        while self._has(at + 4) or len(self._data) >= at + 2:
            mark, segment = self._data[at : at + 2], self._data[at : at + 4]
            if mark == b"\xff\xd9":
                return at + 2
            if mark[:1] != b"\xff" or len(segment) < 4:
                return self._after_pixels(at)
            if mark == b"\xff\xd8":
                return at
            at += 1 if mark[1] == 0xFF else 2 + max(2, int.from_bytes(segment[2:]))
            if mark[1] == 0xDA:
                at = self._after_pixels(at)
        return at

    def _after_pixels(self, at: int) -> int:
        """Where the marker stands that ends the coded pixels from ``at`` on."""
        while (found := _MARKER.search(self._data, at)) is None:
            at = max(at, len(self._data) - 1)
            if not self._has(len(self._data) + 1):
                return len(self._data)
        return found.start()

    def _end_of_pnm(self) -> int:
        self._has(_LONGEST_HEAD)
        head = _PNM_HEAD.match(self._data)
        if head is None:
            return len(_PNM)
        kind, width, height, most = map(int, head.groups())
        end = head.end() + width * height * (3 if kind == 6 else 1) * (2 if most > 255 else 1)
        self._has(end)
        return end

    def _has(self, number: int) -> bool:
        """Whether there are so many bytes, which are waited for."""
        if number > MAX_BYTES:
            raise ImageError(
                f"{self._name}: picture {self._number - 1} has more than the {MAX_BYTES} bytes that are read"
            )
        while len(self._data) < number:
            if not self._more():
                return False
        return True

    def _more(self) -> bool:
        piece = self._stream.read1(PIECE)
        self._data += piece
        return bool(piece)
