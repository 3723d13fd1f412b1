"""An object type's files from a mesh.

``object.yaml``, ``mesh.ply`` and, where it is painted, ``textured.obj`` with its picture.

Vocabulary: ``NewType``, the files by name, and what was done, for people and for programs.

The files of a new knowledge base too, commented for whoever fills it.
"""

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.bodies.resting import resting_faces
from kb.errors import IntakeError
from kb.files.quantities import LENGTHS
from kb.files.schema import json_schema
from kb.files.write import flow
from kb.intake.links import named, told_together
from kb.intake.source import MAX_FILE_BYTES, Source, painted_files
from kb.surfaces.pieces import pieces_of
from kb.surfaces.repair import Repaired, repaired
from kb.surfaces.surface import OPEN, Surface
from kb.surfaces.symmetries import Turn, turns_of

SMALLEST, LARGEST = 1e-4, 1e4
"""Extent of a mesh's longest side, m: what is outside is the wrong unit, or nothing that a camera sees."""
ASKED = {"m": "metres", "cm": "centimetres", "mm": "millimetres"}
"""What is proposed."""
UNUSUAL = 0.005, 10.0
"""Longest side, m, outside of which the unit may be the wrong one.

A thing of 5 mm covers 40 pixels (f 600) only nearer than 75 mm, where few lenses focus; one of 10 m is a lorry. What
people put before a camera, from 1 cm to 3 m, lands outside wherever m and mm are confused, but for some centimetres at
the ends."""
USUAL = 0.25
"""Longest side of the things that people put before a camera, m: the nearest to it, as a ratio, is the likely unit."""


def extent_of(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sides (3,) of the bounding box of vertices (V, 3), in their unit."""
    with np.errstate(over="ignore"):
        return np.asarray(np.ptp(vertices, axis=0))


def likely_unit(longest: float) -> str:
    """The likely unit of a mesh whose longest side has this many units: ``likely_unit(25.8) == "cm"``."""
    return min(ASKED, key=lambda unit: abs(math.log(longest * LENGTHS[unit] / USUAL)))


def proposal(extent: NDArray[np.float64]) -> str:
    """What the mesh's size would be in each unit, and which is likely."""
    longest = float(extent.max())
    sizes = ", ".join(f"{_metres(longest * LENGTHS[unit])} in {unit}" for unit in ASKED)
    box = " x ".join(f"{side:.4g}" for side in extent)
    likely = likely_unit(longest)
    told = f"probably --units {likely}" if SMALLEST <= longest * LENGTHS[likely] <= LARGEST else "was the mesh scaled?"
    return f"the mesh measures {box} units, its longest side being {sizes}: {told}"


def _metres(size: float) -> str:
    return f"{size:.3g} m" if size >= 0.1 else f"{size * 1000:.3g} mm"


def check_extent(name: object, extent: NDArray[np.float64], units: str | None) -> None:
    """Hold a mesh's size to the limits.

    Raises:
        IntakeError: no extent at all; no units, with what they may be; a size in these units that no camera sees.
    """
    if not extent.max() > 0 or not np.isfinite(extent).all():
        raise IntakeError(
            f"{name}: has no extent: all vertices are at one place"
            if extent.max() == 0
            else f"{name}: is too large for numbers"
        )
    if units is None:
        raise IntakeError(f"{name}: --units is missing, and no mesh format carries its unit; {proposal(extent)}")
    longest = float(extent.max()) * LENGTHS[units]
    if not SMALLEST <= longest <= LARGEST:
        raise IntakeError(
            f"{name}: would be {longest:.3g} m long in {units}, not {SMALLEST:g} m to {LARGEST:g} m; {proposal(extent)}"
        )


def size_doubt(extent: NDArray[np.float64], units: str) -> str:
    """That a mesh of these sides (3,), in ``units``, has an unusual size, with a likelier unit; '' where it has not."""
    longest = float(extent.max())
    if UNUSUAL[0] <= longest * LENGTHS[units] <= UNUSUAL[1]:
        return ""
    likely, size = likely_unit(longest), f"the type is {_metres(longest * LENGTHS[units])} across"
    if likely == units:
        return f"{size}; in {' and '.join(unit for unit in ASKED if unit != units)} it would be no likelier: was the mesh scaled?"
    return f"{size}; if the mesh is in {ASKED[likely]}: --units {likely}"


SAFE_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,99}")
"""A type's name that is also its folder's."""
EDITOR_LINE = "# yaml-language-server: $schema=../../object.schema.json\n"


