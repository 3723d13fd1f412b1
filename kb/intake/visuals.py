"""The visible shapes of a description, each at its place, to one mesh.

Vocabulary: ``Visual``, one shape: a mesh file with its scale, or a primitive, at ``root_from_shape``; its colour, if
the description has one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kb.errors import IntakeError
from kb.intake.source import GREY, Piece, Source, read_source
from kb.intake.xml_text import found_file

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import NDArray

MOST = 2000
"""Most shapes of a description."""


@dataclass(frozen=True, eq=False)
class Visual:
    """``file`` of a mesh, or a primitive: ``kind`` box, cylinder or sphere with its ``sizes`` (sides; radius and length; radius).

    ``scale`` (3,) of the mesh's coordinates; ``root_from_shape`` (4, 4), m; ``colour`` red, green, blue in [0, 255].
    """

    root_from_shape: NDArray[np.float64]
    file: str | None = None
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    kind: str = ""
    sizes: tuple[float, ...] = ()
    colour: tuple[int, int, int] | None = None


def merged(path: Path, visuals: Sequence[Visual]) -> Source:
    """All shapes as one source, in metres and in the root's frame; a note on each mesh that could not be had.

    Raises:
        IntakeError: no visible shape at all, or none that could be had.
    """
    if len(visuals) > MOST:
        raise IntakeError(f"{path}: has {len(visuals)} visible shapes, more than {MOST}")
    read: dict[str, Source | str] = {}
    pieces: list[Piece] = []
    notes: list[str] = []
    for visual in visuals:
        source = _source(path.parent, visual, read)
        if isinstance(source, str):
            notes.append(source)
            continue
        placed = source.moved(visual.root_from_shape @ np.diag([*visual.scale, 1.0]))
        pieces += [_tinted(piece, visual.colour) for piece in placed.pieces]
        notes += source.notes
    if not pieces:
        raise IntakeError(f"{path}: holds no visible shape" + (f": {notes[0]}" if notes else ""))
    return Source(tuple(pieces), tuple(dict.fromkeys(notes)))


def _source(folder: Path, visual: Visual, read: dict[str, Source | str]) -> Source | str:
    """The shape in its own frame, each file read once; a note instead where it cannot be had."""
    if visual.file is None:
        return _primitive(visual)
    if visual.file not in read:
        file = found_file(folder, visual.file)
        try:
            read[visual.file] = (
                f"the mesh {visual.file!r:.80} is missing or no plain file: left out"
                if file is None
                else read_source(file)
            )
        except IntakeError as error:
            read[visual.file] = f"{error}: left out"
    return read[visual.file]


def _primitive(visual: Visual) -> Source:
    from trimesh import creation

    if visual.kind == "box":
        mesh: Any = creation.box(extents=visual.sizes)
    elif visual.kind == "cylinder":
        mesh = creation.cylinder(radius=visual.sizes[0], height=visual.sizes[1], sections=48)
    else:
        mesh = creation.icosphere(subdivisions=3, radius=visual.sizes[0])
    return Source((Piece(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)),))


def _tinted(piece: Piece, colour: tuple[int, int, int] | None) -> Piece:
    """The piece in the description's colour, where it has none of its own."""
    return replace(piece, colour=colour) if colour is not None and piece.colour == GREY else piece


def primitive_sizes(kind: str, sizes: Sequence[float], path: Path) -> tuple[float, ...]:
    """The sizes of a primitive; raises IntakeError for one that is not above 0."""
    if not all(size > 0 for size in sizes):
        raise IntakeError(f"{path}: the sizes of a {kind} must be above 0, not {list(sizes)}")
    return tuple(sizes)
