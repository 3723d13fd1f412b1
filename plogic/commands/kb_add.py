"""``plogic kb add``."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path


def add_command(name: str, mesh: Path, units: str | None, folder: Path, *, as_json: bool) -> str:
    """Make a type from a mesh file; the text says what was done. Where there is no such folder, a new knowledge base is made first.

    Raises IntakeError, InputError, SensingError.
    """
    from geometry.plain_files import is_there
    from kb.intake.new_type import check_name, new_type
    from kb.intake.source import read_source
    from plogic.commands.kb_new import new_command
    from plogic.commands.kb_types import check_kb, check_places, told, write_types

    fresh = not is_there(folder)
    if not fresh:
        check_kb(folder)
    check_name(name)
    check_places(folder, [name])
    new = new_type(name, read_source(mesh), units, mesh)
    if fresh:
        new_command(folder, None)
    write_types(folder, [new])
    return told(folder, [new], "kb_add", as_json=as_json)
