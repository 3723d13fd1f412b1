"""From what an author wrote to the tree's description: of a good document, and, leniently, of any document that mistakes are sought in."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.frames import rotation_from_quat_xyzw
from kb.clouds.lobes import Lobe
from kb.clouds.tree import Branch, Kind
from kb.files.schema import AppearanceModel, FeatureModel, ObjectModel, PartModel, RotationModel
from kb.files.yaml_text import Path

LISTS: dict[str, Kind] = {"parts": "object", "features": "feature", "appearances": "appearance"}
"""The keys whose lists hold what a node is made of, in the order of ``Branch.parts``, and what they should hold."""


def branch_of(model: ObjectModel) -> Branch:
    """The description of a checked document."""
    return Branch("object", model.object, model.object, parts=_held(model))


def _held(model: ObjectModel | PartModel) -> list[Branch]:
    return [_part(part) for part in model.parts] + [_feature(feature) for feature in model.features]


def _part(model: PartModel) -> Branch:
    kind = model.type or model.part
    return Branch("object", model.part, kind, model.at, rotation_matrix(model.rotation), _held(model))


def _feature(model: FeatureModel) -> Branch:
    parts = [_feature(part) for part in model.features] + [_appearance(part) for part in model.appearances]
    turn = rotation_matrix(model.rotation)
    return Branch("feature", model.feature, model.type, model.at, turn, parts, arms=model.arms)


def _appearance(model: AppearanceModel) -> Branch:
    cone = model.lobe
    size = np.nan if model.size is None else model.size
    lobe = None if cone is None else Lobe(np.array(cone.axis), cone.half_angle, cone.range[0], cone.range[1], size)
    parts = [_appearance(part) for part in model.appearances]
    return Branch("appearance", "", model.type, parts=parts, lobe=lobe)


def rotation_matrix(model: RotationModel | None) -> NDArray[np.float64]:
    """parent_from_child (3, 3)."""
    if model is None:
        return np.eye(3)
    if model.quat_xyzw is not None:
        return np.asarray(rotation_from_quat_xyzw(model.quat_xyzw))
    turns = [_about(axis, angle) for axis, angle in enumerate(model.euler_xyz or ())]
    return np.asarray(turns[2] @ turns[1] @ turns[0])


def _about(axis: int, angle: float) -> NDArray[np.float64]:
    quat = [0.0, 0.0, 0.0, math.cos(angle / 2)]
    quat[axis] = math.sin(angle / 2)
    return np.asarray(rotation_from_quat_xyzw(quat))


def held(raw: object) -> Iterator[tuple[Path, Kind, Any]]:
    """What hangs directly below a node of any document: (keys from the node, kind, document), in the order of ``Branch.parts``."""
    for key, kind in LISTS.items():
        items = raw.get(key) if isinstance(raw, dict) else None
        for index, item in enumerate(items if isinstance(items, list) else ()):
            yield (key, index), _kind(item, kind), item


def _kind(item: object, usual: Kind) -> Kind:
    """What an entry says that it is, wherever it stands: a feature in a list of parts is a feature."""
    if isinstance(item, dict) and "part" in item:
        return "object"
    return "feature" if isinstance(item, dict) and "feature" in item else usual


def outline(raw: object, kind: Kind = "object", index: int = 0) -> Branch:
    """The tree of any document, without its geometry.

    What has no name gets one of its own, its lack being another mistake.
    """
    entry = raw if isinstance(raw, dict) else {}
    name = entry.get("part", entry.get("feature", entry.get("object")))
    parts = [outline(item, sort, i) for i, (_, sort, item) in enumerate(held(raw))]
    plain = name if isinstance(name, str) and name and not set(name) & set("/#") else f"unnamed {index}"
    return Branch(kind, "" if kind == "appearance" else plain, "any", parts=parts)


def path_to(raw: object, indices: Sequence[int]) -> Path:
    """Keys from the document's root to the node that ``indices`` into ``Branch.parts`` lead to."""
    path: Path = ()
    for index in indices:
        step, raw = _held_at(raw, index)
        path += step
    return path


def _held_at(raw: object, index: int) -> tuple[Path, object]:
    """Of ``held`` the entry of this number, without the others."""
    rest = index
    for key in LISTS:
        items = raw.get(key) if isinstance(raw, dict) else None
        if not isinstance(items, list):
            continue
        if rest < len(items):
            return (key, rest), items[rest]
        rest -= len(items)
    raise IndexError(index)


def nodes(raw: object, path: Path = (), kind: Kind = "object") -> Iterator[tuple[Path, Kind, Any]]:
    """Every node of any document, from the root on."""
    yield path, kind, raw
    for step, sort, item in held(raw):
        yield from nodes(item, path + step, sort)


def misplaced(raw: object) -> list[Path]:
    """The entries of another kind than their list, in nodes whose parts are of several kinds: A1 says all that is wrong with them."""
    rows = ((path, list(held(item))) for path, _, item in nodes(raw))
    mixed = [(path, entries) for path, entries in rows if len({kind for _, kind, _ in entries}) > 1]
    return [path + step for path, entries in mixed for step, kind, _ in entries if LISTS[str(step[0])] != kind]
