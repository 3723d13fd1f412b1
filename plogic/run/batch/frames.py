"""One frame of many, and how it is to be perceived.

* ``Frame("scenes/7/image.png", None, "image")``; of a BOP dataset ``Frame("lmo", "000002/000017", "bop",
  "/data/lmo/test/000002")``; of a video ``Frame("clip.mp4", "clip_000012", "video")``
* ``Settings("towers", camera=None, reading="posterior")``

``frames_of`` leads to them from what a user names: files, folders, patterns, videos, BOP datasets, and lists of all
these on standard input.
"""

import glob
import hashlib
import json
import os
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NotRequired, TypedDict

from geometry.errors import PlogicError
from geometry.files.plain_files import IS_FOLDER, IS_MISSING, fault_of
from plogic.base.errors import InputError
from plogic.facts.situation import Reading, Reconsider
from plogic.run.cameras import NOTHING_GIVEN, GivenCamera, camera_beside
from plogic.run.video.video import counted, frame_name, is_video

if TYPE_CHECKING:
    from plogic.run.bop.dataset import Scene


Kind = Literal["gamma", "image", "video", "bop", "lost"]

SCENES = 4
"""BOP scenes whose cameras are kept."""
VIDEOS_HASHED = 8
"""Videos whose digests are kept."""
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

    reading: Annotated[Reading, "How probabilities are read."]
    reconsider: Annotated[Reconsider, "What becomes of a feature that an accepted hypothesis hides."]
    smoothing: Annotated[float, "Added to each count before P(ev)."]
    deadline: Annotated[float | None, "Seconds that a frame may take; null: as long as it takes."]
    full: NotRequired[Annotated[bool, "Whether lines have whole interpretations."]]
    worlds: NotRequired[Annotated[int, "How many worlds a line lists."]]
    fov: NotRequired[Annotated[float, "Field of view across pictures, degrees, where it was given."]]
    fov_diagonal: NotRequired[Annotated[float, "Field of view from corner to corner, degrees, where it was given."]]
    focal: NotRequired[Annotated[float, "Focal length of pictures, pixels, where it was given."]]


@dataclass(frozen=True, slots=True)
class Settings:
    """What decides a frame's line besides the frame.

    The KB, the camera that was given for all pictures, and the options.

    ``worlds``: as many are listed; ``full``: the whole interpretation is.
    """

    kb: str
    camera: GivenCamera = NOTHING_GIVEN
    reading: Reading = "score"
    reconsider: Reconsider = "to_B"
    smoothing: float = 0.0
    deadline: float | None = None
    worlds: int = 10
    full: bool = False

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> "Settings":
        """The settings that ``dataclasses.asdict`` made a row of, for another process."""
        return cls(**{**row, "camera": GivenCamera(**row["camera"])})

    def document(self) -> SettingsRow:
        """The options as every line tells them."""
        chosen: SettingsRow = {
            "reading": self.reading,
            "reconsider": self.reconsider,
            "smoothing": self.smoothing,
            "deadline": self.deadline,
        }
        if self.camera.fov is not None:
            chosen["fov"] = self.camera.fov
        if self.camera.fov_diagonal is not None:
            chosen["fov_diagonal"] = self.camera.fov_diagonal
        if self.camera.focal is not None:
            chosen["focal"] = self.camera.focal
        return {**chosen, "full": True} if self.full else {**chosen, "worlds": self.worlds}


def checked(path: str | Path) -> None:
    """Raise InputError for what is no plain file that may be read: a pipe would never end."""
    fault = fault_of(Path(path))
    if fault is not None:
        raise InputError(f"{path}: {fault}")


def scene_and_image(frame: Frame) -> tuple[int, int]:
    """The numbers of a BOP frame."""
    scene, _, image = str(frame.frame).partition("/")
    return int(scene), int(image)


def number_in_video(frame: Frame) -> int:
    """The number of a video's frame; the first is 0."""
    return int(str(frame.frame).rpartition("_")[2])


def scene_at(folder: str, number: int) -> "Scene":
    """The scene of a folder, whose cameras are parsed once for as long as their file does not change."""
    return _scene(folder, number, version_of(Path(folder) / "scene_camera.json"))


def version_of(path: Path) -> tuple[int, ...]:
    """What changes where a file does; nothing where there is none."""
    try:
        found = path.stat()
    except OSError:
        return ()
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


@lru_cache(SCENES)
def _scene(folder: str, number: int, _version: tuple[int, ...]) -> "Scene":
    from plogic.run.bop.dataset import Scene

    return Scene(Path(folder), number)


def digest_of(frame: Frame, camera: GivenCamera, *, nested: bool = False) -> str | None:
    """SHA-256 (hexadecimal) of all that a frame's line is made of, its camera too.

    None where some of it cannot be read.

    ``nested``: each file counts by its own SHA-256, as in files of lines that an earlier plogic wrote.
    """
    total = hashlib.sha256()
    try:
        for part in _parts(frame, camera):
            if frame.kind == "video" and part == Path(frame.input):  # the same for each of its frames
                total = _video_hash(part, version_of(part)).copy()
                continue
            for piece in (
                [part.encode()] if isinstance(part, str) else [_file_digest(part)] if nested else _pieces(part)
            ):
                total.update(piece)
    except (OSError, ValueError):
        return None
    return total.hexdigest()


