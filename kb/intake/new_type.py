"""An object type's files from a mesh: ``object.yaml``, ``mesh.ply`` and, where it is painted, ``textured.obj`` with its picture.

Vocabulary: ``NewType``, the files by name, and what was done, for people and for programs.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kb.errors import IntakeError
from kb.files.write import flow
from kb.intake.paint import painted_files
from kb.intake.parts import pieces_of
from kb.intake.ply import ply_bytes
from kb.intake.shape_symmetries import Turn, turns_of
from kb.intake.units import check_extent, extent_of
from kb.quantities import LENGTHS
from kb.surfaces.limits import MAX_FILE_BYTES
from kb.surfaces.repair import Repaired, repaired

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from kb.intake.source import Source

SAFE_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,99}")
"""A type's name that is also its folder's."""
EDITOR_LINE = "# yaml-language-server: $schema=../../object.schema.json\n"


@dataclass(frozen=True, eq=False)
class NewType:
    """``files`` of the type's folder, and what was done: ``document`` for programs, ``lines`` for people, ``notes`` on what was missing."""

    name: str
    files: dict[str, bytes]
    document: dict[str, Any]
    lines: tuple[str, ...]
    notes: tuple[str, ...]


def check_name(name: str) -> None:
    """Raise IntakeError for a name that cannot be a folder's."""
    if not SAFE_NAME.fullmatch(name):
        raise IntakeError(
            f"{name!r:.60} is no name for a type: up to 100 letters, digits, '_', '-' and '.', not beginning with '-' or '.'"
        )


def new_type(name: str, source: Source, units: str | None, origin: Path, symmetries: Sequence[str] = ()) -> NewType:
    """The type ``name`` of a mesh whose coordinates are in ``units``; ``origin`` names the file in errors.

    ``symmetries`` are entries of object.yaml that somebody knows; without any, those of the shape are proposed in a
    comment.

    Raises:
        IntakeError: a name that cannot be a folder's, no units, a size outside of the limits, no surface, files too
        large to be read.
    """
    check_name(name)
    vertices, triangles = source.whole
    check_extent(origin, extent_of(vertices), units)
    scale = LENGTHS[units or "m"]
    try:
        mended = repaired(vertices * scale, triangles)
    except IntakeError as error:
        raise IntakeError(f"{origin}: {error}") from error
    files, paint = painted_files(source, scale)
    turns = [] if symmetries else turns_of(mended.surface)
    parts = [str(piece) for piece in pieces_of(mended.surface)]
    text = _object_text(name, origin.name, units or "m", list(symmetries), turns, parts, textured=bool(files))
    files = {"object.yaml": text.encode(), "mesh.ply": ply_bytes(mended.surface)} | files
    large = [name for name, data in files.items() if len(data) > MAX_FILE_BYTES]
    if large:
        raise IntakeError(
            f"{origin}: would make a {large[0]} of more than the {MAX_FILE_BYTES} bytes that are read; simplify the mesh first"
        )
    document = _document(name, mended, paint, files, [str(turn) for turn in turns], list(symmetries)) | {
        "parts": len(parts)
    }
    return NewType(name, files, document, tuple(_lines(document, mended)), source.notes)


def _object_text(
    name: str, origin: str, units: str, known: list[str], turns: list[Turn], parts: list[str], *, textured: bool
) -> str:
    paint = ", textured: textured.obj" if textured else ""
    lines = [
        f"# Made from {_plain(origin)}, in {units}; its frame is kept, its unit is the metre.",
        f"object: {flow(name)}",
    ]
    lines += [f"mesh: {{file: mesh.ply, units: m{paint}}}"]
    if known:
        lines += ["symmetries:", *(f"  - {entry}" for entry in known)]
    elif turns:
        lines += [
            "# The shape alone has these symmetries. Most textures break them; where yours does not, uncomment those that hold:"
        ]
        lines += ["# symmetries:", *(f"#   - {turn}" for turn in turns)]
    if parts:
        lines += [
            "parts:  # the mesh's pieces; rename them. Their features: by hand, or from the mesh: plogic kb learn"
        ]
        lines += [f"  - {part}" for part in parts]
    else:
        lines += ["features: []  # by hand, or from the mesh: plogic kb learn"]
    return EDITOR_LINE + "\n".join(lines) + "\n"


def _plain(origin: str) -> str:
    return re.sub(r"[^\x20-\x7e]", "?", origin)


def _document(
    name: str, mended: Repaired, paint: str, files: dict[str, bytes], turns: list[str], known: list[str]
) -> dict[str, Any]:
    surface = mended.surface
    return {
        "type": name,
        "files": sorted(files),
        "extent_m": [float(side) for side in extent_of(surface.vertices)],
        "diameter_m": surface.diameter,
        "volume_m3": surface.volume if surface.closed else None,
        "source": {"vertices": mended.vertices, "triangles": mended.triangles},
        "welded_vertices": mended.welded,
        "dropped_triangles": mended.dropped,
        "filled_holes": mended.holes,
        "open_holes": mended.left,
        "closed": surface.closed,
        "faults": surface.faults,
        "triangles": len(surface.triangles),
        "deviation_m": mended.deviation,
        "texture": paint,
        "symmetries": known,
        "proposed_symmetries": turns,
    }


def _lines(document: dict[str, Any], mended: Repaired) -> list[str]:
    """What was done, a line a thing."""
    surface = mended.surface
    sides = " x ".join(f"{side:.4g}" for side in document["extent_m"])
    done = f"{mended.dropped} degenerate or repeated triangles dropped, {mended.holes} holes filled"
    return [
        f"{document['type']}: {sides} m, diameter {surface.diameter:.4g} m",
        f"  mesh: {mended.vertices} vertices and {mended.triangles} triangles; {mended.welded} vertices welded, {done}",
        *_simplified(mended),
        f"  closed, {surface.volume:.4g} m3" if surface.closed else _open(mended),
        f"  texture: {document['texture']}" if document["texture"] != "none" else NO_TEXTURE,
        *([f"  parts: {document['parts']} pieces, a part each in object.yaml"] if document["parts"] else []),
        *_symmetries(document),
    ]


NO_TEXTURE = (
    "  texture: none; what can still be detected: junctions of its edges (and patches, where faces differ in brightness); "
    "not keypoints (SIFT, ORB), which need texture"
)


def _simplified(mended: Repaired) -> list[str]:
    number = len(mended.surface.triangles)
    if not mended.deviation:
        return []
    return [f"  simplified to {number} triangles, at most {mended.deviation * 1000:.3g} mm from the mesh"]


def _open(mended: Repaired) -> str:
    what = f" ({mended.left} larger holes left open)" if mended.left else ""
    refused = mended.surface.mended.refused
    return f"  not closed{what}: {mended.surface.faults}; refused as a solid: {refused}; it hides what is behind it, A4 says nothing of it"


def _symmetries(document: dict[str, Any]) -> list[str]:
    if document["symmetries"]:
        return [f"  symmetries: {len(document['symmetries'])} listed"]
    if document["proposed_symmetries"]:
        return [
            f"  symmetries of the shape: {len(document['proposed_symmetries'])} proposed in a comment of object.yaml"
        ]
    return []
