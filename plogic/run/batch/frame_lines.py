"""The text of a frame's line, ``frame/1``: self-contained, so that files of lines may be cut, sorted and put together.

``{"format": "frame/1", "input": "a.json", "frame": null, "status": "done", "sha256": "...", "kb": {"name", "digest"},
"options": {...}, ...}``, ``status`` is ``done``, ``unfinished`` (the deadline was reached) or ``error``. Then comes
``error`` with what ``plogic perceive`` would say, or ``interpretation`` with what it would write, or the short of it:
``appearances``, how many there are; ``hypotheses``, those that are accepted or in a listed world; ``worlds`` and
``unlisted_mass``; of what is unfinished, ``stopped`` and the intervals.

``sha256`` is that of the bytes that were read, as ``cat PICTURE CAMERA | sha256sum`` prints it: of a Γ the file, of a
picture the file and then its camera's, of a BOP frame the picture and then its entry of ``scene_camera.json`` as JSON
with sorted keys, of a lost frame its error. It is ``null`` where some of that could not be read, or changed meanwhile;
where a worker was given up on it is of the files as they were then.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NotRequired, TypedDict

from geometry.camera import Pose
from plogic.facts.document import HypothesisRow, Interpretation, RejectedRow, Status, WorldRow
from plogic.facts.fact_rows import Interval
from plogic.facts.situation import Stopped, stopped_in
from plogic.run.batch.frames import Frame, Settings, digest_of
from plogic.scene.readings.unfinished import unlisted_beyond

FORMAT = "frame/1"
DONE, UNFINISHED, ERROR = "done", "unfinished", "error"


class FullBody(TypedDict):
    """A whole interpretation."""

    interpretation: Interpretation


class ErrorBody(TypedDict):
    """What ``plogic perceive`` would say."""

    error: str


class ShortRow(TypedDict):
    """One hypothesis in short; ``interval`` where an unfinished interpretation bounds its probability."""

    id: str
    type: str
    status: Status | Literal["rejected"]
    T_camera_object: Pose
    ev: float | None
    ev_reconsidered: float | None
    probability: float
    interval: NotRequired[Interval]


class ShortBody(TypedDict):
    """The most probable worlds of an interpretation, and the hypotheses in them."""

    appearances: int
    hypotheses: list[ShortRow]
    worlds: list[WorldRow]
    unlisted_mass: Interval
    stopped: NotRequired[Stopped]


@dataclass(frozen=True)
class Lines:
    """Makes the lines of one run; ``kb`` is its name and digest, as in an interpretation."""

    settings: Settings
    kb: Mapping[str, str]

    def perceived(self, frame: Frame, document: Interpretation, sha256: str | None) -> tuple[str, bytes]:
        """Status and line of a frame with its interpretation; ``sha256`` is of what was read."""
        status = UNFINISHED if document.get("unfinished") else DONE
        body: FullBody | ShortBody = (
            {"interpretation": document} if self.settings.full else short(document, self.settings.worlds)
        )
        return status, self._line(frame, status, body, sha256)

    def wrong(self, frame: Frame, message: str, sha256: str | None) -> tuple[str, bytes]:
        """Status and line of a bad frame."""
        return ERROR, self._line(frame, ERROR, {"error": message}, sha256)

    def given_up(self, frame: Frame, message: str) -> tuple[str, bytes]:
        """As ``wrong``, of a frame whose worker is gone and cannot say what it read: as it is now."""
        return self.wrong(frame, message, digest_of(frame, self.settings.camera))

    def _line(self, frame: Frame, status: str, body: FullBody | ShortBody | ErrorBody, sha256: str | None) -> bytes:
        head = {"format": FORMAT, "input": frame.input, "frame": frame.frame, "status": status}
        origin = {"sha256": sha256, "kb": dict(self.kb), "options": self.settings.document()}
        text = json.dumps({**head, **origin, **body}, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        return (
            text.encode("utf-8", "backslashreplace") + b"\n"
        )  # of a file's name that is no text: \udc80, as JSON writes it


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
