"""Cameras of COLMAP: `cameras.txt` or `cameras.bin`, alone or in the folder of a reconstruction.

| file | what is read |
|---|---|
| `cameras.txt` | `CAMERA_ID MODEL WIDTH HEIGHT PARAMS...` a line |
| `cameras.bin` | the number of cameras, and each as id, model, width, height, parameters; little-endian |
| `images.txt`, `images.bin` beside them | which camera took the picture of a name |

A pixel's centre is at .5 there and at .0 here: half a pixel is taken from the principal point. Poses are not read, for
they have no scale. In a folder the binary files go first, as COLMAP itself has it; the folder of a project or of an
undistorted workspace stands for its `sparse/0` or `sparse`.
"""

import re
import struct
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO, NamedTuple

from geometry.errors import CameraError
from geometry.files.plain_files import IS_FOLDER, fault_of

MAX_IMAGES = 4 * 2**30
"""Bytes of a file of images, of which only the names are kept."""
MOST_NAMED = 1_000_000
"""Pictures of a reconstruction."""
LONGEST = 4096
"""Bytes of a picture's name, and of a line that holds one."""
PLACES = "", "sparse/0", "sparse"
"""Where a folder has its cameras."""
_LINE = re.compile(r"\s*\d+\s+[A-Z_0-9]+\s+\d+\s+\d+\s")
MODELS = {  # COLMAP's parameters by our names; f is both focal lengths
    "SIMPLE_PINHOLE": "f cx cy",
    "PINHOLE": "fx fy cx cy",
    "SIMPLE_RADIAL": "f cx cy k1",
    "RADIAL": "f cx cy k1 k2",
    "OPENCV": "fx fy cx cy k1 k2 p1 p2",
    "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6",
}
_NUMBERED = {  # COLMAP's numbers of models, and how many parameters each has
    0: ("SIMPLE_PINHOLE", 3),
    1: ("PINHOLE", 4),
    2: ("SIMPLE_RADIAL", 4),
    3: ("RADIAL", 5),
    4: ("OPENCV", 8),
    5: ("OPENCV_FISHEYE", 8),
    6: ("FULL_OPENCV", 12),
    7: ("FOV", 5),
    8: ("SIMPLE_RADIAL_FISHEYE", 4),
    9: ("RADIAL_FISHEYE", 5),
    10: ("THIN_PRISM_FISHEYE", 12),
    11: ("RAD_TAN_THIN_PRISM_FISHEYE", 16),
    12: ("SIMPLE_DIVISION", 4),
    13: ("DIVISION", 5),
    14: ("SIMPLE_FISHEYE", 3),
    15: ("FISHEYE", 4),
    16: ("EUCM", 6),
    17: ("EQUIRECTANGULAR", 2),
}


