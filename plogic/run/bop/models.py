"""The objects' models: vertices, diameter and symmetries, in metres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.files.mesh_files import beside, reason
from geometry.files.plain_files import IS_MISSING, fault_of
from plogic.base.errors import InputError
from plogic.run.bop.json_files import MM, entry_of, member, numbered, numbers
from plogic.run.bop.symmetries import symmetry_motions

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from numpy.typing import NDArray


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


def model_ids(folder: Path) -> list[int]:
    """The objects that a models' folder knows. Raises InputError."""
    return sorted(numbered(folder / "models_info.json"))


def read_models(folder: Path, ids: Iterable[int]) -> dict[int, Model]:
    """The models of these objects: ``models_info.json`` and ``obj_000001.ply``, millimetres there. Raises InputError."""
    path = folder / "models_info.json"
    infos = numbered(path)
    return {
        obj_id: _model(folder, obj_id, entry_of(infos, obj_id, path), f"{path}: {obj_id}")
        for obj_id in sorted(set(ids))
    }


def _model(folder: Path, obj_id: int, info: object, place: str) -> Model:
    diameter = float(numbers(member(info, "diameter", place), 1, f"{place}.diameter")[0]) / MM
    if not diameter > 0:
        raise InputError(f"{place}.diameter: must be greater than 0")
    return Model(_points(folder / f"obj_{obj_id:06d}.ply"), diameter, symmetry_motions(info, place))


def _points(path: Path) -> NDArray[np.float64]:
    import trimesh

    fault = fault_of(path, MAX_BYTES)
    if fault is not None:
        raise InputError(f"{path}: there is no such model" if fault == IS_MISSING else f"{path}: {fault}")
    try:
        mesh: Any = trimesh.load(path, process=False, resolver=beside(path))
        points = np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3) / MM
    except Exception as error:
        raise InputError(f"{path}: trimesh cannot read it: {reason(path, error)}") from error
    if not len(points) or not np.isfinite(points).all():
        raise InputError(f"{path}: must have vertices, all of them finite")
    return points
