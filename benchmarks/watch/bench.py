"""``plogic bench watch``: whether ``plogic watch`` keeps up with a pipe, and a video gives what its pictures give.

Simulated towers, a picture a seed, go through the pipe of one warm process: all at once, and two a second, where
``--newest`` would skip what comes too fast. Then the same pictures as a losslessly coded video (FFV1).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from threading import Thread
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any, NamedTuple

from benchmarks.shared.claims import Claim, report
from benchmarks.shared.processor import processor_seconds

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

SCENES, FEW, TIMES = 8, 2, 3
"""Pictures, and how often each is sent."""
PACE = 2.0
"""Frames a second that are to be kept up with."""
CAPTION = (
    "processor: seconds of the processor a frame, all processes together, without the start; skipped: for newer frames."
)


class Watched(NamedTuple):
    """The lines of a run, seconds from its first line to its last, and seconds of the processor from start to end."""

    lines: list[str]
    wall: float
    processor: float


def run(*, seed: int, quick: bool, as_json: bool, say: Callable[[str], None]) -> tuple[str, bool]:
    """Run the benchmark on scenes of ``seed`` and the seeds after it."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        pictures = _scenes(folder, range(seed, seed + (FEW if quick else SCENES)), say)
        sent = [picture.read_bytes() for picture in pictures] * TIMES
        once = watched(folder, sent[:1], None)
        rows = []
        for name, pace in (("at once", None), (f"{PACE:g} a second", PACE)):
            rows.append(row_of(name, watched(folder, sent, pace), once, len(sent)))
            say(f"{name}: {rows[-1]['frames a second']} frames a second, {rows[-1]['skipped']} skipped")
        same = _same_as_video(folder, pictures)
    text, met = report("watch", rows, claims(rows, same), as_json=as_json)
    return (text if as_json else f"{CAPTION}\n\n{text}"), met


def row_of(name: str, all_sent: Watched, once: Watched, sent: int) -> dict[str, Any]:
    """What a run came to; ``once``: one of a single frame, whose start is taken off."""
    lines = [json.loads(line) for line in all_sent.lines]
    more = max(len(lines) - 1, 1)
    return {
        "sent": name,
        "frames": sent,
        "interpreted": len(lines),
        "skipped": sent - len(lines),
        "frames a second": round(more / max(all_sent.wall, 1e-9), 2),
        "processor": round((all_sent.processor - once.processor) / more, 3),
    }


def claims(rows: Sequence[dict[str, Any]], same: float) -> list[Claim]:
    """Two frames a second, by the processors that there are, and by the clock; the video's bytes."""
    processors = len(os.sched_getaffinity(0))
    at_once, paced = rows
    return [
        Claim(
            f"seconds of {processors} processors a frame, all at once", "<=", processors / PACE, at_once["processor"]
        ),
        Claim(f"frames skipped at {PACE:g} a second", "<=", 0, paced["skipped"]),
        Claim("frames of a lossless video that give the bytes of their pictures", ">=", 1.0, same),
    ]


def watched(folder: Path, sent: Sequence[bytes], pace: float | None) -> Watched:
    """Run ``plogic watch -`` over pictures, all at once or so many a second, once the first is interpreted.

    Raises RuntimeError where it fails.
    """
    before, newest = processor_seconds(), () if pace is None else ("--newest",)
    command = [_script(), "watch", "-", "--kb", "towers", "--camera", "camera.json", "--short", *newest]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=folder, stdin=pipe, stdout=pipe, stderr=pipe) as child:  # noqa: S603 - our own
        assert child.stdin is not None and child.stdout is not None and child.stderr is not None  # noqa: S101, PT018 - pipes
        child.stdin.write(sent[0])
        child.stdin.flush()
        lines, start = [child.stdout.readline().decode()], perf_counter()
        feeder = Thread(target=_feed, args=(child.stdin, sent[1:], pace))
        feeder.start()
        lines += [line.decode() for line in child.stdout]
        wall, said = perf_counter() - start, child.stderr.read().decode()
        feeder.join()
    if child.returncode:
        raise RuntimeError(f"{' '.join(command)}: {said.strip()}")
    return Watched(lines, wall, processor_seconds() - before)


def _feed(pipe: Any, sent: Sequence[bytes], pace: float | None) -> None:  # noqa: ANN401 - a file
    start = perf_counter()
    for number, picture in enumerate(sent, 1):
        if pace is not None:
            sleep(max(0.0, start + number / pace - perf_counter()))
        pipe.write(picture)
        pipe.flush()
    pipe.close()


def _script() -> str:
    return str(Path(sys.executable).with_name("plogic"))


def _scenes(folder: Path, seeds: Sequence[int], say: Callable[[str], None]) -> list[Path]:
    """Pictures of two towers each in a folder of their own, whose camera stands beside it."""
    pictures = folder / "pictures"
    pictures.mkdir()
    for number, seed in enumerate(seeds):
        _done(folder, "simulate", "--kb", "towers", "--seed", str(seed), "-o", f"scene{number}")
        (folder / f"scene{number}" / "image.png").rename(pictures / f"clip_{number:06d}.png")
        (folder / f"scene{number}" / "camera.json").rename(folder / "camera.json")
    say(f"{len(seeds)} scenes")
    return sorted(pictures.iterdir())


def _same_as_video(folder: Path, pictures: Sequence[Path]) -> float:
    """The share of a video's frames whose interpretations have the bytes of those of the pictures."""
    import cv2

    from sensing.files.images import read_image

    frames = [read_image(picture) for picture in pictures]
    size = frames[0].shape[1], frames[0].shape[0]
    writer = cv2.VideoWriter(str(folder / "clip.mkv"), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*"FFV1"), PACE, size)
    for frame in frames:
        writer.write(frame)
    writer.release()
    options = "--kb", "towers", "--camera", "camera.json", "--full"
    of_video, of_pictures = (
        [line.partition('"interpretation":')[2] for line in _done(folder, "batch", name, *options).splitlines()]
        for name in ("clip.mkv", "pictures")
    )
    same = sum(bool(one) and one == other for one, other in zip(of_video, of_pictures, strict=True))
    return same / len(pictures)


def _done(folder: Path, *arguments: str) -> str:
    done = subprocess.run([_script(), *arguments], cwd=folder, capture_output=True, text=True, check=False)  # noqa: S603 - our own
    if done.returncode:
        raise RuntimeError(f"{' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout
