"""The pictures that a mesh file names or carries, those that OpenCV can read; their bytes travel as they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry.files.mesh_textures import textures_in
from kb.intake.picture import picture_from

if TYPE_CHECKING:
    from pathlib import Path

    from kb.intake.picture import Picture


def textures_of(path: Path) -> tuple[dict[str, Picture], list[str]]:
    """The pictures by name of material, '' meaning every material, and a note on each that is missing."""
    found, notes = textures_in(path)
    pictures = {}
    for texture in found:
        picture = picture_from(texture.data) if texture.data is not None else None
        if picture is None:
            notes.append(f"the {texture.label} is missing or no picture: going on without")
        else:
            pictures[texture.material] = picture
    return pictures, list(dict.fromkeys(notes))
