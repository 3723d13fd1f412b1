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
from collections import Counter
from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from geometry.camera import Camera, camera_from_dict, camera_to_dict
from geometry.errors import CameraError
from sensing.appearance import Appearance, Gamma
from sensing.detectors.edge_sides import WIDTH as SIDE
from sensing.detectors.keypoints import WIDTHS
from sensing.errors import GammaError
from sensing.files.whole_files import write_whole

MAX_BYTES = 64 * 1024 * 1024
MAX_APPEARANCES = 20_000
MAX_DESCRIPTOR = 1024
"""Bytes that a descriptor may have."""
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
    name = "<stdin>" if str(path) == "-" else str(path)
    return gamma_from_text(_text(path, name), name, vocabulary)


def gamma_from_text(text: str, name: str = "gamma.json", vocabulary: Collection[str] | None = None) -> Gamma:
    """Γ from the text of a ``gamma.json``; ``name`` opens every mistake's line.

    Raises GammaError as ``read_gamma`` does.
    """
    return gamma_from_dict(_parsed(text, name), name, vocabulary)


def gamma_from_dict(data: object, name: str = "gamma.json", vocabulary: Collection[str] | None = None) -> Gamma:
    """Γ from parsed JSON; raises GammaError with every mistake."""
    mistakes = _shape_mistakes(data)
    camera, wrong = _camera(data)
    mistakes += wrong + _content_mistakes(data, camera, vocabulary)
    if mistakes or camera is None:
        raise GammaError([f"{name}: {line}" for line in mistakes])
    model = _GammaModel.model_validate(data)
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
    if a.angle is not None:
        keys["angle"] = a.angle
    if a.scale is not None:
        keys["scale"] = a.scale
    if a.score is not None:
        keys["score"] = a.score
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


def _text(path: str | Path, name: str) -> str:
    try:
        data = sys.stdin.buffer.read(MAX_BYTES + 1) if str(path) == "-" else _head(Path(path))
        if len(data) > MAX_BYTES:
            raise GammaError([f"{name}: is larger than the {MAX_BYTES} bytes that a Γ may have"])
        return data.decode("utf-8-sig")
    except OSError as error:
        raise GammaError([f"{name}: cannot be read: {error.strerror}"]) from None
    except UnicodeDecodeError as error:
        raise GammaError([f"{name}: is not UTF-8 text (byte {error.start})"]) from None


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(MAX_BYTES + 1)


def _parsed(text: str, name: str) -> object:
    doubled: list[str] = []

    def pairs(items: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(items)
        if len(found) < len(items):
            doubled.extend(sorted(key for key, times in Counter(key for key, _ in items).items() if times > 1))
        return found

    try:
        data = json.loads(text, object_pairs_hook=pairs)
    except json.JSONDecodeError as error:
        raise GammaError([f"{name}:{error.lineno}:{error.colno}: is not JSON: {error.msg}"]) from None
    except (RecursionError, ValueError) as error:
        raise GammaError([f"{name}: is not JSON that can be read: {type(error).__name__}"]) from None
    if doubled:
        raise GammaError([f"{name}: the key {key!r} is given twice in one object" for key in doubled])
    return data


def _shape_mistakes(data: object) -> list[str]:
    try:
        _GammaModel.model_validate(data)
    except ValidationError as error:
        return [_line(e["loc"], e["msg"], e["input"]) for e in error.errors(include_url=False)]
    return []


def _line(loc: tuple[int | str, ...], message: str, value: object) -> str:
    shown = "" if isinstance(value, (dict, list)) else f", not {value!r:.60}"
    place = ".".join(str(part) for part in loc)
    return f"{place + ': ' if place else ''}{message[:1].lower()}{message[1:]}{shown}"


def _camera(data: object) -> tuple[Camera | None, list[str]]:
    if not isinstance(data, dict) or not isinstance(data.get("camera"), dict):
        return None, []
    try:
        return camera_from_dict(data["camera"]), []
    except CameraError as error:
        lines = str(error).splitlines()
        return None, [line if line.startswith("camera") else f"camera: {line}" for line in lines]


def _content_mistakes(data: object, camera: Camera | None, vocabulary: Collection[str] | None) -> list[str]:
    """Mistakes that the shape of the document cannot show: ids given twice, places outside the image, types the KB has not."""
    rows = data.get("appearances") if isinstance(data, dict) else None
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
    """What is wrong with a descriptor's text for an appearance of this type: a keypoint detector's name, or a word of it.

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
    if not (
        isinstance(uv, list)
        and len(uv) == 2
        and all(type(x) is int or (type(x) is float and math.isfinite(x)) for x in uv)
    ):
        return False
    return not (-0.5 <= uv[0] <= camera.width - 0.5 and -0.5 <= uv[1] <= camera.height - 0.5)


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
