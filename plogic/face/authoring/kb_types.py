"""``plogic kb new``, ``add`` and ``import``: new knowledge bases, and new types in their folders, each whole or not at all."""

from __future__ import annotations

import json
import os.path
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geometry.files.plain_files import IS_FOLDER, IS_MISSING, fault_of, is_there
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kb.intake.new_type import NewType


def check_kb(folder: Path) -> None:
    """Raise InputError where there is no knowledge base to add to."""
    if fault_of(folder / "kb.yaml") is not None:
        raise InputError(f"{folder}: holds no kb.yaml; make a knowledge base with: plogic kb new {folder}")


def is_new(folder: Path) -> bool:
    """Whether there is nothing yet, so that a knowledge base is to be made first; raises InputError where what is there is none."""
    if is_there(folder):
        check_kb(folder)
        return False
    return True


def check_own(kb_folder: str) -> Path:
    """The folder of a KB that is there to be changed. Raises InputError for one that is shipped with plogic."""
    folder = Path(kb_folder)
    if not is_there(folder / "kb.yaml"):
        raise InputError(f"{kb_folder}: is shipped with plogic: copy its folder, and change the copy")
    return folder


def check_places(folder: Path, names: Sequence[str]) -> None:
    """Raise InputError for all the names that are types of the KB already, before the work is done."""
    there = type_folders(folder)
    taken = [place for name in names if is_there(place := there.get(name, folder / "objects" / name))]
    if taken:
        raise InputError(
            "\n".join(f"{place}: exists already; remove it first, or choose another name" for place in taken)
        )


def type_folders(folder: Path) -> dict[str, Path]:
    """Where each type of a KB's folder is described, by the name that its object.yaml states; what cannot be read is left out."""
    from kb.files.folder import MAX_BYTES, load

    found: dict[str, Path] = {}
    if fault_of(folder / "objects") != IS_FOLDER:
        return found
    for file in sorted((folder / "objects").glob("[!.]*/object.yaml")):
        data = load(file.name, file.read_bytes()).data if fault_of(file, MAX_BYTES) is None else None
        name = data.get("object") if isinstance(data, dict) else None
        if isinstance(name, str):
            found[name] = file.parent
    return found


def write_types(folder: Path, types: Sequence[NewType], *, new: bool = False) -> None:
    """Write the types' folders, into a ``new`` knowledge base or one that is there, and the schema that their editor lines point to.

    Raises IntakeError, SensingError.
    """
    from kb.intake.new_type import schema_files
    from sensing.files.whole_files import write_folder, write_whole

    if new:
        new_command(folder, None)
    for kind in types:
        write_folder(folder / "objects" / kind.name, kind.files)
    write_whole(folder / "object.schema.json", schema_files()["object.schema.json"])


def told(folder: Path, types: Sequence[NewType], what: str, *, new: bool, as_json: bool) -> str:
    """What was done, as text, or as one ``kb_add/1`` or ``kb_import/1`` document; ``new``: the knowledge base was made too."""
    if as_json:
        documents: list[dict[str, Any]] = [kind.document | {"notes": list(kind.notes)} for kind in types]
        return json.dumps({"format": f"{what}/1", "kb": str(folder), "new_kb": new, "types": documents})
    lines = [line for kind in types for line in (*kind.lines, *(f"  note: {note}" for note in kind.notes))]
    lines += [f"made a new knowledge base: {folder}"] if new else []
    wrote = ", ".join(str(folder / "objects" / kind.name) for kind in types[:3]) + (
        f" and {len(types) - 3} more" if len(types) > 3 else ""
    )
    return "\n".join([*lines, f"wrote {wrote}"])


def new_command(folder: Path, name: str | None) -> str:
    """Write a new knowledge base, whole or not at all, and never over anything. Raises IntakeError, SensingError."""
    from kb.intake.new_type import new_kb_files
    from sensing.files.whole_files import write_folder

    write_folder(folder, new_kb_files(name or Path(os.path.realpath(folder)).name))
    (folder / "objects").mkdir()
    return f"wrote {folder}: kb.yaml, rules.pl, their schemas and objects/\nnext: plogic kb add NAME --mesh FILE --units m|cm|mm --kb {folder}"


def add_command(name: str, mesh: Path, units: str | None, folder: Path, *, as_json: bool) -> str:
    """Make a type from a mesh file; the text says what was done. Where there is no such folder, a new knowledge base is made first.

    Raises IntakeError, InputError, SensingError.
    """
    from kb.intake.new_type import check_name, new_type
    from kb.intake.source import read_source

    fresh = is_new(folder)
    check_name(name)
    check_places(folder, [name])
    new = new_type(name, read_source(mesh), units, mesh)
    write_types(folder, [new], new=fresh)
    return told(folder, [new], "kb_add", new=fresh, as_json=as_json)


def import_command(source: Path, folder: Path, units: str | None, *, as_json: bool) -> str:
    """Make types from a URDF, an SDF, or a BOP models folder; all are made before the first is written.

    Where there is no such KB folder, a new knowledge base is made first.

    Raises:
        IntakeError: a file that no type can be made of. InputError: no such file, a folder that is no KB, a type that
        exists. SensingError.
    """
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
    from kb.intake.robots import merged, sdf_visuals, urdf_visuals

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

    unit = units or "mm"
    rows = bop_models(models)
    check_places(folder, [name for name, _, _ in rows])
    known = [bop_symmetries(entry, unit, f"{models / 'models_info.json'}: {name}") for name, _, entry in rows]
    return [
        new_type(name, read_source(path), unit, path, turns) for (name, path, _), turns in zip(rows, known, strict=True)
    ]
