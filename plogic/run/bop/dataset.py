"""A BOP dataset's folder, read frame by frame.

* ``Truth``, one annotated object: ``Truth(5, camera_from_object, 0.93)``
* ``Frame``, one picture with its camera: ``Frame(1, 3, image, camera)``
* ``Scene``, a folder with ``scene_camera.json``; ``Dataset``, its scenes, with the targets and the models' folder where
  there are any

``open_dataset`` finds out which dataset a folder is: a whole dataset, one split of it, or one scene.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera, camera_from_dict
from geometry.errors import CameraError
from geometry.files.camera_files import from_bop_scene
from geometry.files.plain_files import IS_FOLDER, IS_MISSING, fault_of, is_there
from plogic.base.errors import InputError
from plogic.run.bop.json_files import (
    Place,
    entry_of,
    fraction,
    member,
    motion,
    number_of,
    numbered,
    numbers,
    read_json,
    shown,
    whole,
)
from sensing.files.images import read_image

PICTURES = tuple(
    f"{folder}/{{:06d}}.{ending}" for folder in ("rgb", "gray") for ending in ("png", "jpg", "jpeg", "tif")
)
"""Where a frame's picture may be, the first that exists."""


@dataclass(frozen=True, eq=False)
class Truth:
    """One object of a frame's ground truth: ``camera_from_object`` (4, 4) m.

    ``visible`` fraction, None where nobody says.
    """

    obj_id: int
    camera_from_object: NDArray[np.float64]
    visible: float | None = None


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture (H, W, 3) uint8, blue first, and its camera, metres."""

    scene_id: int
    im_id: int
    image: NDArray[np.uint8]
    camera: Camera


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene's folder; its JSON files are read when they are first asked for."""

    folder: Path
    scene_id: int

    @cached_property
    def cameras(self) -> Mapping[int, Any]:
        """Entries of ``scene_camera.json`` by image. Raises InputError."""
        return numbered(self.folder / "scene_camera.json")

    @cached_property
    def _annotations(self) -> Mapping[int, Any] | None:
        path = self.folder / "scene_gt.json"
        return numbered(path) if is_there(path) else None

    @cached_property
    def _visibility(self) -> Mapping[int, Any] | None:
        path = self.folder / "scene_gt_info.json"
        return numbered(path) if is_there(path) else None

    def frame(self, im_id: int) -> Frame:
        """Picture and camera of one image. Raises InputError, ImageError, CameraError: one line with file and key."""
        entry = entry_of(self.cameras, im_id, self.folder / "scene_camera.json")
        image = read_image(self.picture(im_id))
        return Frame(self.scene_id, im_id, image, self._camera(im_id, entry, (image.shape[1], image.shape[0])))

    def picture(self, im_id: int) -> Path:
        """The picture's file. Raises InputError where there is none."""
        found = next(
            (
                self.folder / name.format(im_id)
                for name in PICTURES
                if fault_of(self.folder / name.format(im_id)) is None
            ),
            None,
        )
        if found is None:
            raise InputError(f"{self.folder}: has no picture {im_id:06d} (png, jpg, jpeg or tif) in rgb/ or gray/")
        return found

    def truths(self, im_id: int) -> tuple[Truth, ...] | None:
        """What stands before the camera; None where the scene has no ``scene_gt.json``. Raises InputError."""
        if self._annotations is None:
            return None
        path = self.folder / "scene_gt.json"
        entries = _listed(entry_of(self._annotations, im_id, path), Place(path, (im_id,)))
        visible = self._visible(im_id, len(entries))
        return tuple(_truth(entry, visible[i], Place(path, (im_id, i))) for i, entry in enumerate(entries))

    def _visible(self, im_id: int, count: int) -> list[float | None]:
        if self._visibility is None:
            return [None] * count
        path = self.folder / "scene_gt_info.json"
        infos = _listed(entry_of(self._visibility, im_id, path), Place(path, (im_id,)))
        if len(infos) != count:
            raise InputError(f"{Place(path, (im_id,))}: has {len(infos)} entries, but scene_gt.json has {count}")
        places = [Place(path, (im_id, i)) for i in range(count)]
        return [
            fraction(member(info, "visib_fract", at), at.at("visib_fract"))
            for info, at in zip(infos, places, strict=True)
        ]

    def _camera(self, im_id: int, entry: object, size: tuple[int, int]) -> Camera:
        """The camera of one entry; its size is the picture's."""
        place = Place(self.folder / "scene_camera.json", (im_id,))
        numbers(member(entry, "cam_K", place), 9, place.at("cam_K"))
        content: dict[str, Any] = {"cam_K": entry["cam_K"]} if isinstance(entry, dict) else {}
        if isinstance(entry, dict) and "cam_R_w2c" in entry:
            t_mm = numbers(member(entry, "cam_t_w2c", place), 3, place.at("cam_t_w2c"))
            pose = motion(numbers(entry["cam_R_w2c"], 9, place.at("cam_R_w2c")), t_mm, place.at("cam_R_w2c"))
            content |= {"cam_R_w2c": pose[:3, :3].ravel().tolist(), "cam_t_w2c": t_mm.tolist()}
        try:
            return camera_from_dict(from_bop_scene(content, size))
        except CameraError as error:
            raise InputError(f"{place}: {error}") from None


