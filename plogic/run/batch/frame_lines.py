"""The text of a frame's line, ``frame/1``: self-contained, so that files of lines may be cut, sorted and put together.

``{"format": "frame/1", "input": "a.json", "frame": null, "status": "done", "sha256": "...", "kb": {"name", "digest"},
"options": {...}, ...}``, ``status`` is ``done``, ``unfinished`` (the deadline was reached) or ``error``. Then comes
``error`` with what ``plogic perceive`` would say, or ``interpretation`` with what it would write, or the short of it:
``appearances``, how many there are; ``hypotheses``, those that are accepted or in a listed world; ``worlds`` and
``unlisted_mass``; of what is unfinished, ``stopped`` and the intervals.

``sha256`` is that of the bytes that were read, as ``cat PICTURE CAMERA | sha256sum`` prints it: of a Γ the file; of a
picture the file and then its camera's, with ``#NAME`` after it where that is one of many; of a BOP frame the picture
and then its entry of ``scene_camera.json`` as JSON with sorted keys; of a lost frame its error. It is ``null`` where
some of that could not be read, or changed meanwhile; where a worker was given up on it is of the files as they were
then.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Final, Literal, NotRequired, TypedDict

from geometry.camera_row import Pose
from geometry.printable import shown
from plogic.facts.document import (
    CameraDoubtRow,
    HypothesisRow,
    Interpretation,
    KBRow,
    MomentRow,
    RejectedRow,
    Status,
    WorldRow,
)
from plogic.facts.fact_rows import Interval
from plogic.facts.situation import Stopped, stopped_in
from plogic.run.batch.frames import Frame, Settings, SettingsRow, digest_of
from plogic.scene.readings.unfinished import unlisted_beyond

FORMAT: Final = "frame/1"
DONE, UNFINISHED, ERROR = "done", "unfinished", "error"


class FullBody(TypedDict):
    """A whole interpretation."""

    interpretation: Annotated[Interpretation, "The interpretation, as `plogic perceive` writes it."]


class ErrorBody(TypedDict):
    """What ``plogic perceive`` would say of a bad frame."""

    error: Annotated[str, "What is wrong, a line a mistake."]


class ShortRow(TypedDict):
    """One hypothesis in short; ``interval`` where an unfinished interpretation bounds its probability."""

    id: Annotated[str, "Its name: `h1`."]
    type: Annotated[str, "Its object type."]
    status: Annotated[Status | Literal["rejected"], "What the search decided."]
    T_camera_object: Annotated[Pose, "Its pose: maps object coordinates to the camera's; row-major, metres."]
    ev: Annotated[float | None, "Explanatory value, from -1 to 1."]
    ev_reconsidered: Annotated[float | None, "The explanatory value beside the accepted hypotheses."]
    probability: Annotated[float, "Probability that it is present."]
    interval: NotRequired[Annotated[Interval, "Bounds of the probability, where a deadline left something open."]]


class ShortBody(TypedDict):
    """The most probable worlds of an interpretation, and the hypotheses in them."""

    appearances: Annotated[int, "How many were detected."]
    hypotheses: Annotated[list[ShortRow], "Those that are accepted or in a listed world."]
    worlds: Annotated[list[WorldRow], "The most probable worlds, best first."]
    unlisted_mass: Annotated[Interval, "Bounds of the probability of all worlds that are not listed."]
    camera_doubt: NotRequired[
        Annotated[CameraDoubtRow, "That the accepted objects contradict the camera; left out where they do not."]
    ]
    stopped: NotRequired[
        Annotated[Stopped, "What a deadline stopped: the search for hypotheses, or the ranking of worlds."]
    ]


class Head(TypedDict):
    """Which frame a line is of, and what it was made with."""

    format: Literal["frame/1"]
    input: Annotated[str, "The input as it was named."]
    frame: Annotated[
        str | None,
        "The frame within the input, `000002/000017` of a BOP dataset, `clip_000012` of a video; null where it holds one.",
    ]
    moment: NotRequired[Annotated[MomentRow, "Which frame of a stream it is, where `watch` wrote the line."]]
    sha256: Annotated[
        str | None, "SHA-256 of the bytes that were read; null where some could not be read, and of a stream."
    ]
    kb: Annotated[KBRow, "The knowledge base that was perceived with."]
    options: Annotated[SettingsRow, "The options that decide the line."]


class WrongLine(Head, ErrorBody):
    """A bad frame."""

    status: Annotated[Literal["error"], "That nothing could be perceived."]


class Noted(TypedDict):
    """What people should know of a frame."""

    notes: NotRequired[
        Annotated[list[str], "What is guessed or doubtful of the picture's camera; left out where nothing is."]
    ]


class FullLine(Head, FullBody, Noted):
    """A frame with its whole interpretation (``--full``)."""

    status: Annotated[Literal["done", "unfinished"], "Whether a deadline left something open."]


class ShortLine(Head, ShortBody, Noted):
    """A frame in short."""

    status: Annotated[Literal["done", "unfinished"], "Whether a deadline left something open."]


FrameLine = WrongLine | FullLine | ShortLine


@dataclass(frozen=True)
class Lines:
    """Makes the lines of one run; ``kb`` is its name and digest, as in an interpretation."""

    settings: Settings
    kb: KBRow

    def perceived(
        self,
        frame: Frame,
        document: Interpretation,
        sha256: str | None,
        notes: Sequence[str] = (),
        *,
        moment: MomentRow | None = None,
    ) -> tuple[str, bytes]:
        """Status and line of a frame with its interpretation.

        ``sha256`` is of what was read; ``moment``: of a stream's frame.
        """
        status: Literal["done", "unfinished"] = "unfinished" if document.get("unfinished") else "done"
        head = self._head(frame, sha256, moment)
        noted: Noted = {"notes": [*notes]} if notes else {}
        if self.settings.full:
            return status, _line({**head, "status": status, **noted, "interpretation": document})
        return status, _line({**head, "status": status, **noted, **short(document, self.settings.worlds)})

    def wrong(
        self, frame: Frame, message: str, sha256: str | None, *, moment: MomentRow | None = None
    ) -> tuple[str, bytes]:
        """Status and line of a bad frame."""
        return ERROR, _line({**self._head(frame, sha256, moment), "status": "error", "error": message})

    def given_up(self, frame: Frame, message: str) -> tuple[str, bytes]:
        """As ``wrong``, of a frame whose worker is gone and cannot say what it read: as it is now."""
        return self.wrong(frame, message, digest_of(frame, self.settings.camera))

    def _head(self, frame: Frame, sha256: str | None, moment: MomentRow | None) -> Head:
        head: Head = {
            "format": FORMAT,
            "input": frame.input,
            "frame": frame.frame,
            "sha256": sha256,
            "kb": self.kb,
            "options": self.settings.document(),
        }
        return head if moment is None else {**head, "moment": moment}


def is_noted(line: bytes) -> bool:
    """Whether a line has ``notes``, or a doubt of the camera; within a text the quotes would be escaped."""
    return b'"notes":[' in line or b'"camera_doubt":{' in line


def doubt_in(line: bytes) -> str:
    """What a line says against the camera, '' where it says nothing."""
    if b'"camera_doubt":{' not in line:
        return ""
    row = json.loads(line)
    return str(row.get("interpretation", row)["camera_doubt"]["why"])


def is_empty(line: bytes) -> bool:
    """Whether a frame was perceived, and nothing in it accepted."""
    return b'"status":"done"' in line and b'"status":"accepted"' not in line


def _line(row: FrameLine) -> bytes:
    first = {"format": row["format"], "input": row["input"], "frame": row["frame"], "status": row["status"]}
    text = json.dumps({**first, **row}, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return shown(text).encode() + b"\n"  # of a file's name that is no text: \udc80, as JSON writes it


def short(document: Interpretation, number: int) -> ShortBody:
    """An interpretation's ``number`` best worlds, and the posed hypotheses that are accepted or in one of them."""
    listed, stopped = document["worlds"][:number], stopped_in(document)
    present = {name for world in listed for name in world["present"]}
    body: ShortBody = {
        "appearances": len(document["appearances"]),
        "hypotheses": [
            _short_row(h) for h in document["hypotheses"] if h["status"] == "accepted" or h["id"] in present
        ],
        "worlds": [_short_world(world) for world in listed],
        "unlisted_mass": unlisted_beyond(document, number),
    }
    if "camera_doubt" in document:
        body["camera_doubt"] = document["camera_doubt"]
    return {**body, "stopped": stopped} if stopped else body


def _short_row(h: HypothesisRow | RejectedRow) -> ShortRow:
    row: ShortRow = {
        "id": h["id"],
        "type": h["type"],
        "status": h["status"],
        "T_camera_object": h["T_camera_object"],
        "ev": h["ev"],
        "ev_reconsidered": h["ev_reconsidered"],
        "probability": h["probability"],
    }
    return {**row, "interval": h["interval"]} if "interval" in h else row


def _short_world(world: WorldRow) -> WorldRow:
    row: WorldRow = {"probability": world["probability"], "present": world["present"]}
    return {**row, "interval": world["interval"]} if "interval" in world else row
