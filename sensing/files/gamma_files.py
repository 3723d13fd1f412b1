"""Γ as a file, ``gamma/1`` of the contract: read with every mistake at once, written whole or not at all.

``{"format": "gamma/1", "camera": {...}, "appearances": [{"id", "type", "uv", "detector", "angle", "scale", "score",
"arms", "descriptor", "depth", "depth_sigma"}]}`` where all after ``uv`` are optional (``GammaRow``).
"""

import base64
import binascii
import json
import math
import sys
from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Any, Literal, NotRequired, TypedDict, cast

import numpy as np

from geometry.camera import Camera, camera_from_dict, camera_mistakes, camera_to_dict
from geometry.camera_row import CameraRow
from geometry.errors import Mistake
from geometry.files.documents import Document, parsed_json
from geometry.files.plain_files import name_of, text_of
from geometry.json_checks import shown
from geometry.json_shapes import Range, Size
from sensing.appearance import MAX_APPEARANCES, Appearance, Gamma
from sensing.detectors.keypoint_detector import WIDTH as SIDE
from sensing.detectors.keypoints import WIDTHS
from sensing.errors import GammaError
from sensing.files.whole_files import write_whole

MAX_BYTES = 64 * 1024 * 1024
MAX_DESCRIPTOR = 1024
"""Bytes that a descriptor may have."""
Name = Annotated[str, Size(1, 200)]
_Above0 = Annotated[float | None, Range(0.0, open_low=True)]


class GammaAppearance(TypedDict):
    """One appearance: something of a type that a detector saw at a place."""

    id: Annotated[Name, "Its name, of its own in this Γ."]
    type: Annotated[Name, "One of the KB's `appearance_types`."]
    uv: Annotated[
        list[float], Size(2), "Its place in the image, pixels: u to the right, v down; an integer is a pixel's centre."
    ]
    detector: NotRequired[Annotated[Name | None, "What reported it; it is told, and nothing depends on it."]]
    angle: NotRequired[Annotated[float | None, "Its direction on the screen, radians, clockwise from +x."]]
    scale: NotRequired[Annotated[_Above0, "Its diameter, pixels."]]
    score: NotRequired[Annotated[float | None, "The detector's own confidence, from 0 to 1."]]
    arms: NotRequired[
        Annotated[list[float], Size(0, 64), "Directions of the edges that meet there, of a junction; as `angle`."]
    ]
    descriptor: NotRequired[
        Annotated[str | None, "A keypoint's descriptor, base64 of its bytes: 128 or 138 of SIFT, 32 of ORB."]
    ]
    depth: NotRequired[Annotated[_Above0, "Its depth along the camera's z axis, metres; with `depth_sigma`."]]
    depth_sigma: NotRequired[Annotated[_Above0, "The standard deviation of `depth`, metres."]]


class GammaRow(TypedDict):
    """Γ: what was detected in one image, and the camera that took it."""

    format: Literal["gamma/1"]
    camera: Annotated[CameraRow, "The camera of the image."]
    appearances: Annotated[list[GammaAppearance], Size(0, MAX_APPEARANCES), "What was detected, in any order."]


def read_gamma(path: str | Path, vocabulary: Collection[str] | None = None) -> Gamma:
    """Read a ``gamma.json``, or standard input for ``-``.

    Args:
        path: The file.
        vocabulary: The KB's appearance types; if given, any other type is a mistake.

    Raises:
        GammaError: Every mistake of the file, one line each.
    """
    return gamma_from_text(text_of(path, MAX_BYTES, _refused, "JSON"), name_of(path), vocabulary)


def _refused(lines: str) -> GammaError:
    return GammaError(lines.splitlines())


def gamma_from_text(text: str, name: str = "gamma.json", vocabulary: Collection[str] | None = None) -> Gamma:
    """Γ from the text of a ``gamma.json``; ``name`` opens every mistake's line.

    Raises GammaError as ``read_gamma`` does.
    """
    return _gamma(parsed_json(text, name, "it should hold appearances", _refused, single=True), vocabulary)


def gamma_from_dict(data: object, name: str = "gamma.json", vocabulary: Collection[str] | None = None) -> Gamma:
    """Γ from parsed JSON; raises GammaError with every mistake."""
    return _gamma(Document(name, data), vocabulary)


def _gamma(document: Document, vocabulary: Collection[str] | None) -> Gamma:
    wrong = [
        mistake for mistake in document.against(GammaRow) if mistake.place[:1] != ("camera",) or len(mistake.place) < 2
    ]
    given = document.data if isinstance(document.data, dict) and not document.is_other(GammaRow) else {}
    camera_wrong = camera_mistakes(given["camera"], ("camera",)) if isinstance(given.get("camera"), dict) else []
    camera = None if camera_wrong or not isinstance(given.get("camera"), dict) else camera_from_dict(given["camera"])
    wrong += camera_wrong + _content_mistakes(given.get("appearances"), camera, vocabulary)
    if wrong or camera is None:
        raise GammaError(document.told(wrong))
    return Gamma(camera, tuple(_appearance(row) for row in cast("GammaRow", document.data)["appearances"]))


