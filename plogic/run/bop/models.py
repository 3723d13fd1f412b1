"""The objects' models: vertices, diameter and symmetries, in metres; and which BOP object a type of the KB is.

Symmetries of ``models_info.json`` as motions: the discrete ones, and the continuous ones in steps.

Hodaň et al., BOP Challenge 2020 on 6D Object Localization (ECCVW 2020), §2.2: continuous symmetries are discretised
such that the vertex farthest from the axis travels no more than ``step`` of the diameter between two turns; half a
circle of the diameter as its diameter is the bound, so that ⌈π / step⌉ turns serve every object.

A type is the object of its name, ``obj_000005``, or the one that a file says: ``{"003_cracker_box": 2}``.
"""

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.files.mesh_files import reason, scene_of
from geometry.files.plain_files import IS_MISSING, fault_of
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from plogic.base.errors import InputError
from plogic.run.bop.json_files import MM, Place, entry_of, member, motion, numbered, numbers, read_json, shown, whole

NAMED = re.compile(r"obj_0*(\d+)")


def ids_of(types: Sequence[str], stated: Mapping[str, int]) -> dict[str, int]:
    """The numbers of the types that have one, ``stated`` before what a name says.

    Raises InputError where two types have one number.
    """
    named = {name: int(match[1]) for name in types if (match := NAMED.fullmatch(name))}
    found = {name: stated.get(name, named.get(name, -1)) for name in types if name in stated or name in named}
    for name, number in found.items():
        twin = next(other for other, its in found.items() if its == number)
        if twin != name:
            raise InputError(f"{twin} and {name} are both BOP object {number}")
    return found


def read_ids(path: str | Path | None) -> dict[str, int]:
    """The numbers that a file states; none without a file. Raises InputError."""
    if path is None:
        return {}
    content = read_json(Path(path))
    if not isinstance(content, dict):
        raise InputError(f"{Place(Path(path))}: must be an object of numbers by type name, not {shown(content)}")
    return {name: whole(number, Place(Path(path), (name,))) for name, number in content.items()}


def unknown(
    types: Sequence[str], ids: Mapping[str, int], stated: Collection[str], models: Collection[int] | None
) -> list[str]:
    """A line for each name or number that leads nowhere.

    ``models``: the objects that the dataset has, None where it does not say.
    """
    lines = [
        f"{name}: has no BOP number: what is found of it is left out (name it obj_000001, or give --ids)"
        for name in types
        if name not in ids
    ]
    lines += [
        f"{name}: has a BOP number, but the knowledge base has no such type" for name in stated if name not in types
    ]
    lines += [
        f"{name}: the dataset has no object {n}" for name, n in ids.items() if models is not None and n not in models
    ]
    return lines


STEP = 0.01
"""``max_sym_disc_step`` of the BOP challenge: 315 turns about an axis of continuous symmetry."""


def symmetry_motions(info: object, place: Place, step: float = STEP) -> NDArray[np.float64]:
    """The motions (S, 4, 4), metres, object frame, of one model's entry; the identity is among them.

    Every discretised turn after every discrete motion; turns about two axes are not multiplied, as in the benchmark.
    Raises InputError.
    """
    discrete = np.array([np.eye(4), *_discrete(info, place)])
    turns = _turns(info, place, step)
    return discrete if not len(turns) else np.asarray(turns[None] @ discrete[:, None]).reshape(-1, 4, 4)


def _discrete(info: object, place: Place) -> list[NDArray[np.float64]]:
    motions = []
    for i, entry in enumerate(_entries(info, "symmetries_discrete", place)):
        at = place.at("symmetries_discrete", i)
        rows = numbers(entry, 16, at).reshape(4, 4)
        motions.append(motion(rows[:3, :3].ravel(), rows[:3, 3], at))
    return motions


def _turns(info: object, place: Place, step: float) -> NDArray[np.float64]:
    """Turns (S, 4, 4) about each continuous axis, angle 0 first; none without one."""
    count = math.ceil(math.pi / step)
    half = np.arange(count) * (math.pi / count)
    turns = [np.zeros((0, 4, 4))]
    for i, entry in enumerate(_entries(info, "symmetries_continuous", place)):
        at = place.at("symmetries_continuous", i)
        axis = numbers(member(entry, "axis", at), 3, at.at("axis"))
        offset = numbers(member(entry, "offset", at), 3, at.at("offset")) / MM
        if not np.linalg.norm(axis) > 0:
            raise InputError(f"{at.at('axis')}: must not be zero")
        quat = np.concatenate([np.sin(half)[:, None] * axis / np.linalg.norm(axis), np.cos(half)[:, None]], axis=1)
        R = rotation_from_quat_xyzw(quat)
        turns.append(from_rotation_translation(R, offset - R @ offset))
    return np.concatenate(turns)


def _entries(info: object, key: str, place: Place) -> list[Any]:
    if not isinstance(info, dict):
        raise InputError(f"{place}: must be an object, not {info!r:.60}")
    value = info.get(key, [])
    if not isinstance(value, list):
        raise InputError(f"{place.at(key)}: must be a list, not {value!r:.60}")
    return value


MAX_BYTES = 512 * 2**20
"""Largest file of a model."""


@dataclass(frozen=True, eq=False)
class Model:
    """``points`` (N, 3) m, object frame; ``diameter`` m; ``symmetries`` (S, 4, 4), the identity among them."""

    points: NDArray[np.float64]
    diameter: float
    symmetries: NDArray[np.float64]

    @property
    def symmetric(self) -> bool:
        """Whether it has a symmetry besides the identity: then ADD-S counts, not ADD."""
        return len(self.symmetries) > 1


def model_names(folder: Path) -> dict[str, int]:
    """The numbers of the objects that ``models_info.json`` names, by their names. Raises InputError."""
    rows = numbered(folder / "models_info.json").items()
    return {row["name"]: number for number, row in rows if isinstance(row, dict) and isinstance(row.get("name"), str)}


def model_ids(folder: Path) -> list[int]:
    """The objects that a models' folder knows. Raises InputError."""
    return sorted(numbered(folder / "models_info.json"))


def read_models(folder: Path, ids: Iterable[int]) -> dict[int, Model]:
    """The models of these objects: ``models_info.json`` and ``obj_000001.ply``, millimetres there.

    Raises InputError.
    """
    path = folder / "models_info.json"
    infos = numbered(path)
    return {
        obj_id: _model(folder, obj_id, entry_of(infos, obj_id, path), Place(path, (obj_id,)))
        for obj_id in sorted(set(ids))
    }


def _model(folder: Path, obj_id: int, info: object, place: Place) -> Model:
    diameter = float(numbers(member(info, "diameter", place), 1, place.at("diameter"))[0]) / MM
    if not diameter > 0:
        raise InputError(f"{place.at('diameter')}: must be greater than 0")
    return Model(_points(folder / f"obj_{obj_id:06d}.ply"), diameter, symmetry_motions(info, place))


def _points(path: Path) -> NDArray[np.float64]:
    fault = fault_of(path, MAX_BYTES)
    if fault is not None:
        raise InputError(f"{path}: there is no such model" if fault == IS_MISSING else f"{path}: {fault}")
    try:
        (mesh,) = scene_of(path).geometry.values()
        points = np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3) / MM
    except Exception as error:
        raise InputError(f"{path}: trimesh cannot read it: {reason(path, error)}") from error
    if not len(points) or not np.isfinite(points).all():
        raise InputError(f"{path}: must have vertices, all of them finite")
    return points
