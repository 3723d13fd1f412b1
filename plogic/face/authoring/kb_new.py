"""``plogic kb new``."""

from __future__ import annotations

import os.path
from pathlib import Path


def new_command(folder: Path, name: str | None) -> str:
    """Write a new knowledge base, whole or not at all, and never over anything. Raises IntakeError, SensingError."""
    from kb.intake.new_kb import new_kb_files
    from sensing.files.whole_files import write_folder

    write_folder(folder, new_kb_files(name or Path(os.path.realpath(folder)).name))
    (folder / "objects").mkdir()
    return f"wrote {folder}: kb.yaml, rules.pl, their schemas and objects/\nnext: plogic kb add NAME --mesh FILE --units m|cm|mm --kb {folder}"
