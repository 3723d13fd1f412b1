"""Frames as they come, each a ``Moment``, from whatever a user names.

* ``with moments_of("clip.mp4", every=10) as moments``: every tenth frame of a video; none is left out
* ``moments_of("-")``: pictures on standard input; ``moments_of("0")``: a camera, of which the newest frame is taken

The same video or stream gives the same moments, unless its newest frames are asked for.
"""

import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from geometry.files.plain_files import IS_FOLDER, IS_MISSING, fault_of, is_there, name_of
from plogic.base.errors import InputError
from plogic.run.video.video import Video, is_video
from plogic.run.watch.newest import Newest
from sensing.errors import SensingError
from sensing.files.images import image_from
from sensing.files.picture_stream import Stream, pictures_in

_DEVICE = re.compile(r"(?:/dev/video)?(\d{1,3})")
BY_FFMPEG = "ffmpeg -i {} -f image2pipe -c:v mjpeg - | plogic watch - ..."


class Moment(NamedTuple):
    """One frame: its ``number`` in the stream, the first is 0, and its ``pixels`` (H, W, 3), blue first.

    ``seconds`` after the first one, where that is known; ``fault``: why there are no pixels; ``skipped``: frames just
    before it that nobody looked at, as newer ones had come; ``notes``: what people should know of the pixels.
    """

    number: int
    seconds: float | None
    pixels: NDArray[np.uint8] | None
    fault: str | None = None
    skipped: int = 0
    notes: tuple[str, ...] = ()


class Device(Protocol):
    """A camera."""

    def grab(self) -> bool:
        """Take a frame, as soon as there is one; False where there will be none."""

    def retrieve(self) -> tuple[bool, Any]:
        """Whether the frame that was taken can be read, and its pixels."""

    def release(self) -> None:
        """Leave it to others."""


@contextmanager
def moments_of(
    source: str, every: int = 1, size: tuple[int, int] | None = None, *, newest: bool = False
) -> Iterator[Iterator[Moment]]:
    """Each ``every``-th frame of a video or a stream of pictures, or, of a camera or by ``newest``, the newest one.

    ``size``: width and height that a camera is asked for.

    Raises InputError and SensingError here, and from the iterator where the rest cannot be read.
    """
    number = device_number(source)
    if number is not None:
        device = opened(number, size)
        try:
            with Newest(of_device(device, number, every), _skipping) as moments:
                yield moments
        finally:
            device.release()
        return
    with _opened(source) as stream:
        if isinstance(stream, Video):
            yield of_video(stream, every)
        elif not newest:
            yield of_pictures(stream, name_of(source), every)
        else:
            with Newest(of_pictures(stream, name_of(source), every, monotonic), _skipping) as moments:
                yield moments


def device_number(source: str) -> int | None:
    """The number of a camera: `0`, `/dev/video0`; None of anything else, a file called `0` for one."""
    found = _DEVICE.fullmatch(source)
    return int(found[1]) if found and (source.startswith("/") or not is_there(Path(source))) else None


def of_video(video: Video, every: int) -> Iterator[Moment]:
    """The frames of a video. Raises InputError where it is damaged."""
    number = 0
    while (shown := video.frame(number)) is not None:
        yield Moment(number, shown.seconds, shown.pixels, notes=video.notes)
        number += every


def of_pictures(stream: Stream, name: str, every: int, clock: Callable[[], float] | None = None) -> Iterator[Moment]:
    """The pictures of a stream, a damaged one too; with a ``clock`` they are timed as they come.

    Raises ImageError where none can be told any more.
    """
    start = None
    for number, data in enumerate(pictures_in(stream, name)):
        seconds, start = _since(start, clock)
        if number % every:
            continue
        try:
            yield Moment(number, seconds, image_from(data, f"{name}: picture {number}"))
        except SensingError as error:
            yield Moment(number, seconds, None, str(error))


def of_device(device: Device, name: int, every: int) -> Iterator[Moment]:
    """The frames of a camera. Raises InputError where it gives no more, as when it is unplugged."""
    start, number = None, 0
    while device.grab():
        seconds, start = _since(start, monotonic)
        if number % every == 0:
            there, pixels = device.retrieve()
            fault = None if there else f"camera {name}: frame {number} cannot be read"
            yield Moment(number, seconds, np.asarray(pixels) if there else None, fault)
        number += 1
    raise InputError(f"camera {name}: gives no more frames (it gave {number})")


def opened(number: int, size: tuple[int, int] | None) -> Device:
    """The camera of a number, asked for frames of ``size`` (width, height). Raises InputError."""
    import cv2

    log: Any = cv2 if hasattr(cv2, "setLogLevel") else cv2.utils.logging  # OpenCV 4, OpenCV 5
    level = log.getLogLevel()
    log.setLogLevel(0)
    try:
        device = cv2.VideoCapture(number)
    finally:
        log.setLogLevel(level)
    if not device.isOpened():
        raise InputError(f"camera {number}: there is no such camera, or it is in use (/dev/video{number})")
    device.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    for key, value in zip((cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT), size or (), strict=False):
        device.set(key, value)
    return device


@contextmanager
def _opened(source: str) -> Iterator[Video | Stream]:
    """A video, or what gives bytes of pictures: standard input, a pipe, a file of pictures in a row."""
    if source == "-":
        yield _Raw(sys.stdin.fileno())
        return
    path, fault = Path(source), fault_of(Path(source))
    if fault == IS_MISSING and "://" in source:
        raise InputError(f"{source}: is an address, and no file: {BY_FFMPEG.format(source)}")
    if fault == IS_FOLDER:
        raise InputError(f"{source}: is a folder: plogic batch perceives its pictures")
    if fault == IS_MISSING:
        raise InputError(f"{source}: {fault}")
    if is_video(source):
        with Video(path) as video:
            yield video
        return
    try:
        file = path.open("rb")
    except OSError as error:
        raise InputError(f"{source}: cannot be read: {error.strerror}") from None
    with file:
        yield file


class _Raw:
    """Standard input without a buffer, whose lock a thread that waits at the end of the process would hold."""

    def __init__(self, number: int) -> None:
        self._number = number

    def read1(self, size: int, /) -> bytes:
        """What has come."""
        return os.read(self._number, size)


def _since(start: float | None, clock: Callable[[], float] | None) -> tuple[float | None, float | None]:
    """Seconds since the first call, and when that was."""
    if clock is None:
        return None, None
    now = clock()
    start = now if start is None else start
    return round(now - start, 3), start


def _skipping(moment: Moment, skipped: int) -> Moment:
    return moment._replace(skipped=skipped)