@dataclass(frozen=True, eq=False)
class Dataset:
    """``targets``: per (scene, image) the wanted instances by object; None: every image, every object.

    ``models``: their folder. ``ids``: the numbers of the types, a file that ``plogic simulate --bop`` writes.

    ``wrong``: a line for each folder that would be a scene and is left out.
    """

    folder: Path
    scenes: tuple[Scene, ...]
    targets: Mapping[tuple[int, int], Mapping[int, int]] | None = None
    models: Path | None = None
    wrong: tuple[str, ...] = ()
    ids: Path | None = None

    def scene(self, scene_id: int) -> Scene:
        """The scene of a number; raises KeyError."""
        return {scene.scene_id: scene for scene in self.scenes}[scene_id]

    def listed(self) -> tuple[list[tuple[int, int]], list[str]]:
        """(scene, image) of every wanted frame, in order, and a line for each scene unread or left out."""
        if self.targets is not None:
            here = {scene.scene_id for scene in self.scenes}
            absent = sorted({s for s, _ in self.targets if s not in here})
            lines = [f"{self.folder}: has no scene {s:06d}, which the targets name" for s in absent]
            return sorted(key for key in self.targets if key[0] in here), [*lines, *self.wrong]
        names, lines = [], list(self.wrong)
        for scene in self.scenes:
            try:
                names += [(scene.scene_id, im_id) for im_id in sorted(scene.cameras)]
            except InputError as error:
                lines.append(str(error))
        return names, lines


def _listed(value: object, place: Place) -> list[Any]:
    if not isinstance(value, list):
        raise InputError(f"{place}: must be a list, not {shown(value)}")
    return value


def _truth(entry: object, visible: float | None, place: Place) -> Truth:
    R = numbers(member(entry, "cam_R_m2c", place), 9, place.at("cam_R_m2c"))
    t_mm = numbers(member(entry, "cam_t_m2c", place), 3, place.at("cam_t_m2c"))
    return Truth(
        whole(member(entry, "obj_id", place), place.at("obj_id")), motion(R, t_mm, place.at("cam_R_m2c")), visible
    )


TARGETS = "test_targets_bop19.json"
IDS = "ids.json"
MODELS = ("models_eval", "models")


def open_dataset(folder: str | Path) -> Dataset:
    """The dataset of a scene's folder, a split's (``test``) or a whole dataset's.

    Of a whole one the split is ``test``, or the only ``test_*``. Targets are read for splits of tests alone. A scene
    whose folder is no number is scene 0. Beside scenes a numbered folder with pictures, or one that cannot be looked
    into, is one too, that cannot be read; of two with one number the first by name is taken, and the other is
    ``wrong``. No picture and no annotation is read yet.

    Raises:
        InputError: It is none of these, or its targets have a mistake.
    """
    path = Path(os.path.realpath(folder))
    fault = fault_of(path)
    if fault != IS_FOLDER:
        raise InputError(f"{folder}: {'is no folder' if fault in (None, IS_MISSING) else fault}")
    if _is_scene(path):
        return _dataset(path, [path], path.parent, [path, path.parent.parent, path.parent])
    split = path if _scenes(path) else _split(path, folder)
    return _dataset(path, _scenes(split), split, [split.parent, split] if split == path else [path])


