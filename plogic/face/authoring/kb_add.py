"""``plogic kb add``."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path


def add_command(name: str, mesh: Path, units: str | None, folder: Path, *, as_json: bool) -> str:
    """Make a type from a mesh file; the text says what was done. Where there is no such folder, a new knowledge base is made first.

    Raises IntakeError, InputError, SensingError.
    """
    from kb.intake.new_type import check_name, new_type
    from kb.intake.source import read_source
    from plogic.face.authoring.kb_types import check_places, is_new, told, write_types

    fresh = is_new(folder)
    check_name(name)
    check_places(folder, [name])
    new = new_type(name, read_source(mesh), units, mesh)
    write_types(folder, [new], new=fresh)
    return told(folder, [new], "kb_add", new=fresh, as_json=as_json)