@dataclass(frozen=True, eq=False)
class NewType:
    """``files`` of the type's folder, and what was done.

    ``document`` for programs, ``lines`` for people, ``notes`` on what was missing.
    """

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
    pieces, together = named(pieces_of(mended.surface), mended.surface, source, scale)
    parts = [str(piece) for piece in pieces]
    lines = [*_stand_lines(mended.surface), *_symmetry_lines(list(symmetries), turns)]
    text = _object_text(name, origin.name, units or "m", lines, parts, textured=bool(files))
    files = {"object.yaml": text.encode(), "mesh.ply": ply_bytes(mended.surface)} | files
    large = [name for name, data in files.items() if len(data) > MAX_FILE_BYTES]
    if large:
        raise IntakeError(
            f"{origin}: would make a {large[0]} of more than the {MAX_FILE_BYTES} bytes that are read; simplify the mesh first"
        )
    document = _document(name, mended, paint, files, [str(turn) for turn in turns], list(symmetries)) | {
        "parts": len(parts)
    }
    doubt = size_doubt(extent_of(vertices), units or "m")
    notes = (*source.notes, *map(told_together, together), *[doubt][: bool(doubt)])
    return NewType(name, files, document, tuple(_lines(document, mended)), notes)


def _symmetry_lines(known: list[str], turns: list[Turn]) -> list[str]:
    if known:
        return ["symmetries:", *(f"  - {entry}" for entry in known)]
    if not turns:
        return []
    why = "# The shape alone has these symmetries. Most textures break them; where yours does not, uncomment those that hold:"
    return [why, "# symmetries:", *(f"#   - {turn}" for turn in turns)]


MOST_STANDS = 6
"""Ways to stand that are proposed: those on the widest faces."""


def _stand_lines(surface: Surface) -> list[str]:
    faces = resting_faces(surface.vertices)
    rows = [
        f"#   - {{down: {flow(down)}, weight: {weight:.3g}}}"
        for down, weight in zip(np.round(faces.down, 3).tolist(), faces.weight.tolist(), strict=True)
    ]
    why = (
        "# It can stand so, and each way counts the same; where one is likelier, uncomment. What hangs: 'stands: never'"
    )
    more = f", the widest {MOST_STANDS} of {len(rows)} faces" if len(rows) > MOST_STANDS else ""
    return [f"{why}{more}.", "# stands:", *rows[:MOST_STANDS]] if rows else []


def _object_text(name: str, origin: str, units: str, known: list[str], parts: list[str], *, textured: bool) -> str:
    paint, plain = ", textured: textured.obj" if textured else "", re.sub(r"[^\x20-\x7e]", "?", origin)
    lines = [
        f"# Made from {plain}, in {units}; its frame is kept, its unit is the metre.",
        f"object: {flow(name)}",
    ]
    lines += [f"mesh: {{file: mesh.ply, units: m{paint}}}", *known]
    if parts:
        lines += [
            "parts:  # the mesh's pieces, of a robot its links; rename them. Their features: by hand, or from the mesh: plogic kb learn"
        ]
        lines += [f"  - {part}" for part in parts]
    else:
        lines += ["features: []  # by hand, or from the mesh: plogic kb learn"]
    return EDITOR_LINE + "\n".join(lines) + "\n"


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
    """What is known of a surface that is not closed: what A4 makes of it, or why nothing."""
    what = f" ({mended.left} larger holes left open)" if mended.left else ""
    solid, done, refused = mended.surface.mended
    verdict = f"refused as a solid: {refused}. {OPEN}" if solid is None else f"as a solid (A4) it is repaired: {done}"
    return f"  not closed{what}: {mended.surface.faults}; {verdict}"