def _dataset(folder: Path, scenes: Sequence[Path], split: Path, roots: Sequence[Path]) -> Dataset:
    read: dict[int, Scene] = {}
    wrong: list[str] = []
    for path in scenes:
        scene = Scene(path, number_of(path.name) or 0)
        first = read.setdefault(scene.scene_id, scene)
        if first is not scene:
            wrong.append(f"{path}: is scene {scene.scene_id}, as {first.folder.name}/ beside it is, which is taken")
    listed, ids = (next((root / name for root in roots if is_there(root / name)), None) for name in (TARGETS, IDS))
    targets = read_targets(listed) if listed is not None and split.name.startswith("test") else None
    if targets is not None and len(read) == 1 and folder == scenes[0]:
        targets = {key: wanted for key, wanted in targets.items() if key[0] in read}
    return Dataset(folder, tuple(read.values()), targets, _models(roots), tuple(wrong), ids)


def _is_scene(path: Path) -> bool:
    return is_there(path / "scene_camera.json")


def _scenes(path: Path) -> list[Path]:
    """The scenes of a split, by number and name; none where no folder is one for sure."""
    numbered = [p for p in _inside(path) if number_of(p.name) is not None]
    if not any(_is_scene(p) for p in numbered):
        return []
    return sorted((p for p in numbered if _is_scene(p) or _should_be(p)), key=lambda p: (int(p.name), p.name))


def _should_be(path: Path) -> bool:
    """Whether a numbered folder beside scenes holds what one does, or hides what it holds."""
    return path.is_dir() and (
        is_there(path / "rgb") or is_there(path / "gray") or not os.access(path, os.R_OK | os.X_OK)
    )


def _inside(path: Path) -> list[Path]:
    """What a folder holds, by name. Raises InputError."""
    try:
        return sorted(path.iterdir())
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def _split(path: Path, named: str | Path) -> Path:
    splits = [p for p in _inside(path) if p.is_dir() and os.access(p, os.R_OK) and _scenes(p)]
    tests = [p for p in splits if p.name == "test"] or [p for p in splits if p.name.startswith("test_")]
    if len(tests) == 1:
        return tests[0]
    if splits:
        raise InputError(f"{named}: give one of its splits: {', '.join(p.name for p in tests or splits)}")
    raise InputError(
        f"{named}: is no BOP dataset: a folder with scene_camera.json, or with test/000001/scene_camera.json, is needed"
    )


def _models(roots: Sequence[Path]) -> Path | None:
    """The first folder with a ``models_info.json``: for evaluation, else ``models``, else another (``models_cad``)."""
    for root in roots:
        names = [*MODELS, *sorted(p.name for p in root.glob("models_*"))]
        found = next((root / name for name in names if is_there(root / name / "models_info.json")), None)
        if found is not None:
            return found
    return None


def read_targets(path: Path) -> dict[tuple[int, int], dict[int, int]]:
    """``test_targets_bop19.json``: per (scene, image) how many instances of which object are wanted.

    Raises InputError.
    """
    fault = fault_of(path)
    if fault is not None:
        raise InputError(f"{path}: {fault}")
    entries = read_json(path)
    if not isinstance(entries, list):
        raise InputError(f"{Place(path)}: must be a list of targets, not {shown(entries)}")
    targets: dict[tuple[int, int], dict[int, int]] = {}
    for i, entry in enumerate(entries):
        keys = ("scene_id", "im_id", "obj_id", "inst_count")
        scene_id, im_id, obj_id, count = (
            whole(member(entry, key, Place(path, (i,))), Place(path, (i, key))) for key in keys
        )
        targets.setdefault((scene_id, im_id), {})[obj_id] = count
    return targets
