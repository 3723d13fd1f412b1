"""A process that decodes the video that its first argument names (an absolute path).

From stdin a line a request, to stdout one line of JSON for each; the first line out is ``Facts``, or what is wrong.

* ``grab 256``: decodes so many frames, or those up to the end. ``{"grabbed": 60, "end": true, "fault": null}``
* ``take``: the frame that was decoded last. ``{"seconds": 5.9, "shape": [480, 640, 3]}`` and then its pixels, blue
  first; or ``{"fault": ...}``

What libav complains of goes to a file, which is looked at after each frame: a decoder fills in what is damaged.
"""

import ctypes
import json
import os
import sys
from pathlib import Path
from typing import Any

from plogic.base.children import begin

COMPLAINTS = "libav.txt"
"""What libav says, in the scratch folder."""
MOST_PIXELS = 64_000_000
"""Of a frame; 8K video has 33 million."""
OPTIONS = f"protocol_whitelist;file|max_pixels;{MOST_PIXELS}"
"""No file may lead to another, and no decoder makes room for more."""
VARIABLES = {
    "OPENCV_FFMPEG_CAPTURE_OPTIONS": OPTIONS,
    "OPENCV_FFMPEG_DEBUG": "1",
    "OPENCV_FFMPEG_LOGLEVEL": "16",
    "OPENCV_LOG_LEVEL": "SILENT",
    "OPENBLAS_NUM_THREADS": "1",
}
"""The environment of this process; level 16 is libav's for errors."""
_MARK = "[OPENCV:FFMPEG:"


class Complaints:
    """What libav has printed since it was asked last."""

    def __init__(self) -> None:
        """Let standard output and standard error lead to a file."""
        self._path = Path(COMPLAINTS)
        file = os.open(self._path, os.O_CREAT | os.O_TRUNC | os.O_WRONLY | os.O_APPEND)
        os.dup2(file, 1)
        os.dup2(file, 2)
        self._flush, self._read = ctypes.CDLL(None).fflush, 0

    def new(self) -> str | None:
        """The first line of it, or None: libav prints into a buffer of C's."""
        self._flush(None)
        if os.fstat(1).st_size == self._read:
            return None
        with self._path.open("rb") as file:
            file.seek(self._read)
            told = file.read(4096).decode("utf-8", "replace")
        self._read = os.fstat(1).st_size
        lines = [line.partition("] ")[2] if line.startswith(_MARK) else line for line in told.splitlines()]
        return next((line.strip() for line in lines if line.strip()), "an error")


class Decoder:
    """One video from its beginning to its end, or to the first damage."""

    def __init__(self, path: str) -> None:
        self._complaints = Complaints()
        self._capture, self._fault = _opened(path), self._complaints.new()
        self._shape: tuple[int, ...] | None = None
        self._over = False

    def facts(self) -> dict[str, Any]:
        """Size and rotation, or what is wrong."""
        import cv2

        if not self._capture.isOpened():
            return {
                "fault": self._fault
                or "it is sound alone, or of a codec that OpenCV lacks (ffmpeg -i FILE -c:v ffv1 clip.mkv makes another of it)"
            }
        width, height = (int(self._capture.get(key)) for key in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
        if not 0 < width * height <= MOST_PIXELS:
            return {"fault": f"its frames have {width}x{height} pixels, not 1 to {MOST_PIXELS}"}
        self._shape = (height, width, 3)
        return {"width": width, "height": height, "rotation": int(self._capture.get(cv2.CAP_PROP_ORIENTATION_META))}

    def grab(self, number: int) -> dict[str, Any]:
        """Decode so many frames, or as many as there are."""
        grabbed, fault = 0, None
        while grabbed < number and not self._over:
            there = self._capture.grab()
            fault = self._complaints.new()
            self._over = not there or fault is not None
            grabbed += not self._over
        return {"grabbed": grabbed, "end": self._over, "fault": fault}

    def take(self) -> tuple[dict[str, Any], bytes]:
        """The frame that was decoded last."""
        import cv2

        there, pixels = self._capture.retrieve()
        fault = self._complaints.new()
        if not there or pixels is None or fault is not None:  # else pixels of no frame may come
            return {"fault": f"its pixels cannot be read{'' if fault is None else f': {fault}'}"}, b""
        if pixels.shape != self._shape or pixels.dtype.name != "uint8":
            return {"fault": f"its size changes to {pixels.shape[1]}x{pixels.shape[0]} pixels"}, b""
        seconds = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        return {"seconds": round(seconds, 6), "shape": pixels.shape}, pixels.tobytes()


def _opened(path: str) -> Any:  # noqa: ANN401 - a capture
    """One thread, so that damage is told of its own frame; a rotation tag is not applied: K is of the stored pixels."""
    import cv2

    capture = cv2.VideoCapture(path, cv2.CAP_FFMPEG, [cv2.CAP_PROP_N_THREADS, 1])
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
    return capture


def main() -> None:
    """Serve until stdin ends."""
    begin()
    with os.fdopen(os.dup(1), "wb") as out:
        decoder = Decoder(sys.argv[1])
        _tell(out, decoder.facts())
        for line in sys.stdin.buffer:
            verb, _, number = line.decode().strip().partition(" ")
            _tell(out, *((decoder.grab(int(number)),) if verb == "grab" else decoder.take()))


def _tell(out: Any, row: dict[str, Any], body: bytes = b"") -> None:  # noqa: ANN401 - a file
    out.write(json.dumps(row).encode() + b"\n")
    out.write(body)
    out.flush()


if __name__ == "__main__":
    main()