def _symmetries(document: dict[str, Any]) -> list[str]:
    if document["symmetries"]:
        return [f"  symmetries: {len(document['symmetries'])} listed"]
    if document["proposed_symmetries"]:
        return [
            f"  symmetries of the shape: {len(document['proposed_symmetries'])} proposed in a comment of object.yaml"
        ]
    return []


HEAD = """ply
format binary_little_endian 1.0
comment metres
element vertex {}
property double x
property double y
property double z
element face {}
property list uchar int vertex_indices
end_header
"""


def ply_bytes(surface: Surface) -> bytes:
    """The file's bytes."""
    facets = np.empty(len(surface.triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    facets["count"], facets["corners"] = 3, surface.triangles
    head = HEAD.format(len(surface.vertices), len(surface.triangles))
    return head.encode() + surface.vertices.astype("<f8").tobytes() + facets.tobytes()


KB_YAML = """\
# yaml-language-server: $schema=./kb.schema.json
name: {name}
# What detectors report. Keypoints' visual words join these when types are learned.
appearance_types: [l_junction, y_junction, arrow_junction, t_junction, multi_junction, patch]
# The focal length, in pixels, that the ranges of lobes hold for.
f_ref: 600
detector:
  # Chance that an expected feature is detected, per feature type (0.8 where nothing stands here), such as {{corner:
  # 0.9}}.
  hit: {{}}
  # Appearances of noise in an image, per appearance type, such as {{patch: 1.5}}.
  clutter: {{}}
  # Location noise, and how far from its predicted place a feature may be found; pixels.
  sigma: 1.0
  match_tolerance: 4.0
# Chance that an object is there, per object type (0.5 where nothing stands here), such as {{mug: 0.2}}.
priors: {{}}
# Whether things rest, as on a table. maybe: nine in ten do, on planes that nobody knows. true: then what floats is less
# probable too, and what is not found yet is looked for on the plane that others stand on. Instead of true, {{rests: 0.9,
# ground: 0 m}}: the chance that a thing rests on another, a plane or the ground, and the ground's height. Or false.
gravity: maybe
"""

RULES = """\
% Rules of your own, in ProbLog; the vocabulary is in docs/vocabulary.md. For example:
%
%   two_of(Type) :- object(X, Type), object(Y, Type), X \\= Y.   % for queries
%   constraint(one_of(Type)) :- two_of(Type).                    % no world has two of one type,
%   0.1::constraint_may_fail(one_of(_)).                         % but for one in ten
%   0.2::wet. evidence(\\+ wet).                                 % a choice, and what was observed
"""


def schema_files() -> dict[str, bytes]:
    """The JSON Schemas of the editor lines of ``kb.yaml`` and ``object.yaml``, by name in the KB's folder."""
    return {"kb.schema.json": _schema("kb"), "object.schema.json": _schema("object")}


def _schema(which: str) -> bytes:
    return (json.dumps(json_schema("kb" if which == "kb" else "object"), indent=1) + "\n").encode()


def new_kb_files(name: str) -> dict[str, bytes]:
    """Every file of a new KB but the empty folder ``objects``, by relative path.

    Raises:
        IntakeError: for a name of other signs than a folder's.
    """
    if not SAFE_NAME.fullmatch(name):
        raise IntakeError(
            f"{name!r:.60} is no name for a knowledge base: letters, digits, '_', '-' and '.';"
            " give one with plogic kb new FOLDER --name NAME"
        )
    return {"kb.yaml": KB_YAML.format(name=json.dumps(name)).encode(), "rules.pl": RULES.encode()} | schema_files()