def gamma_to_dict(gamma: Gamma) -> dict[str, Any]:
    """The ``gamma/1`` document; a key whose value is absent is left out."""
    return {
        "format": "gamma/1",
        "camera": camera_to_dict(gamma.camera),
        "appearances": [appearance_to_dict(a) for a in gamma.appearances],
    }


def appearance_to_dict(appearance: Appearance, *, described: bool = True) -> dict[str, Any]:
    """One appearance with the contract's keys.

    Optional ones only where there is a value, its descriptor only where it is to be ``described``.
    """
    a = appearance
    keys: dict[str, Any] = {"id": a.id, "type": a.type, "uv": [_plain(x) for x in a.uv]}
    told = {key: getattr(a, key) for key in ("detector", "angle", "scale", "score")}
    keys |= {key: _plain(value) for key, value in told.items() if value is not None}
    if a.arms:
        keys["arms"] = [_plain(x) for x in a.arms]
    if a.depth is not None:
        keys |= {"depth": _plain(a.depth), "depth_sigma": _plain(a.depth_sigma)}
    if described and a.descriptor is not None:
        keys["descriptor"] = base64.b64encode(a.descriptor).decode()
    return keys


def _plain(value: object) -> object:
    """Python's own number for one of numpy's."""
    return value.item() if isinstance(value, np.generic) else value


def write_gamma(gamma: Gamma, path: str | Path) -> None:
    """Write ``gamma.json``, whole or not at all; ``-`` is standard output. The same Γ gives the same bytes."""
    text = json.dumps(gamma_to_dict(gamma), indent=1, allow_nan=False) + "\n"
    if str(path) == "-":
        sys.stdout.write(text)
    else:
        write_whole(Path(path), text.encode())


def _content_mistakes(rows: object, camera: Camera | None, vocabulary: Collection[str] | None) -> list[Mistake]:
    """Mistakes beyond the document's shape: ids given twice, places outside the image, types the KB has not."""
    found: list[Mistake] = []
    first: dict[str, int] = {}
    known, named = frozenset(vocabulary or ()), ", ".join(sorted(vocabulary or ()))
    for i, row in enumerate(rows[:MAX_APPEARANCES] if isinstance(rows, list) else []):
        if not isinstance(row, dict):
            continue
        a_id, a_type, uv, here = row.get("id"), row.get("type"), row.get("uv"), ("appearances", i)
        if isinstance(a_id, str) and first.setdefault(a_id, i) != i:
            found.append(Mistake((*here, "id"), f"{a_id!r:.60} is already the id of appearances.{first[a_id]}"))
        if vocabulary is not None and isinstance(a_type, str) and a_type not in known:
            found.append(Mistake((*here, "type"), f"{a_type!r:.60} is no appearance type of the KB ({named})"))
        if camera is not None and _outside(uv, camera):
            found.append(Mistake((*here, "uv"), f"{shown(uv)} is outside the image of {camera.width}x{camera.height}"))
        wrong = _descriptor_mistake(a_type, row.get("descriptor"))
        if wrong is not None:
            found.append(Mistake((*here, "descriptor"), wrong))
        if (row.get("depth") is None) != (row.get("depth_sigma") is None):
            given = "depth_sigma" if row.get("depth") is None else "depth"
            found.append(Mistake((*here, given), "depth and depth_sigma (m) must be given together"))
    return found


def _descriptor_mistake(a_type: object, text: object) -> str | None:
    """What is wrong with a descriptor's text for an appearance of this type.

    A keypoint detector's name, or a word of it.

    A text that is no string is another mistake's business.
    """
    if not isinstance(text, str):
        return None
    try:
        size = len(base64.b64decode(text, validate=True))
    except (binascii.Error, ValueError):  # ValueError: letters that are not ASCII
        return f"is not base64: {text!r:.60}"
    kind = a_type.split("_", 1)[0] if isinstance(a_type, str) else ""
    wanted = WIDTHS.get(kind, ()) + ((SIDE,) if kind == "sift" else ())
    if wanted and size not in wanted:
        return f"has {size} bytes, and one of {a_type!r:.60} has {' or '.join(map(str, wanted))}"
    return None if 0 < size <= MAX_DESCRIPTOR else f"has {size} bytes, not 1 to {MAX_DESCRIPTOR}"


def _outside(uv: object, camera: Camera) -> bool:
    """Whether a well-formed place lies outside the pixels' area; an ill-formed one is another mistake's business."""
    match uv:
        case [int() | float() as u, int() | float() as v] if abs(u) < math.inf and abs(v) < math.inf:
            return not (-0.5 <= u <= camera.width - 0.5 and -0.5 <= v <= camera.height - 0.5)
    return False


def _appearance(row: GammaAppearance) -> Appearance:
    (u, v), text = row["uv"], row.get("descriptor")
    return Appearance(
        row["id"],
        row["type"],
        (float(u), float(v)),
        row.get("detector"),
        _number(row.get("angle")),
        _number(row.get("scale")),
        _number(row.get("score")),
        tuple(map(float, row.get("arms", ()))),
        None if text is None else base64.b64decode(text),
        _number(row.get("depth")),
        _number(row.get("depth_sigma")),
    )


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)
