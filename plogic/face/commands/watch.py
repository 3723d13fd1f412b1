"""``plogic watch``: frames as they come, a line of JSON each."""

import sys
from contextlib import closing, suppress
from functools import partial
from itertools import islice
from pathlib import Path
from statistics import median
from time import monotonic

from geometry.errors import CameraError
from geometry.files.plain_files import name_of
from kb.files.folder import parts_of
from plogic.base.children import ending_well
from plogic.base.errors import InputError, ReaderGoneError
from plogic.base.jobs import processors
from plogic.base.stream_jobs import InTurn
from plogic.face.commands.perceive import picture_of
from plogic.face.shown.options import Watching
from plogic.face.shown.printed import say
from plogic.face.shown.progress import Progress
from plogic.run.batch.frame_lines import ERROR, UNFINISHED
from plogic.run.batch.frames import Settings
from plogic.run.batch.log import Log
from plogic.run.cameras import GivenCamera, read_given
from plogic.run.silence.beforehand import beforehand
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
    check_places([] if options.picture is None else [options.picture], [source, *parts_of(settings.kb)])
    drawn = options.picture is not None or options.pictures is not None
    jobs = min(options.jobs or processors(), options.limit or sys.maxsize)
    watcher = Watcher(
        settings,
        source,
        short=options.short,
        draw=partial(picture_of, marks=options.marks) if drawn else None,
        processes=1 if jobs > 1 else None,
    )
    for line in beforehand(watcher.perceiver.kb, settings.kb):
        say(line)
    _make(options.pictures)
    with ending_well(), closing(Told(source)) as told, InTurn(watcher, jobs) as work:
        return _watched(work, watcher, settings, options, told)


def _watched(work: InTurn[Moment, Seen], watcher: Watcher, settings: Settings, options: Watching, told: "Told") -> int:
    """Write a line a frame; the exit status."""
    source, out = watcher.source, Log("standard output", sys.stdout.buffer)
    size = None if device_number(source) is None else _size(settings.camera)
    try:
        with moments_of(source, options.every, size, newest=options.newest) as moments:
            for moment, seen in work.of(islice(moments, options.limit)):
                name = watcher.name(moment)
                _write_picture(seen, name, options)
                told.frame(moment, seen, name)
                out.write(seen.line)
    except ReaderGoneError:  # who reads has enough
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


def _make(folder: Path | None) -> None:
    """Make the folder of pictures, if it is not there. Raises InputError."""
    try:
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror}") from None


def _write_picture(seen: Seen, name: str, options: Watching) -> None:
    """Write the picture of a frame wherever it is wanted; of a bad frame there is none."""
    in_folder = None if options.pictures is None else options.pictures / f"{name}.png"
    for place in (options.picture, in_folder):
        if place is not None and seen.picture is not None:
            write_whole(place, seen.picture)


class Told:
    """What people are told meanwhile, and at the end."""

    def __init__(self, source: str) -> None:
        self.frames = self._skipped = self._bad = self._unfinished = 0
        self._doubted = False
        self._source, self._progress = source, Progress()
        self._seconds: list[float] = []
        self._start = 0.0

    @property
    def status(self) -> int:
        """The exit status."""
        return BAD if self._bad else LATE if self._unfinished else 0

    def frame(self, moment: Moment, seen: Seen, name: str) -> None:
        """One frame more was interpreted."""
        if not self.frames:
            self._start = monotonic() - seen.seconds
            for note in seen.notes:
                self.say(f"{name_of(self._source)}: {note}")
        self.frames += 1
        self._skipped += moment.skipped
        self._bad += seen.status == ERROR
        self._unfinished += seen.status == UNFINISHED
        self._seconds.append(seen.seconds)
        if seen.doubt and not self._doubted:
            self._doubted = True
            self.say(f"{name}: {seen.doubt} (told once)")
        if seen.status == ERROR:
            self.say(f"{name}: {seen.error.splitlines()[0]}")
        self._progress.at(f"{name}: {'; '.join(seen.known) or 'no known object'}; {self.summary()}")

    def say(self, line: str) -> None:
        """A line that stays."""
        self.close()
        say(line)

    def close(self) -> None:
        """Take the line of the terminal away."""
        self._progress.end()

    def summary(self) -> str:
        """``57 frames, 3 skipped, 1 bad; 0.43 s a frame (median), 2.3 frames a second``."""
        counts = ((self._skipped, "skipped"), (self._bad, "bad"), (self._unfinished, "unfinished"))
        told = [f"{self.frames} frame{'s' * (self.frames != 1)}", *(f"{n} {what}" for n, what in counts if n)]
        if not self.frames:
            return told[0]
        speed = self.frames / max(monotonic() - self._start, 1e-9)
        return f"{', '.join(told)}; {median(self._seconds):.2f} s a frame (median), {speed:.1f} frames a second"
