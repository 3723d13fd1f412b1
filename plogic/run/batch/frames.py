"""One frame of many, and how it is to be perceived.

* ``Frame("scenes/7/image.png", None, "image")``; of a BOP dataset ``Frame("lmo", "000002/000017", "bop",
  "/data/lmo/test/000002")``
* ``Settings("towers", camera=None, reading="posterior")``
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NotRequired, TypedDict

from geometry.files.plain_files import fault_of, is_there

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.facts.situation import Reading, Reconsider
    from plogic.run.bop.dataset import Scene

Kind = Literal["gamma", "image", "bop", "lost"]

SCENES = 4
"""BOP scenes whose cameras are kept."""
PIECE = 1 << 20
"""Bytes of a file that are hashed at a time."""


@dataclass(frozen=True, slots=True)
class Frame:
    """``input`` as it was named, and ``frame`` within it where it holds many: together they tell frames apart.

    ``at``: of a BOP frame its scene's folder; of a lost one, which cannot even be tried, what is wrong with it.
    """

    input: str
    frame: str | None
    kind: Kind
    at: str = ""

    @property
    def name(self) -> str:
        """As people are told."""
        return self.input if self.frame is None else f"{self.input} {self.frame}"


class SettingsRow(TypedDict):
    """The options of a frame's line."""

    reading: Reading
    reconsider: Reconsider
    smoothing: float
    deadline: float | None
    full: NotRequired[bool]
    worlds: NotRequired[int]


@dataclass(frozen=True, slots=True)
class Settings:
    """What decides a frame's line besides the frame: the KB, the camera of pictures that have none beside them, and the options.

    ``worlds``: as many are listed; ``full``: the whole interpretation is.
    """

    kb: str
    camera: str | None = None
    reading: Reading = "score"
    reconsider: Reconsider = "to_B"
    smoothing: float = 0.0
    deadline: float | None = None
    worlds: int = 10
    full: bool = False

    def document(self) -> SettingsRow:
        """The options as every line tells them."""
        chosen: SettingsRow = {
            "reading": self.reading,
            "reconsider": self.reconsider,
            "smoothing": self.smoothing,
            "deadline": self.deadline,
        }
        return {**chosen, "full": True} if self.full else {**chosen, "worlds": self.worlds}


def camera_of(frame: Frame, camera: str | None) -> str | None:
    """The camera file of a picture: the one that was given for all, else ``camera.json`` beside it.

    None where there is neither.
    """
    beside = Path(frame.input).parent / "camera.json"
    return camera if camera is not None or not is_there(beside) else str(beside)


def scene_and_image(frame: Frame) -> tuple[int, int]:
    """The numbers of a BOP frame."""
    scene, _, image = str(frame.frame).partition("/")
    return int(scene), int(image)


def scene_at(folder: str, number: int) -> Scene:
    """The scene of a folder, whose cameras are parsed once for as long as their file does not change."""
    try:
        found = (Path(folder) / "scene_camera.json").stat()
    except OSError:
        return _scene(folder, number, ())
    return _scene(folder, number, (found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns))


@lru_cache(SCENES)
def _scene(folder: str, number: int, _version: tuple[int, ...]) -> Scene:
    from plogic.run.bop.dataset import Scene

    return Scene(Path(folder), number)


def digest_of(frame: Frame, camera: str | None, *, nested: bool = False) -> str | None:
    """SHA-256 (hexadecimal) of all that a frame's line is made of, its camera too.

    None where some of it cannot be read.

    ``nested``: each file counts by its own SHA-256, as in files of lines that an earlier plogic wrote.
    """
    total = hashlib.sha256()
    try:
        for part in _parts(frame, camera):
            for piece in (
                [part.encode()] if isinstance(part, str) else [_file_digest(part)] if nested else _pieces(part)
            ):
                total.update(piece)
    except (OSError, ValueError):
        return None
    return total.hexdigest()


def _parts(frame: Frame, camera: str | None) -> list[Path | str]:
    """Files, and what is text."""
    from geometry.errors import PlogicError

    if frame.kind == "lost":
        return [frame.at]
    if frame.kind == "bop":
        scene, image = scene_and_image(frame)
        try:
            read = scene_at(frame.at, scene)
            return [read.picture(image), json.dumps(read.cameras[image], sort_keys=True)]
        except (PlogicError, KeyError) as error:
            raise ValueError(frame.frame) from error
    with_camera = camera_of(frame, camera) if frame.kind == "image" else None
    return [Path(frame.input), *([Path(with_camera)] if with_camera is not None else [])]


def _pieces(path: Path) -> Iterator[bytes]:
    """The bytes of a plain file. Raises OSError and ValueError."""
    if fault_of(path) is not None:  # a pipe would never end
        raise ValueError(path)
    with path.open("rb") as file:
        while piece := file.read(PIECE):
            yield piece


def _file_digest(path: Path) -> bytes:
    digest = hashlib.sha256()
    for piece in _pieces(path):
        digest.update(piece)
    return digest.digest()
