"""Γ as a file, ``gamma/1`` of the contract: read with every mistake at once, written whole or not at all.

``{"format": "gamma/1", "camera": {...}, "appearances": [{"id", "type", "uv", "detector", "angle", "scale", "score",
"arms", "descriptor", "depth", "depth_sigma"}]}`` where all after the detector are optional; a descriptor is base64 of a
keypoint's, depths are in metres.
"""

import base64
import binascii
import json
import math
import sys
from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from geometry.arrays import check_room
from geometry.camera import Camera, camera_from_dict, camera_mistakes, camera_to_dict
from geometry.files.plain_files import name_of, parsed_json, text_of
from sensing.appearance import Appearance, Gamma
from sensing.detectors.keypoint_detector import WIDTH as SIDE
from sensing.detectors.keypoints import WIDTHS
from sensing.errors import GammaError
from sensing.files.whole_files import write_whole

MAX_BYTES = 64 * 1024 * 1024
MAX_APPEARANCES = 20_000
MAX_DESCRIPTOR = 1024
"""Bytes that a descriptor may have."""
_ROOM = 4096
"""Bytes for an appearance while its keys are checked, twice what one with 64 arms took (2,012, by the maximal resident
set); pydantic ends the process that has none left."""
_Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
_Text = Annotated[str, Field(strict=True, min_length=1, max_length=200)]


class _AppearanceModel(BaseModel):
    model_config = ConfigDict(extra="forbid")
    id: _Text
    type: _Text
    uv: Annotated[list[_Number], Field(min_length=2, max_length=2)]
    detector: _Text
    angle: _Number | None = None
    scale: Annotated[_Number, Field(gt=0)] | None = None
    score: _Number | None = None
    arms: Annotated[list[_Number], Field(max_length=64)] = []
    descriptor: Annotated[str, Field(strict=True)] | None = None
    depth: Annotated[_Number, Field(gt=0)] | None = None
    depth_sigma: Annotated[_Number, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _both(self) -> Self:
        if (self.depth is None) != (self.depth_sigma is None):
            raise ValueError("depth and depth_sigma (m) must be given together")
        return self


class _GammaModel(BaseModel):
    model_config = ConfigDict(extra="forbid")
    format: Literal["gamma/1"]
    camera: dict[str, Any]
    appearances: Annotated[list[_AppearanceModel], Field(max_length=MAX_APPEARANCES)]


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
    data = parsed_json(text, name, "it should hold appearances", _refused, single=True)
    return gamma_from_dict(data, name, vocabulary)


def gamma_from_dict(data: object, name: str = "gamma.json", vocabulary: Collection[str] | None = None) -> Gamma:
    """Γ from parsed JSON; raises GammaError with every mistake."""
    given, rows = (data.get("camera"), data.get("appearances")) if isinstance(data, dict) else (None, None)
    wrong = camera_mistakes(given) if isinstance(given, dict) else []
    camera = camera_from_dict(given) if isinstance(given, dict) and not wrong else None
    wrong += _content_mistakes(rows, camera, vocabulary)
    check_room(_ROOM * min(len(rows), MAX_APPEARANCES) if isinstance(rows, list) else 0)
    try:
        model = _GammaModel.model_validate(data)
    except ValidationError as error:
        wrong = [_line(e["loc"], e["msg"], e["input"]) for e in error.errors(include_url=False)] + wrong
    if wrong or camera is None:
        raise GammaError([f"{name}: {line}" for line in wrong])
    return Gamma(camera, tuple(_appearance(a) for a in model.appearances))


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
    keys: dict[str, Any] = {"id": a.id, "type": a.type, "uv": list(a.uv), "detector": a.detector}
    keys |= {key: told for key in ("angle", "scale", "score") if (told := getattr(a, key)) is not None}
    if a.arms:
        keys["arms"] = list(a.arms)
    if a.depth is not None:
        keys |= {"depth": a.depth, "depth_sigma": a.depth_sigma}
    if described and a.descriptor is not None:
        keys["descriptor"] = base64.b64encode(a.descriptor).decode()
    return keys


def write_gamma(gamma: Gamma, path: str | Path) -> None:
    """Write ``gamma.json``, whole or not at all; ``-`` is standard output. The same Γ gives the same bytes."""
    text = json.dumps(gamma_to_dict(gamma), indent=1, allow_nan=False) + "\n"
    if str(path) == "-":
        sys.stdout.write(text)
    else:
        write_whole(Path(path), text.encode())


def _line(loc: tuple[int | str, ...], message: str, value: object) -> str:
    shown = "" if isinstance(value, (dict, list)) else f", not {value!r:.60}"
    place = ".".join(str(part) for part in loc)
    return f"{place + ': ' if place else ''}{message[:1].lower()}{message[1:]}{shown}"


def _content_mistakes(rows: object, camera: Camera | None, vocabulary: Collection[str] | None) -> list[str]:
    """Mistakes beyond the document's shape: ids given twice, places outside the image, types the KB has not."""
    lines: list[str] = []
    first: dict[str, int] = {}
    known, named = frozenset(vocabulary or ()), ", ".join(sorted(vocabulary or ()))
    for i, row in enumerate(rows[:MAX_APPEARANCES] if isinstance(rows, list) else []):
        if not isinstance(row, dict):
            continue
        a_id, a_type, uv = row.get("id"), row.get("type"), row.get("uv")
        if isinstance(a_id, str) and first.setdefault(a_id, i) != i:
            lines.append(f"appearances.{i}.id: {a_id!r} is already the id of appearances.{first[a_id]}")
        if vocabulary is not None and isinstance(a_type, str) and a_type not in known:
            lines.append(f"appearances.{i}.type: {a_type!r} is no appearance type of the KB ({named})")
        if camera is not None and _outside(uv, camera):
            lines.append(f"appearances.{i}.uv: {uv} is outside the image of {camera.width}x{camera.height}")
        wrong = _descriptor_mistake(a_type, row.get("descriptor"))
        if wrong is not None:
            lines.append(f"appearances.{i}.descriptor: {wrong}")
    return lines


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


def _appearance(model: _AppearanceModel) -> Appearance:
    u, v = model.uv
    descriptor = None if model.descriptor is None else base64.b64decode(model.descriptor)
    return Appearance(
        model.id,
        model.type,
        (u, v),
        model.detector,
        model.angle,
        model.scale,
        model.score,
        tuple(model.arms),
        descriptor,
        model.depth,
        model.depth_sigma,
    )
