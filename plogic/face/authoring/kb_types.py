"""New types into the folder of a knowledge base: each whole or not at all, none over another."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geometry.files.plain_files import IS_FOLDER, fault_of, is_there
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
    from kb.files.yaml_text import MAX_BYTES, load

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
    from kb.intake.new_kb import schema_files
    from plogic.face.authoring.kb_new import new_command
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
