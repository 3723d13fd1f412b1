"""From what a user names to frames: files, folders, patterns, BOP datasets, and lists of all these on standard input."""

from __future__ import annotations

import glob
import os
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING

from geometry.files.plain_files import IS_FOLDER, IS_MISSING, fault_of
from plogic.base.errors import InputError
from plogic.run.batch.frames import Frame

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

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


def frames_of(inputs: Iterable[str], listed: Iterable[str]) -> list[Frame]:
    """Every frame once, in the order of the inputs, and inside a folder in that of names.

    ``-`` stands for the lines of ``listed``.

    An input that leads to no frame, or a folder that is no BOP dataset though it looks like one, is a lost frame.
    Raises InputError where there is no input at all.
    """
    named = (name for given in inputs for name in (_lines(listed) if given == "-" else [given]))
    found = {(frame.input, frame.frame): frame for name in named for frame in _frames(name)}
    if not found:
        raise InputError("there is no input")
    return list(found.values())


def _lines(listed: Iterable[str]) -> Iterator[str]:
    return (line for line in (line.rstrip("\r\n") for line in listed) if line)


def _frames(name: str) -> list[Frame]:
    path = Path(name)
    fault = fault_of(path)
    if fault == IS_MISSING and glob.has_magic(name):
        found = [frame for match in sorted(glob.glob(name, recursive=True)) for frame in _frames(match)]  # noqa: PTH207 - any path's pattern
    elif fault == IS_FOLDER:
        found = _of_dataset(path) if any(any(path.glob(pattern)) for pattern in DATASET) else _of_folder(path)
    else:
        return [_of_file(path)]
    return found or [_lost(name, "leads to no picture and no Γ")]


def _of_file(path: Path) -> Frame:
    """A picture or Γ; lost where it is no plain file that may be read."""
    fault = fault_of(path)
    if fault is not None:
        return _lost(str(path), fault)
    return Frame(str(path), None, "gamma" if path.suffix.lower() == ".json" else "image")


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
    from plogic.run.bop.folders import open_dataset

    try:
        dataset = open_dataset(folder)
    except InputError as error:
        return [Frame(str(folder), None, "lost", str(error))]
    keys, wrong = dataset.listed()
    places = {scene.scene_id: str(scene.folder) for scene in dataset.scenes}
    frames = [Frame(str(folder), f"{scene:06d}/{image:06d}", "bop", places[scene]) for scene, image in keys]
    return frames + ([Frame(str(folder), None, "lost", "\n".join(wrong))] if wrong else [])
