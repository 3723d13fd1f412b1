"""Which dataset a folder is: a whole dataset, one split of it, or one scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from plogic.bop.dataset import Dataset, Scene
from plogic.bop.json_files import member, read_json, shown, whole
from plogic.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

TARGETS = "test_targets_bop19.json"
MODELS = ("models_eval", "models")


def open_dataset(folder: str | Path) -> Dataset:
    """The dataset of a scene's folder, a split's (``test``) or a whole dataset's.

    Of a whole one the split is ``test``, or the only ``test_*``. Targets are read for splits of tests alone. A scene whose folder is no
    number is scene 0. No picture and no annotation is read yet.

    Raises:
        InputError: It is none of these, or its targets have a mistake.
    """
    path = Path(folder).resolve()
    if not path.is_dir():
        raise InputError(f"{folder}: is no folder")
    if _is_scene(path):
        return _dataset(path, [path], path.parent, [path, path.parent.parent, path.parent])
    split = path if _scenes(path) else _split(path, folder)
    return _dataset(path, _scenes(split), split, [split.parent, split] if split == path else [path])


def _dataset(folder: Path, scenes: Sequence[Path], split: Path, roots: Sequence[Path]) -> Dataset:
    read = tuple(Scene(scene, int(scene.name) if scene.name.isdigit() else 0) for scene in scenes)
    listed = next((root / TARGETS for root in roots if (root / TARGETS).is_file()), None)
    targets = read_targets(listed) if listed is not None and split.name.startswith("test") else None
    if targets is not None and len(read) == 1 and folder == scenes[0]:
        targets = {key: wanted for key, wanted in targets.items() if key[0] == read[0].scene_id}
    return Dataset(folder, read, targets, _models(roots))


def _is_scene(path: Path) -> bool:
    return (path / "scene_camera.json").is_file()


def _scenes(path: Path) -> list[Path]:
    return sorted((p for p in path.iterdir() if p.name.isdigit() and _is_scene(p)), key=lambda p: int(p.name))


def _split(path: Path, named: str | Path) -> Path:
    splits = [p for p in sorted(path.iterdir()) if p.is_dir() and _scenes(p)]
    tests = [p for p in splits if p.name == "test"] or [p for p in splits if p.name.startswith("test_")]
    if len(tests) == 1:
        return tests[0]
    if splits:
        raise InputError(f"{named}: give one of its splits: {', '.join(p.name for p in tests or splits)}")
    raise InputError(f"{named}: is no BOP dataset: a folder with scene_camera.json, or with test/000001/scene_camera.json, is needed")


def _models(roots: Sequence[Path]) -> Path | None:
    """The first folder with a ``models_info.json``: for evaluation, else ``models``, else another (``models_cad``)."""
    for root in roots:
        names = [*MODELS, *sorted(p.name for p in root.glob("models_*"))]
        found = next((root / name for name in names if (root / name / "models_info.json").is_file()), None)
        if found is not None:
            return found
    return None


def read_targets(path: Path) -> dict[tuple[int, int], dict[int, int]]:
    """``test_targets_bop19.json``: per (scene, image) how many instances of which object are wanted. Raises InputError."""
    entries = read_json(path)
    if not isinstance(entries, list):
        raise InputError(f"{path}: must be a list of targets, not {shown(entries)}")
    targets: dict[tuple[int, int], dict[int, int]] = {}
    for i, entry in enumerate(entries):
        keys = ("scene_id", "im_id", "obj_id", "inst_count")
        scene_id, im_id, obj_id, count = (whole(member(entry, key, f"{path}: {i}"), f"{path}: {i}.{key}") for key in keys)
        targets.setdefault((scene_id, im_id), {})[obj_id] = count
    return targets
