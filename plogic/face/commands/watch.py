"""``plogic watch``: frames as they come, a line of JSON each."""

import os
import sys
from contextlib import closing, suppress
from itertools import islice
from pathlib import Path
from statistics import median
from time import monotonic

from geometry.errors import CameraError
from geometry.files.plain_files import name_of
from plogic.base.children import ending_well
from plogic.base.errors import InputError
from plogic.face.commands.perceive import picture_of
from plogic.face.shown.options import Watching, say
from plogic.face.shown.progress import Progress
from plogic.run.batch.frame_lines import ERROR, UNFINISHED
from plogic.run.batch.frames import Settings
from plogic.run.batch.log import Log
from plogic.run.cameras import GivenCamera, read_given
from plogic.run.silence.beforehand import beforehand
from plogic.run.video.video import frame_name
from plogic.run.watch.moments import Moment, device_number, moments_of
from plogic.run.watch.watcher import Seen, Watcher
from sensing.files.whole_files import check_places, write_whole

BAD, LATE = 1, 3
"""Exit statuses: a frame could not be perceived, or Ctrl-C; the deadline cut one short."""


def watch_command(source: str, settings: Settings, options: Watching) -> int:
    """Interpret frame after frame of ``source`` until it ends, there were enough, or Ctrl-C; the exit status.

    Raises:
        PlogicError: What is wrong with KB, camera or source; the lines of the frames before it are written.
    """
    check_places([] if options.picture is None else [options.picture])
    watcher = Watcher(settings, source, short=options.short)
    for line in beforehand(watcher.perceiver.kb, settings.kb):
        say(line)
    _make(options.pictures)
    out, told = Log("standard output", sys.stdout.buffer), Told()
    size = None if device_number(source) is None else _size(settings.camera)
    with ending_well(), closing(told), moments_of(source, options.every, size, newest=options.newest) as moments:
        try:
            for moment in islice(moments, options.limit):
                begun, name = monotonic(), frame_name(_stem(source), moment.number)
                seen = watcher(moment, name)
                for note in () if told.frames else watcher.notes:
                    told.say(f"{name_of(source)}: {note}")
                _draw(seen, moment, name, options)
                told.frame(moment, seen, name, monotonic() - begun)
                out.write(seen.line)
        except BrokenPipeError:  # who reads has enough
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return told.status
        except (KeyboardInterrupt, SystemExit) as end:
            told.say(f"stopped: {told.summary()}")
            if isinstance(end, SystemExit):
                raise
            return BAD
    if not told.frames:
        raise InputError(f"{name_of(source)}: has no frame")
    told.say(told.summary())
    return told.status


def _size(given: GivenCamera) -> tuple[int, int] | None:
    """The size of frames that a camera file tells; None where it tells none, or cannot be read, as will be said."""
    if given.file is not None:
        with suppress(CameraError):
            camera = read_given(given.file)
            return camera.width, camera.height
    return None


def _stem(source: str) -> str:
    """What the names of frames begin with: ``clip``, ``stdin``, ``camera0``."""
    number = device_number(source)
    return f"camera{number}" if number is not None else "stdin" if source == "-" else source


def _in(folder: Path | None, name: str) -> Path | None:
    return None if folder is None else folder / name


def _make(folder: Path | None) -> None:
    """Make the folder of pictures, if it is not there. Raises InputError."""
    try:
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror}") from None


def _draw(seen: Seen, moment: Moment, name: str, options: Watching) -> None:
    """Write the picture of a frame wherever one is wanted; of a bad frame there is none."""
    places = [place for place in (options.picture, _in(options.pictures, f"{name}.png")) if place is not None]
    if seen.document is None or not places:
        return
    picture = picture_of(seen.document, moment.pixels)
    for place in places:
        write_whole(place, picture)


class Told:
    """What people are told meanwhile, and at the end."""

    def __init__(self) -> None:
        """The clock runs from the first frame on."""
        self.frames = self._skipped = self._bad = self._unfinished = 0
        self._seconds: list[float] = []
        self._start, self._progress = monotonic(), Progress()

    @property
    def status(self) -> int:
        """The exit status."""
        return BAD if self._bad else LATE if self._unfinished else 0

    def frame(self, moment: Moment, seen: Seen, name: str, seconds: float) -> None:
        """One frame more was interpreted in so many seconds."""
        if not self.frames:
            self._start = monotonic() - seconds
        self.frames += 1
        self._skipped += moment.skipped
        self._bad += seen.status == ERROR
        self._unfinished += seen.status == UNFINISHED
        self._seconds.append(seconds)
        if seen.status == ERROR:
            first = seen.error.splitlines()[0]
            self.say(first if name in first else f"{name}: {first}")
        hypotheses = seen.document["hypotheses"] if seen.document is not None else []
        known = [f"{h['id']} {h['type']} ({h['probability']:.3f})" for h in hypotheses if h["status"] == "accepted"]
        self._progress.at(f"{name}: {', '.join(known) or 'no known object'}; {self.summary()}")

    def say(self, line: str) -> None:
        """A line that stays."""
        self.close()
        say(line)

    def close(self) -> None:
        """Take the line of the terminal away."""
        self._progress.end()

    def summary(self) -> str:
        """``57 frames, 3 skipped, 1 bad; 0.43 s a frame (median), 2.3 frames a second``."""
        counts = [f"{self.frames} frame{'s' * (self.frames != 1)}"]
        counts += [f"{n} {what}" for n, what in self._counts() if n]
        if not self.frames:
            return counts[0]
        speed = self.frames / max(monotonic() - self._start, 1e-9)
        return f"{', '.join(counts)}; {median(self._seconds):.2f} s a frame (median), {speed:.1f} frames a second"

    def _counts(self) -> list[tuple[int, str]]:
        return [(self._skipped, "skipped"), (self._bad, "bad"), (self._unfinished, "unfinished")]
