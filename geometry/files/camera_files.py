"""Cameras from the files that others write.

| file | told by | what is put right |
|---|---|---|
| the contract's `camera` key as JSON | `width` and `K` | |
| `gamma/1` and `interpretation/1` JSON | `camera` | |
| BOP `camera.json` | `fx` | |
| BOP `scene_camera.json` | numbered keys with `cam_K` | mm to m; size from a `camera.json` beside or above |
| COLMAP `cameras.txt` | `id MODEL width height ...` | principal point - 0.5 px |
| ROS `camera_info` YAML | `image_width` or `width`, `camera_matrix` or `K` | |
| OpenCV FileStorage YAML | `!!opencv-matrix` | the same keys; `%YAML:1.0` |
"""

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geometry.camera import Camera, camera_from_dict
from geometry.errors import CameraError
from geometry.files.camera_formats import colmap_cameras, from_bop_intrinsics, from_bop_scene, from_calibration
from geometry.files.camera_yaml import read_yaml
from geometry.files.plain_files import fault_of

MAX_BYTES = 64 * 2**20  # a BOP scene of 10^5 images stays below


def read_camera(path: str | Path, frame: str | int | None = None, *, size: tuple[int, int] | None = None) -> Camera:
    """The camera that the file `path` describes, whichever of the kinds above it is.

    `frame` names one camera where the file has many (BOP: the image's number, COLMAP: the camera's); one alone needs no
    name. `size` (width, height) px is used where the file states none.

    Raises:
        CameraError: one line with the file, the key or the line, and what is wrong.
    """
    place = Path(path)
    text = _text(place)
    try:
        document = _document(place, text, frame, size)
        return camera_from_dict(document)
    except CameraError as error:
        raise CameraError(error.message, path=path, line=error.line) from error


def _document(path: Path, text: str, frame: str | int | None, size: tuple[int, int] | None) -> object:
    """The contract's `camera` key for the file's `text`."""
    if text.lstrip("\ufeff \t\r\n").startswith(("{", "[")):
        return _from_json(path, _json(text), frame, size)
    if cameras := colmap_cameras(text):
        return _chosen(cameras, frame, "camera")
    content = read_yaml(text)
    if not isinstance(content, Mapping):
        raise CameraError(f"must be a camera in JSON, YAML or COLMAP's text, not {type(content).__name__}")
    return from_calibration(content, size)


def _from_json(path: Path, content: object, frame: str | int | None, size: tuple[int, int] | None) -> object:
    if not isinstance(content, Mapping):
        raise CameraError(f"must be a JSON object, not {type(content).__name__}")
    if "camera" in content:
        return content["camera"]
    if "fx" in content:
        return from_bop_intrinsics(content, size)
    if content and all(isinstance(value, Mapping) and "cam_K" in value for value in content.values()):
        return from_bop_scene(_chosen(content, frame, "frame"), size or _bop_size(path))
    if {"width", "K"} & set(content):
        return content
    raise CameraError(
        "has none of the keys of a camera (width, height, K), of Γ (camera) or of BOP (fx, or frames with cam_K)"
    )


def _chosen(entries: Mapping[str, Any], frame: str | int | None, kind: str) -> object:
    """The entry called `frame`; the only one where no name is given."""
    if frame is None and len(entries) == 1:
        return next(iter(entries.values()))
    known = ", ".join([*entries][:8]) + (", ..." if len(entries) > 8 else "")
    if frame is None:
        raise CameraError(f"has {len(entries)} cameras; say which {kind}: {known}")
    name = str(frame).lstrip("0") or "0"
    for key, entry in entries.items():
        if (key.lstrip("0") or "0") == name:
            return entry
    raise CameraError(f"has no {kind} {frame}; it has {known}")


def _bop_size(path: Path) -> tuple[int, int] | None:
    """The size that a BOP dataset's `camera.json` states: scenes lie two folders below it."""
    for folder in list(path.resolve().parents)[:3]:
        beside = folder / "camera.json"
        if fault_of(beside) is None:
            content = _json(_text(beside))
            if isinstance(content, Mapping) and {"width", "height"} <= set(content):
                return content["width"], content["height"]
    return None


def _text(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise CameraError(f"cannot be read: {error.strerror or error}", path=path) from error
    if len(raw) > MAX_BYTES:
        raise CameraError(f"must be a camera of at most {MAX_BYTES} bytes", path=path)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CameraError(f"must be UTF-8 text: byte {error.start} is not", path=path) from error


def _json(text: str) -> object:
    try:
        return json.loads(text, object_pairs_hook=_unique)
    except json.JSONDecodeError as error:
        raise CameraError(f"is not JSON: {error.msg} in column {error.colno}", line=error.lineno) from error
    except ValueError as error:
        raise CameraError(f"is not JSON: {error}") from error
    except RecursionError as error:
        raise CameraError("is nested too deeply for a camera") from error


def _unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
    content = dict(pairs)
    if len(content) < len(pairs):
        times = Counter(name for name, _ in pairs)
        raise CameraError(f"{next(name for name in times if times[name] > 1)}: is given twice")
    return content
