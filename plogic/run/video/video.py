"""A video file, whose frames a child process decodes (``video_child``).

* ``with Video("clip.mp4") as video: video.frame(12)``: the pixels of frame 12 (the first is 0), and when it is shown
* ``counted("clip.mp4")``: ``Count(60, None)``, or how many there are before what is wrong

A rotation tag is not applied, as of a picture: the camera's K speaks of the stored pixels.
"""

import json
import struct
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from geometry.files.plain_files import must_be_plain
from plogic.base.children import Child, heard, python
from plogic.base.errors import InputError
from plogic.run.cameras import GivenCamera, Shot, shot_with
from plogic.run.video.video_child import VARIABLES

VIDEOS = (".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".ts", ".m2ts", ".mts", ".wmv", ".flv", ".3gp", ".ogv")  # fmt: skip
"""Endings of what is taken for a video."""
MOST_FRAMES = 200_000
"""Of a video that is perceived whole: almost two hours at 30 frames a second. A stream that is watched has no end."""
PATIENCE = 60.0
"""Seconds that the decoder may take over a few frames."""
STEP = 64
"""Frames that are decoded before the decoder says that it is alive."""
MEMORY = 4 * 2**30
"""Bytes that the decoder may use."""
NO_INDEX = "moov atom not found"
"""What libav says of an MP4 whose end is missing: its index is there."""

_PROGRESSIVE = "ffmpeg -i {} -vf yadif -c:v ffv1 clip.mkv makes one that can be read"


class Count(NamedTuple):
    """How many frames can be decoded, and what is wrong with the rest, as one line."""

    frames: int
    fault: str | None


class Shown(NamedTuple):
    """A frame: (H, W, 3) uint8, blue first; ``seconds`` after the first one it is shown."""

    pixels: NDArray[np.uint8]
    seconds: float


class Video:
    """A video that is read forwards; a frame before the last one is reached by starting anew.

    ``width``, ``height``: of the stored pixels; ``rotation``: degrees of its tag.
    """

    def __init__(self, path: str | Path) -> None:
        """Start the decoder.

        Raises:
            InputError: No file, no video, without pictures, of a codec that OpenCV lacks, or too large.
        """
        self.path = str(path)
        must_be_plain(self.path, InputError)
        self._damage = _sniffed(self.path)
        self._start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the decoder."""
        self._child.end()

    @property
    def notes(self) -> tuple[str, ...]:
        """What people should know of its pixels, to be said after its name."""
        if not self.rotation:
            return ()
        stored = f"{self.width}x{self.height}"
        what = f"its rotation tag ({self.rotation} degrees) is not applied"
        return (f"{what}: pixels, and --fov across, are of the frames as they are stored, {stored}",)

    def frame(self, number: int) -> Shown | None:
        """Frame ``number``, or None where the video ends before it. Raises InputError at what is damaged."""
        if number < self._next:
            self.close()
            self._start()
        while self._next <= number:
            row = self._grab(min(STEP, number + 1 - self._next))
            if row["end"]:
                fault = self._fault(row)
                if fault is not None:
                    raise InputError(fault)
                return None
        row = self._asked("take")
        if "fault" in row:
            remedy = f" ({_PROGRESSIVE.format(self.path)})" * ("interlaced" in row["fault"])
            raise InputError(f"{self.path}: frame {number}: {row['fault']}{remedy}")
        pixels = np.frombuffer(self._bytes(int(np.prod(row["shape"]))), np.uint8).reshape(row["shape"])
        return Shown(pixels, row["seconds"])

    def count(self) -> Count:
        """How many frames there are, all of which are decoded for that."""
        while True:
            row = self._grab(STEP)
            if self._next > MOST_FRAMES:
                remedy = (
                    f"cut it (ffmpeg -i {self.path} -c copy -f segment -segment_time 600 part_%03d.mkv), or watch it"
                )
                return Count(0, f"{self.path}: has more than the {MOST_FRAMES} frames that are read: {remedy}")
            if row["end"]:
                fault = self._fault(row)
                none = f"{self.path}: has no frame that can be decoded"
                return Count(self._next, none if fault is None and not self._next else fault)

    def _start(self) -> None:
        command = python("plogic.run.video.video_child", str(Path(self.path).absolute()))
        self._child, self._said, self._next = Child(command, memory=MEMORY, variables=VARIABLES), bytearray(), 0
        facts = self._row()
        if "fault" in facts:
            self.close()
            missing = f"{NO_INDEX}: the end of the recording is missing, and its index with it"
            what = missing if facts["fault"] == NO_INDEX else facts["fault"]
            raise InputError(f"{self.path}: no picture can be decoded: {what}")
        self.width, self.height, self.rotation = (int(facts[key]) for key in ("width", "height", "rotation"))

    def _grab(self, number: int) -> dict[str, Any]:
        row = self._asked(f"grab {number}")
        self._next += row["grabbed"]
        return row

    def _fault(self, row: dict[str, Any]) -> str | None:
        """What is wrong where the frames end; None where that is the video's end."""
        what = row["fault"] or self._damage
        if what is None:
            return None
        number, plural = self._next, "s" * (self._next != 1)
        if not number:
            return f"{self.path}: no frame can be decoded: {what}"
        return f"{self.path}: is damaged or cut off after {number} frame{plural}: {what}"

    def _asked(self, line: str) -> dict[str, Any]:
        try:
            self._child.tell(line.encode() + b"\n")
        except BrokenPipeError:
            raise self._dead() from None
        return self._row()

    def _row(self) -> dict[str, Any]:
        end = self._said.find(b"\n")
        while end < 0:
            self._more()
            end = self._said.find(b"\n")
        row: dict[str, Any] = json.loads(self._said[:end])
        del self._said[: end + 1]
        return row

    def _bytes(self, number: int) -> bytearray:
        while len(self._said) < number:
            self._more()
        taken = self._said[:number]
        del self._said[:number]
        return taken

    def _more(self) -> None:
        if not heard([self._child], PATIENCE):
            raise InputError(f"{self.path}: a frame takes the decoder longer than {PATIENCE:g} s")
        piece = self._child.read()
        if not piece:
            raise self._dead()
        self._said += piece

    def _dead(self) -> InputError:
        return InputError(f"{self.path}: the decoder dies after {self._next} frames ({self._child.end()})")


def counted(path: str | Path) -> Count:
    """How many frames a video has. Raises nothing: what is wrong with it is told."""
    try:
        with Video(path) as video:
            return video.count()
    except InputError as error:
        return Count(0, str(error))


def shot_at(path: str, version: tuple[int, ...], number: int, given: GivenCamera) -> Shot:
    """A frame with its camera; the last video that was asked for is kept open, as long as its ``version`` is the same.

    Raises InputError where there is no such frame, or nothing tells the camera; CameraError.
    """
    video = _kept(path, version)
    shown = video.frame(number)
    if shown is None:
        raise InputError(f"{path}: has no frame {number}")
    shot = shot_with(shown.pixels, given, f"{path} {frame_name(path, number)}")
    return shot._replace(notes=(*shot.notes, *video.notes))


@lru_cache(1)
def _kept(path: str, _version: tuple[int, ...]) -> Video:
    return Video(path)


def frame_name(path: str | Path, number: int) -> str:
    """``clip_000012``: as one would call the picture."""
    return f"{Path(path).stem}_{number:06d}"


def is_video(name: str) -> bool:
    """Whether a name's ending is a video's."""
    return name.lower().endswith(VIDEOS)


def _sniffed(path: str) -> str | None:
    """What is amiss that no decoder tells: an AVI that is shorter than it says.

    Raises InputError where the first bytes are no video's, so that no list of other files is opened.
    """
    with Path(path).open("rb") as file:
        head = file.read(768)
        if not head:
            raise InputError(f"{path}: is empty")
        if not _is_container(head):
            raise InputError(
                f"{path}: is no video that is known by its first bytes (MP4, MOV, MKV, WebM, AVI, MPEG, ...)"
            )
        if not head.startswith(b"RIFF"):
            return None
        size, at = file.seek(0, 2), 0
        while at + 8 <= size:
            file.seek(at)
            at += 8 + int(struct.unpack("<4xI", file.read(8))[0])
            at += at % 2
        return f"it has {size} bytes of {at}" if at > size + 1 else None


def _is_container(head: bytes) -> bool:
    starts = b"\x1aE\xdf\xa3", b"OggS", b"FLV", b"\x30\x26\xb2\x75\x8e\x66\xcf\x11", b"\0\0\1\xba", b"\0\0\1\xb3"
    transport = any(
        head[at] == head[at + 188] == head[at + 376] == 0x47 for at in range(min(188, len(head) - 376))
    ) or (len(head) > 196 and head[4] == head[196] == 0x47)
    moving = head[4:8] in {b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide"}
    return head.startswith(starts) or transport or moving or (head[:4] == b"RIFF" and head[8:12] == b"AVI ")
