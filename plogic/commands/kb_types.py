"""New types into the folder of a knowledge base: each whole or not at all, none over another."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from plogic.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from kb.intake.new_type import NewType


def check_kb(folder: Path) -> None:
    """Raise InputError where there is no knowledge base to add to."""
    if not (folder / "kb.yaml").is_file():
        raise InputError(f"{folder}: holds no kb.yaml; make a knowledge base with: plogic kb new {folder}")


def check_places(folder: Path, names: Sequence[str]) -> None:
    """Raise InputError for the first name that is a type of the KB already, before the work is done."""
    for name in names:
        if (folder / "objects" / name).exists():
            raise InputError(f"{folder / 'objects' / name}: exists already; remove it first, or choose another name")


def write_types(folder: Path, types: Sequence[NewType]) -> None:
    """Write the types' folders, and the schema that their editor lines point to. Raises SensingError."""
    from kb.intake.new_kb import schema_files
    from sensing.whole_files import write_folder, write_whole

    for new in types:
        write_folder(folder / "objects" / new.name, new.files)
    write_whole(folder / "object.schema.json", schema_files()["object.schema.json"])


def told(folder: Path, types: Sequence[NewType], what: str, *, as_json: bool) -> str:
    """What was done, as text, or as one ``kb_add/1`` or ``kb_import/1`` document."""
    if as_json:
        documents: list[dict[str, Any]] = [new.document | {"notes": list(new.notes)} for new in types]
        return json.dumps({"format": f"{what}/1", "kb": str(folder), "types": documents})
    lines = [line for new in types for line in (*new.lines, *(f"  note: {note}" for note in new.notes))]
    wrote = ", ".join(str(folder / "objects" / new.name) for new in types[:3]) + (f" and {len(types) - 3} more" if len(types) > 3 else "")
    return "\n".join([*lines, f"wrote {wrote}"])
