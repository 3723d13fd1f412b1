"""Which dataset a folder is: a whole dataset, one split of it, or one scene."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from geometry.files.plain_files import IS_FOLDER, IS_MISSING, fault_of, is_there
from plogic.base.errors import InputError
from plogic.run.bop.dataset import Dataset, Scene
from plogic.run.bop.json_files import member, number_of, read_json, shown, whole

if TYPE_CHECKING:
    from collections.abc import Sequence

TARGETS = "test_targets_bop19.json"
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
    listed = next((root / TARGETS for root in roots if is_there(root / TARGETS)), None)
    targets = read_targets(listed) if listed is not None and split.name.startswith("test") else None
    if targets is not None and len(read) == 1 and folder == scenes[0]:
        targets = {key: wanted for key, wanted in targets.items() if key[0] in read}
    return Dataset(folder, tuple(read.values()), targets, _models(roots), tuple(wrong))


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
        raise InputError(f"{path}: must be a list of targets, not {shown(entries)}")
    targets: dict[tuple[int, int], dict[int, int]] = {}
    for i, entry in enumerate(entries):
        keys = ("scene_id", "im_id", "obj_id", "inst_count")
        scene_id, im_id, obj_id, count = (
            whole(member(entry, key, f"{path}: {i}"), f"{path}: {i}.{key}") for key in keys
        )
        targets.setdefault((scene_id, im_id), {})[obj_id] = count
    return targets
