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
from plogic.run.cameras import Shot, shot_with, sized
from plogic.run.perceive import perceiver_of
from plogic.run.sources import detected, kb_of
from plogic.run.watch.moments import Moment
from plogic.sequence.unposed.reading import doubts_weighed

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from geometry.camera import Camera


class Seen(NamedTuple):
    """A frame's ``line``, with its end; its interpretation where there is one; ``error`` where there is none."""

    status: str
    line: bytes
    document: Interpretation | None = None
    error: str = ""


class Watcher:
    """Interprets the frames of ``source``, each by itself.

    ``short``: lines are ``frame/1``, as ``plogic batch`` writes them; else ``interpretation/1``, what ``plogic
    perceive`` writes, with the key ``moment``. A frame that cannot be perceived is a ``frame/1`` with its error.

    ``notes``: what is doubtful of the camera, once there was a frame.

    Raises PlogicError where the KB cannot be read.
    """

    def __init__(self, settings: Settings, source: str, *, short: bool) -> None:
        self.settings, self.source, self.short = settings, source, short
        self.notes: tuple[str, ...] = ()
        self._camera: Camera | None = None
        self.perceiver = perceiver_of(kb_of(settings.kb))
        self._lines = Lines(settings, {"name": self.perceiver.kb.name, "digest": self.perceiver.kb.digest})

    def __call__(self, moment: Moment, name: str) -> Seen:
        """What a frame called ``name`` shows.

        Raises PlogicError where no frame can show anything: nothing tells the camera, or it is of another size, or no
        detector reports a type of the KB.
        """
        frame = Frame(self.source, name, "image")
        row: MomentRow = {
            "input": self.source,
            "number": moment.number,
            "seconds": moment.seconds,
            "skipped": moment.skipped,
        }
        if moment.pixels is None:
            return self._wrong(frame, moment.fault or "cannot be read", row)
        clock, chosen = Stopwatch(), self.settings
        shot = self._shot(moment.pixels, name)
        gamma = detected(shot.image, shot.camera, self.perceiver.kb, clock)
        end = monotonic() + chosen.deadline if chosen.deadline is not None else None
        options = Options(chosen.reading, chosen.reconsider, chosen.smoothing, end)
        try:
            document = self.perceiver(gamma, options, moment.pixels, clock)
        except PlogicError as error:
            return self._wrong(frame, str(error), row)
        document = document if chosen.deadline is not None else doubts_weighed(document)
        if self.short:
            status, line = self._lines.perceived(frame, document, None, moment=row)
            return Seen(status, line, document)
        placed: Interpretation = {"format": document["format"], "moment": row, **document}
        return Seen(UNFINISHED if document.get("unfinished") else DONE, text_of(placed).encode(), document)

    def _shot(self, pixels: "NDArray[np.uint8]", name: str) -> Shot:
        """A frame with the camera of the first one."""
        if self._camera is not None:
            return Shot(pixels, sized(self._camera, pixels, "the first frame", name))
        shot = shot_with(pixels, self.settings.camera, name)
        self._camera, self.notes = shot.camera, shot.notes
        return shot

    def _wrong(self, frame: Frame, what: str, row: MomentRow) -> Seen:
        return Seen(*self._lines.wrong(frame, what, None, moment=row), error=what)
