"""``plogic kb import``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from geometry.files.plain_files import IS_FOLDER, IS_MISSING, fault_of
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from kb.intake.new_type import NewType


def import_command(source: Path, folder: Path, units: str | None, *, as_json: bool) -> str:
    """Make types from a URDF, an SDF, or a BOP models folder; all are made before the first is written.

    Where there is no such KB folder, a new knowledge base is made first.

    Raises:
        IntakeError: a file that no type can be made of. InputError: no such file, a folder that is no KB, a type that
        exists. SensingError.
    """
    from plogic.face.authoring.kb_types import is_new, told, write_types

    new = is_new(folder)
    fault = fault_of(source)
    if fault not in (None, IS_FOLDER):
        raise InputError(f"{source}: {'there is no such file or folder' if fault == IS_MISSING else fault}")
    types = _of_bop(source, folder, units) if fault == IS_FOLDER else [_of_robot(source, folder, units)]
    write_types(folder, types, new=new)
    return told(folder, types, "kb_import", new=new, as_json=as_json)


def _of_robot(path: Path, folder: Path, units: str | None) -> NewType:
    """One type of one description, its meshes merged in the zero pose. URDF and SDF are in metres."""
    from kb.intake.new_type import new_type
    from kb.intake.robots import sdf_visuals, urdf_visuals
    from kb.intake.visuals import merged
    from plogic.face.authoring.kb_types import check_places

    readers = {".urdf": urdf_visuals, ".sdf": sdf_visuals, ".world": sdf_visuals}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InputError(
            f"{path}: is neither a .urdf nor an .sdf, nor a BOP models folder; a mesh comes with: plogic kb add NAME --mesh {path}"
        )
    stem = path.resolve().parent.name if path.stem == "model" else path.stem  # Gazebo's: NAME/model.sdf
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", stem).lstrip(".-") or "robot"
    check_places(folder, [name])
    return new_type(name, merged(path, reader(path)), units or "m", path)


def _of_bop(models: Path, folder: Path, units: str | None) -> list[NewType]:
    from kb.intake.bop_models import bop_models, bop_symmetries
    from kb.intake.new_type import new_type
    from kb.intake.source import read_source
    from plogic.face.authoring.kb_types import check_places

    unit = units or "mm"
    rows = bop_models(models)
    check_places(folder, [name for name, _, _ in rows])
    known = [bop_symmetries(entry, unit, f"{models / 'models_info.json'}: {name}") for name, _, entry in rows]
    return [
        new_type(name, read_source(path), unit, path, turns) for (name, path, _), turns in zip(rows, known, strict=True)
    ]
