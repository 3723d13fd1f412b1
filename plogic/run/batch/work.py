"""One frame after the other, in a process that has read the knowledge base once."""

from collections.abc import Iterable
from pathlib import Path
from time import monotonic

from geometry.errors import PlogicError
from plogic.base.clock import Stopwatch
from plogic.base.errors import InputError
from plogic.cycle.delta import Options
from plogic.facts.document import Interpretation
from plogic.run.batch.frame_lines import Lines
from plogic.run.batch.frames import (
    Frame,
    Settings,
    checked,
    digest_of,
    number_in_video,
    scene_and_image,
    scene_at,
    version_of,
)
from plogic.run.cameras import NOTHING_GIVEN, GivenCamera, NoCameraError, Shot, camera_beside, shot_of
from plogic.run.perceive import perceiver_of
from plogic.run.sources import gamma_of, kb_of
from plogic.run.video.video import shot_at

CHANGED = "changed while it was read"
"""What is wrong with a frame whose bytes before and after are not the same."""


class Worker:
    """A knowledge base made ready, and what makes a line of a frame with it.

    Raises PlogicError where the KB cannot be read.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.perceiver = perceiver_of(kb_of(settings.kb), processes=1)
        self.lines = Lines(settings, {"name": self.perceiver.kb.name, "digest": self.perceiver.kb.digest})

    def __call__(self, frame: Frame, clock: Stopwatch | None = None) -> tuple[str, bytes]:
        """Status and line of one frame; raises nothing. ``clock`` tells meanwhile what it is at."""
        sha256 = self._digest(frame)
        try:
            document, notes = self._document(frame, sha256, clock or Stopwatch())
            return self.lines.perceived(frame, document, sha256, notes)
        except PlogicError as error:
            what = str(error)
        except MemoryError:
            what = "out of memory"
        except Exception as error:  # noqa: BLE001 - no frame may stop the others
            what = f"internal error: {' '.join(f'{type(error).__name__}: {error}'.split())}"
        return (
            self.lines.wrong(frame, what, sha256)
            if self._digest(frame) == sha256
            else self.lines.wrong(frame, CHANGED, None)
        )

    def _digest(self, frame: Frame) -> str | None:
        return digest_of(frame, self.settings.camera)

    def _document(self, frame: Frame, sha256: str | None, clock: Stopwatch) -> tuple[Interpretation, tuple[str, ...]]:
        """The interpretation, and what is to be noted of the camera."""
        chosen = self.settings
        with clock.stage("read"):
            shot = shot_for(frame, chosen.camera)
        gamma, image = gamma_of(frame.input, shot, self.perceiver.kb, clock)
        if self._digest(frame) != sha256:
            raise InputError(CHANGED)
        end = monotonic() + chosen.deadline if chosen.deadline is not None else None
        options = Options(chosen.reading, chosen.reconsider, chosen.smoothing, end)
        return self.perceiver(gamma, options, image, clock), shot.notes if shot else ()


def shot_for(frame: Frame, given: GivenCamera) -> Shot | None:
    """The picture of a frame with its camera, where one is ``given`` for all that; None of a Γ. Raises PlogicError."""
    if frame.kind == "lost":
        raise InputError(frame.at)
    if frame.kind == "bop":
        scene, image = scene_and_image(frame)
        shot = scene_at(frame.at, scene).frame(image)
        return Shot(shot.image, shot.camera)
    checked(frame.input)
    if frame.kind == "gamma":
        return None
    camera = camera_beside(frame.input, given)
    if (source := camera.source()) is not None:
        checked(source)
    if frame.kind == "video":
        return shot_at(frame.input, version_of(Path(frame.input)), number_in_video(frame), camera)
    return shot_of(frame.input, camera)


def check_cameras(frames: Iterable[Frame], given: GivenCamera) -> None:
    """Raise NoCameraError, of the first picture, where nothing tells the camera of any: each line would say so.

    Looks no further than the first frame that can be perceived, and at one frame of each video.
    """
    if given != NOTHING_GIVEN:
        return
    missing: NoCameraError | None = None
    seen = set[str]()
    for frame in frames:
        if frame.kind in ("gamma", "bop"):
            return
        if frame.input in seen:
            continue
        seen.add(frame.input)
        try:
            shot_for(frame, given)
        except NoCameraError as error:
            missing = missing or error
        except PlogicError:
            continue  # which its line will say
        else:
            return
    if missing is not None:
        raise missing