def _parts(frame: Frame, camera: GivenCamera) -> list[Path | str]:
    """Files, and what is text."""
    if frame.kind == "lost":
        return [frame.at]
    if frame.kind == "bop":
        scene, image = scene_and_image(frame)
        try:
            read = scene_at(frame.at, scene)
            return [read.picture(image), json.dumps(read.cameras[image], sort_keys=True)]
        except (PlogicError, KeyError) as error:
            raise ValueError(frame.frame) from error
    if frame.kind == "gamma":
        return [Path(frame.input)]
    try:
        return [Path(frame.input), *camera_beside(frame.input, camera).parts(frame.input)]
    except PlogicError as error:
        raise ValueError(frame.input) from error


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


@lru_cache(VIDEOS_HASHED)
def _video_hash(path: Path, _version: tuple[int, ...]) -> "hashlib._Hash":
    """That of its bytes, which is gone on with. Raises OSError and ValueError."""
    total = hashlib.sha256()
    for piece in _pieces(path):
        total.update(piece)
    return total


PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm")
"""Endings of what is a picture in a folder; a file that is named is one whatever its ending, unless it is JSON."""
NO_GAMMA = (
    "camera.json",
    "truth.json",
    "interpretation.json",
    "timings.json",
    "poses.json",
    "panorama.json",
    "next-view.json",
    "worlds.json",
)
"""How the names of JSON files end that stand beside pictures and are no Γ."""
DRAWN = ("picture.png", "posterior-picture.png", "views.png")
"""What ``plogic demo`` draws beside the ``interpretation.json`` that it writes."""
DATASET = ("scene_camera.json", "[0-9]*/scene_camera.json", "*/[0-9]*/scene_camera.json")
"""What tells a BOP dataset: its scene's, its split's or its own folder holds one of these."""


def frames_of(inputs: Iterable[str], listed: Iterable[str], every: int = 1) -> list[Frame]:
    """Every frame once, in the order of the inputs, and inside a folder in that of names.

    ``-`` stands for the lines of ``listed``; of a video, which is one that is named, each ``every``-th frame counts.

    An input that leads to no frame, or a folder that is no BOP dataset though it looks like one, is a lost frame.
    Raises InputError where there is no input at all.
    """
    named = (name for given in inputs for name in (_lines(listed) if given == "-" else [given]))
    found = {(frame.input, frame.frame): frame for name in named for frame in _frames(name, every)}
    if not found:
        raise InputError("there is no input")
    return list(found.values())


def _lines(listed: Iterable[str]) -> Iterator[str]:
    return (line for line in (line.rstrip("\r\n") for line in listed) if line)


def _frames(name: str, every: int) -> list[Frame]:
    path = Path(name)
    fault = fault_of(path)
    if fault == IS_MISSING and glob.has_magic(name):
        found = [frame for match in sorted(glob.glob(name, recursive=True)) for frame in _frames(match, every)]  # noqa: PTH207 - any path's pattern
    elif fault == IS_FOLDER:
        found = _of_dataset(path) if any(any(path.glob(pattern)) for pattern in DATASET) else _of_folder(path)
    elif fault is None and is_video(name):
        found = _of_video(path, every)
    else:
        return [_of_file(path)]
    return found or [_lost(name, "leads to no picture and no Γ")]


def _of_file(path: Path) -> Frame:
    """A picture or Γ; lost where it is no plain file that may be read."""
    fault = fault_of(path)
    if fault is not None:
        return _lost(str(path), fault)
    return Frame(str(path), None, "gamma" if path.suffix.lower() == ".json" else "image")


def _of_video(path: Path, every: int) -> list[Frame]:
    """Its frames, as many as can be decoded, and a lost one for what cannot."""
    frames, fault = counted(path)
    found = [Frame(str(path), frame_name(path, number), "video") for number in range(0, frames, every)]
    return found + ([Frame(str(path), None, "lost", fault)] if fault is not None else [])


def _of_folder(folder: Path) -> list[Frame]:
    """All pictures and Γ files below it, and lost ones for folders that cannot be read; hidden files and folders aside.

    Links to folders are followed once what is no link has been looked through; each folder is looked through once,
    whatever its names.
    """
    found: list[Frame] = []
    unread: list[OSError] = []
    tops, seen = deque([folder]), set[str]()
    while tops:
        for place, folders, files in os.walk(tops.popleft(), onerror=unread.append):
            if (real := os.path.realpath(place)) in seen:
                folders.clear()
                continue
            seen.add(real)
            folders[:] = sorted(name for name in folders if not name.startswith("."))
            tops += [path for name in folders if (path := Path(place, name)).is_symlink()]
            found += [_of_file(Path(place, name)) for name in _frames_among(files)]
    found += [_lost(error.filename, f"cannot be read: {error.strerror}") for error in unread]
    return sorted(found, key=lambda frame: Path(frame.input))


def _frames_among(files: Sequence[str]) -> list[str]:
    drawn = DRAWN if "interpretation.json" in files else ()
    return [name for name in files if not name.startswith(".") and name not in drawn and _is_frame(name.lower())]


def _lost(name: str, reason: str) -> Frame:
    return Frame(name, None, "lost", f"{name}: {reason}")


def _is_frame(name: str) -> bool:
    return name.endswith(PICTURES) or (name.endswith(".json") and not name.endswith(NO_GAMMA))


def _of_dataset(folder: Path) -> list[Frame]:
    """Its frames, and one that is lost for all scenes that cannot be read, or have the number of another."""
    from plogic.run.bop.dataset import open_dataset

    try:
        dataset = open_dataset(folder)
    except InputError as error:
        return [Frame(str(folder), None, "lost", str(error))]
    keys, wrong = dataset.listed()
    places = {scene.scene_id: str(scene.folder) for scene in dataset.scenes}
    frames = [Frame(str(folder), f"{scene:06d}/{image:06d}", "bop", places[scene]) for scene, image in keys]
    return frames + ([Frame(str(folder), None, "lost", "\n".join(wrong))] if wrong else [])