class Stated(NamedTuple):
    """One camera as its file states it: the words after its id; ``line`` of a text."""

    model: str
    width: str | int
    height: str | int
    parameters: tuple[str | float, ...]
    line: int | None = None

    def described(self) -> dict[str, Any]:
        """The contract's `camera` key. Raises CameraError for a model that we have not, or wrong numbers."""
        if self.model not in MODELS:
            what = f"COLMAP's model must be one of {', '.join(MODELS)}, not {self.model:.40}"
            raise CameraError(
                f"{what}: undistort with colmap image_undistorter, whose cameras are PINHOLE", line=self.line
            )
        names = MODELS[self.model].split()
        try:
            width, height = int(self.width), int(self.height)
            values = dict(zip(names, map(float, self.parameters), strict=True))
        except ValueError as error:
            rule = f"{self.model} must be followed by width, height, {', '.join(names)}"
            raise CameraError(rule, line=self.line) from error
        fx, fy = values.get("fx", values.get("f", 0.0)), values.get("fy", values.get("f", 0.0))
        lens = [values.get(name, 0.0) for name in ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")]
        K = [[fx, 0, values["cx"] - 0.5], [0, fy, values["cy"] - 0.5], [0, 0, 1]]
        return {"width": width, "height": height, "K": K, "dist": lens if any(lens) else []}


def colmap_text(text: str) -> dict[str, Stated]:
    """The cameras of a `cameras.txt` by their ids; empty where `text` is nothing of the kind."""
    lines = [
        (n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines or not _LINE.match(lines[0][1]):
        return {}
    return dict(_stated(line.split(), n) for n, line in lines)


def _stated(words: list[str], line: int) -> tuple[str, Stated]:
    if len(words) < 4:
        raise CameraError("must be CAMERA_ID MODEL WIDTH HEIGHT PARAMS...", line=line)
    return words[0], Stated(words[1], words[2], words[3], tuple(words[4:]), line)


def colmap_binary(data: bytes) -> dict[str, Stated]:
    """The cameras of a `cameras.bin` by their ids. Raises CameraError."""
    try:
        (count,) = struct.unpack_from("<Q", data)
        cameras, at = {}, 8
        for _ in range(count):
            name, number, width, height = struct.unpack_from("<IiQQ", data, at)
            model, length = _NUMBERED.get(number, (f"number {number}", -1))
            if length < 0:
                raise CameraError(
                    f"byte {at + 4}: COLMAP's model must be a number from 0 to {max(_NUMBERED)}, not {number}"
                )
            cameras[str(name)] = Stated(model, width, height, struct.unpack_from(f"<{length}d", data, at + 24))
            at += 24 + 8 * length
    except struct.error:
        raise CameraError(f"is cut off after {len(data)} bytes, or is no cameras.bin of COLMAP") from None
    if at != len(data):
        raise CameraError(f"has {len(data) - at} bytes after its {count} cameras, so it is no cameras.bin of COLMAP")
    return cameras


def cameras_file(path: Path) -> Path:
    """The file of cameras that a reconstruction's folder, or such a file itself, stands for. Raises CameraError."""
    if fault_of(path) != IS_FOLDER:
        return path
    for place in PLACES:
        for kind in ("cameras.bin", "cameras.txt"):
            if fault_of(found := path / place / kind) is None:
                return found
    raise CameraError(
        "cannot be read: it is a folder without COLMAP's cameras.bin or cameras.txt, also in sparse/0 and sparse",
        path=path,
    )


def taken_by(cameras: Path, photo: str | Path) -> str | None:
    """The id of the camera that took the picture of this name, by the file of images beside `cameras`.

    None where there is no such file, or the name is not in it. A name matches by the end of its path; of several the
    longest is taken, and of pictures of one name in several folders none where they have several cameras. Raises
    CameraError.
    """
    images = cameras.with_name(f"images{cameras.suffix}")
    if cameras.stem != "cameras" or fault_of(images, MAX_IMAGES) is not None:
        return None
    found = images.stat()
    by_end = _by_end(images, (found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns))
    parts, photos = Path(photo).absolute().parts, by_end.get(Path(photo).name, ())
    fit = [(len(own), name) for own, name in photos if parts[-len(own) :] == own]
    return max(fit)[1] if fit else _only({name for _, name in photos})


def _only(names: set[str]) -> str | None:
    """The one of a set, None of none or several."""
    return next(iter(names)) if len(names) == 1 else None


Named = tuple[tuple[str, ...], str]
"""A picture's path in parts, and the id of its camera."""


@lru_cache(4)
def _by_end(images: Path, _version: tuple[int, ...]) -> Mapping[str, tuple[Named, ...]]:
    """The pictures of a file of images by the last part of their names."""
    found: dict[str, list[Named]] = {}
    with images.open("rb") as file:
        try:
            for name, camera in _binary(file) if images.suffix == ".bin" else _text(file):
                parts = PurePosixPath(name).parts
                found.setdefault(parts[-1] if parts else "", []).append((parts, camera))
        except (struct.error, ValueError) as error:
            raise CameraError(f"byte {file.tell()}: is no {images.name} of COLMAP: {error}", path=images) from None
        except CameraError as error:
            raise CameraError(error.message, path=images, line=error.line) from None
    return {end: tuple(names) for end, names in found.items()}


def _binary(file: BinaryIO) -> Iterator[tuple[str, str]]:
    """Names and cameras' ids; points are passed over."""
    (count,) = struct.unpack("<Q", file.read(8))
    if count > MOST_NAMED:
        raise ValueError(f"{count} pictures are more than the {MOST_NAMED} that are read")
    end = file.seek(0, 2)
    file.seek(8)
    for _ in range(count):
        *_pose, camera = struct.unpack("<I7dI", file.read(64))
        name = bytearray()
        while (letter := file.read(1)) != b"\x00":
            if not letter or len(name) > LONGEST:
                raise ValueError(f"a name must end within {LONGEST} bytes")
            name += letter
        (points,) = struct.unpack("<Q", file.read(8))
        if file.tell() + 24 * points > end:
            raise ValueError(f"it is cut off, or {points} points are too many")
        file.seek(24 * points, 1)
        yield name.decode("utf-8", "surrogateescape"), str(camera)


def _text(file: BinaryIO) -> Iterator[tuple[str, str]]:
    """The same of a text: a line of the picture, then one of its points, which may be empty."""
    number = count = 0
    while line := _whole_line(file):
        number += 1
        if not line.strip() or line.startswith(b"#"):
            continue
        words = line.decode("utf-8", "surrogateescape").split(None, 9)
        if len(words) != 10 or not words[8].isdigit():
            raise CameraError("must be IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", line=number)
        count += 1
        if count > MOST_NAMED:
            raise CameraError(f"has more pictures than the {MOST_NAMED} that are read", line=number)
        yield words[9].rstrip("\r\n"), words[8]
        _whole_line(file)
        number += 1


def _whole_line(file: BinaryIO) -> bytes:
    """The beginning of the next line, which is read to its end however long it is."""
    line = piece = file.readline(LONGEST)
    while piece and not piece.endswith(b"\n"):
        piece = file.readline(2**20)
    return line
