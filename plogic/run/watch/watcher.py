"""What one frame after the other shows: the knowledge base is read, and its index made, once.

* ``watcher = Watcher(Settings("towers"), "-", short=False)``, ``watcher(moment)``: a ``Seen``
"""

from time import monotonic
from typing import TYPE_CHECKING, NamedTuple

from geometry.errors import PlogicError
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.facts.document import Interpretation, MomentRow
from plogic.facts.interpretation import text_of
from plogic.run.batch.frame_lines import DONE, UNFINISHED, Lines
from plogic.run.batch.frames import Frame, Settings
from plogic.run.cameras import Shot, shot_with
from plogic.run.document import placed_in
from plogic.run.perceive import perceiver_of
from plogic.run.sources import detected, kb_of
from plogic.run.video.video import frame_name
from plogic.run.watch.moments import Moment, device_number
from plogic.sequence.unposed.reading import doubts_weighed

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from geometry.camera import Camera


class Seen(NamedTuple):
    """A frame's ``line``, with its end, and what it took ``seconds`` to find: the accepted objects and where they are.

    ``error``: why there is none. ``picture``: PNG of what was found, if any is wanted; ``notes``: what is doubtful of
    the camera; ``doubt``: that the objects contradict it.
    """

    status: str
    line: bytes
    known: tuple[str, ...] = ()
    error: str = ""
    notes: tuple[str, ...] = ()
    doubt: str = ""
    picture: bytes | None = None
    seconds: float = 0.0


class Watcher:
    """Interprets the frames of ``source``, each by itself.

    ``short``: lines are ``frame/1``, as ``plogic batch`` writes them; else ``interpretation/1``, what ``plogic
    perceive`` writes, with the key ``moment``. A frame that cannot be perceived is a ``frame/1`` with its error.

    ``draw``: makes the picture of a frame, where one is wanted; ``processes``: how many may search one frame.

    Raises PlogicError where the KB cannot be read.
    """

    def __init__(
        self,
        settings: Settings,
        source: str,
        *,
        short: bool,
        draw: "Callable[[Interpretation, NDArray[np.uint8]], bytes] | None" = None,
        processes: int | None = None,
    ) -> None:
        self.settings, self.source, self.short, self._draw = settings, source, short, draw
        self._stem = _stem(source)
        self._cameras: dict[tuple[int, ...], tuple[Camera, tuple[str, ...]]] = {}
        self.perceiver = perceiver_of(kb_of(settings.kb), processes=processes)
        self._lines = Lines(settings, {"name": self.perceiver.kb.name, "digest": self.perceiver.kb.digest})

    def name(self, moment: Moment) -> str:
        """What a frame is called: ``clip_000012``, ``stdin_000012``, ``camera0_000012``."""
        return frame_name(self._stem, moment.number)

    def __call__(self, moment: Moment) -> Seen:
        """What a frame shows.

        Raises PlogicError where the first frame cannot show anything, nor others then: nothing tells the camera, or it
        is of another size, or no detector reports a type of the KB. Of a later frame that is its line.
        """
        begun = monotonic()
        return self._seen(moment)._replace(seconds=monotonic() - begun)

    def _seen(self, moment: Moment) -> Seen:
        frame = Frame(self.source, self.name(moment), "image")
        row: MomentRow = {
            "input": self.source,
            "number": moment.number,
            "seconds": moment.seconds,
            "skipped": moment.skipped,
        }
        if moment.pixels is None:
            return self._wrong(frame, moment.fault or "cannot be read", row)
        clock, chosen = Stopwatch(), self.settings
        try:
            shot = self._shot(moment.pixels, self.name(moment))
            gamma = detected(shot.image, shot.camera, self.perceiver.kb, clock)
        except PlogicError as error:
            if moment.number == moment.skipped:  # the first that is looked at
                raise
            return self._wrong(frame, str(error), row)
        end = monotonic() + chosen.deadline if chosen.deadline is not None else None
        options = Options(chosen.reading, chosen.reconsider, chosen.smoothing, end)
        try:
            document = self.perceiver(gamma, options, moment.pixels, clock)
            document = document if chosen.deadline is not None else doubts_weighed(document)
        except PlogicError as error:
            return self._wrong(frame, str(error), row)
        except Exception as error:  # noqa: BLE001 - no frame may stop the others
            what = f"internal error: {' '.join(f'{type(error).__name__}: {error}'.split())}"
            return self._wrong(frame, what, row)
        if self.short:
            status, line = self._lines.perceived(frame, document, None, moment=row)
        else:
            placed: Interpretation = {"format": document["format"], "moment": row, **document}
            status, line = UNFINISHED if document.get("unfinished") else DONE, text_of(placed).encode()
        picture = None if self._draw is None else self._draw(document, moment.pixels)
        notes = (*shot.notes, *moment.notes)
        doubt = document["camera_doubt"]["why"] if "camera_doubt" in document else ""
        return Seen(status, line, placed_in(document), notes=notes, doubt=doubt, picture=picture)

    def _shot(self, pixels: "NDArray[np.uint8]", name: str) -> Shot:
        """A frame with the camera, which is read once for all frames of a size."""
        if pixels.shape not in self._cameras:
            self._cameras[pixels.shape] = shot_with(pixels, self.settings.camera, name)[1:]
        return Shot(pixels, *self._cameras[pixels.shape])

    def _wrong(self, frame: Frame, what: str, row: MomentRow) -> Seen:
        return Seen(*self._lines.wrong(frame, what, None, moment=row), error=what)


def _stem(source: str) -> str:
    """What the names of frames begin with."""
    number = device_number(source)
    return f"camera{number}" if number is not None else "stdin" if source == "-" else source
