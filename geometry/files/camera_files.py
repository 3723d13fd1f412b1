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

Each foreign description of a camera, as the contract's `camera` key, whose numbers are checked afterwards.

YAML of calibrations, read safely: plain data and OpenCV's matrices, no other tag, no duplicate key, no YAML bomb.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.composer import MaxDepthExceededError
from ruamel.yaml.constructor import SafeConstructor
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from geometry.camera import Camera, camera_from_dict, camera_mistakes
from geometry.errors import CameraError, Keys, Mistake, told
from geometry.files.documents import Document, parsed_json, read_json
from geometry.files.plain_files import fault_of, text_of
from geometry.frames import from_rotation_translation, inverse

MAX_DEPTH = 20
"""Levels of nesting: a calibration has four."""
MAX_CHARS = 2**20  # a calibration is some hundreds


Size = tuple[int, int] | None  # width, height px, where the file states none

_MATRIX_KEYS = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "intrinsic_matrix", "K", "k")
_LENS_KEYS = (
    "distortion_coefficients",
    "dist_coeffs",
    "distCoeffs",
    "Distortion_Coefficients",
    "distortion_coeffs",
    "dist",
    "D",
    "d",
)
_LENSES = ("plumb_bob", "rational_polynomial", "none", "")  # ROS names of the lens models that we have
_COLMAP_LINE = re.compile(r"\s*\d+\s+[A-Z_]+\s+\d+\s+\d+\s")
_COLMAP_MODELS = {  # COLMAP's parameters by our names; f is both focal lengths
    "SIMPLE_PINHOLE": "f cx cy",
    "PINHOLE": "fx fy cx cy",
    "SIMPLE_RADIAL": "f cx cy k1",
    "RADIAL": "f cx cy k1 k2",
    "OPENCV": "fx fy cx cy k1 k2 p1 p2",
    "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6",
}


MAX_BYTES = 64 * 2**20  # a BOP scene of 10^5 images stays below
HOLDS = "it should hold a camera"
NOWHERE: Keys = ()
STRANGE = "has none of the keys of a camera (width, height, K), of Γ (camera) or of BOP (fx, or frames with cam_K)"


def read_camera(
    path: str | Path,
    frame: str | int | None = None,
    *,
    size: tuple[int, int] | None = None,
    photo: str | Path | None = None,
) -> Camera:
    """The camera that the file `path` describes, whichever of the kinds above it is.

    `frame` names one camera where the file has many (BOP: the image's number, COLMAP: the camera's); one alone needs no
    name, nor do those that the file tells by their pictures, where `photo` is one of them. `size` (width, height) px is
    used where the file states none.

    Raises:
        CameraError: one line with the file, the key or the line, and what is wrong.
    """
    text = text_of(path, MAX_BYTES, CameraError, "camera")
    if text.lstrip("\ufeff \t\r\n").startswith(("{", "[")):
        document = parsed_json(text, str(path), HOLDS, CameraError, single=True)
        return _from_json(document, Path(path), frame, size, photo)
    try:
        return camera_from_dict(_told(text, frame, size))
    except CameraError as error:
        raise CameraError(error.message, path=path, line=error.line) from error


def _told(text: str, frame: str | int | None, size: Size) -> object:
    """The contract's `camera` key for COLMAP's or YAML's `text`."""
    if cameras := colmap_cameras(text):
        return _chosen(cameras, frame, "camera")[1]
    content = read_yaml(text)
    if not isinstance(content, Mapping):
        raise CameraError(f"must be a camera in JSON, YAML or COLMAP's text, not {type(content).__name__}")
    return from_calibration(content, size)


def _from_json(document: Document, path: Path, frame: str | int | None, size: Size, photo: str | Path | None) -> Camera:
    content, keys = document.data, NOWHERE
    if isinstance(content, dict) and "camera" in content:
        content, keys = content["camera"], ("camera",)
    elif _is_bop(content):
        number = Path(photo or "").stem.lstrip("0") or "0"
        known = photo is not None and frame is None and isinstance(content, dict) and number in content
        return _from_bop(document, path, number if known else frame, size)
    wrong = camera_mistakes(content, keys)
    if len(wrong) > 1 and isinstance(content, dict) and not {"width", "K"} & set(content):
        wrong = [Mistake(keys, STRANGE)]
    if wrong:
        raise CameraError(told(document.told(wrong)))
    return camera_from_dict(content)


def _is_bop(content: object) -> bool:
    """Whether a document is BOP's `camera.json` or `scene_camera.json`."""
    return isinstance(content, dict) and (
        "fx" in content or (bool(content) and all(isinstance(v, dict) and "cam_K" in v for v in content.values()))
    )


def _from_bop(document: Document, path: Path, frame: str | int | None, size: Size) -> Camera:
    """A camera of BOP's; what is wrong with it is told at its place."""
    keys: Keys = ()
    try:
        if "fx" in document.data:
            return camera_from_dict(from_bop_intrinsics(document.data, size))
        name, entry = _chosen(document.data, frame, "frame")
        keys = (name,)
        return camera_from_dict(from_bop_scene(entry, size or _bop_size(path)))
    except CameraError as error:
        raise CameraError(told(document.told([Mistake(keys, error.message)]))) from None


def _chosen(entries: Mapping[str, Any], frame: str | int | None, kind: str) -> tuple[str, object]:
    """The entry called `frame`, with its name; the only one where no name is given."""
    if frame is None and len(entries) == 1:
        return next(iter(entries.items()))
    known = ", ".join([*entries][:8]) + (", ..." if len(entries) > 8 else "")
    if frame is None:
        raise CameraError(f"has {len(entries)} cameras; say which {kind}: {known}")
    name = str(frame).lstrip("0") or "0"
    for key, entry in entries.items():
        if (key.lstrip("0") or "0") == name:
            return key, entry
    raise CameraError(f"has no {kind} {frame}; it has {known}")


def _bop_size(path: Path) -> Size:
    """The size that a BOP dataset's `camera.json` states: scenes lie two folders below it."""
    for folder in list(path.resolve().parents)[:3]:
        beside = folder / "camera.json"
        if fault_of(beside) is None:
            content = read_json(beside, MAX_BYTES, HOLDS, CameraError).data
            if isinstance(content, Mapping) and {"width", "height"} <= set(content):
                return content["width"], content["height"]
    return None


def from_calibration(content: Mapping[Any, Any], size: Size) -> dict[str, Any]:
    """A ROS `camera_info` or an OpenCV FileStorage calibration."""
    model = content.get("distortion_model", "")
    if model not in _LENSES:
        raise CameraError(f"distortion_model: must be plumb_bob or rational_polynomial, not {model!r}")
    K = _flat(_first(content, _MATRIX_KEYS, "camera_matrix"), "camera_matrix")
    if len(K) != 9:
        raise CameraError(f"camera_matrix: must hold 9 numbers, not {len(K)}")
    lens: object = next((content[key] for key in _LENS_KEYS if key in content), [])
    width, height = _size(content, size)
    return {
        "width": width,
        "height": height,
        "K": [K[:3], K[3:6], K[6:]],
        "dist": _flat(lens, "distortion_coefficients"),
    }


def from_bop_intrinsics(content: Mapping[str, Any], size: Size) -> dict[str, Any]:
    """BOP's `camera.json`: fx, fy, cx, cy, width, height."""
    missing = [key for key in ("fx", "fy", "cx", "cy") if key not in content]
    if missing:
        raise CameraError(f"{missing[0]}: is missing beside fx")
    width, height = _size(content, size)
    K = [[content["fx"], 0, content["cx"]], [0, content["fy"], content["cy"]], [0, 0, 1]]
    return {"width": width, "height": height, "K": K, "dist": []}


def from_bop_scene(entry: object, size: Size) -> dict[str, Any]:
    """One frame of BOP's `scene_camera.json`: cam_K, and cam_R_w2c with cam_t_w2c in mm where there are any."""
    if not isinstance(entry, Mapping):
        raise CameraError(f"a frame must be an object, not {type(entry).__name__}")
    K = _numbers(entry.get("cam_K"), 9, "cam_K")
    width, height = _size(entry, size)
    camera = {"width": width, "height": height, "K": K.reshape(3, 3).tolist(), "dist": []}
    if "cam_R_w2c" in entry:
        R = _numbers(entry["cam_R_w2c"], 9, "cam_R_w2c").reshape(3, 3)
        t = _numbers(entry.get("cam_t_w2c"), 3, "cam_t_w2c") / 1000
        camera["T_world_camera"] = inverse(from_rotation_translation(R, t)).tolist()
    return camera


def colmap_cameras(text: str) -> dict[str, dict[str, Any]]:
    """The cameras of a COLMAP `cameras.txt` by their numbers; empty where `text` is nothing of the kind."""
    lines = [
        (n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines or not _COLMAP_LINE.match(lines[0][1]):
        return {}
    return {line.split()[0]: _colmap(line.split(), n) for n, line in lines}


def _colmap(words: list[str], line: int) -> dict[str, Any]:
    """One line: id, model, width, height, parameters. A pixel's centre is at .5 there, at .0 here."""
    model = words[1] if len(words) > 1 else ""
    if model not in _COLMAP_MODELS:
        raise CameraError(f"COLMAP's model must be one of {', '.join(_COLMAP_MODELS)}, not {model!r}", line=line)
    names = _COLMAP_MODELS[model].split()
    try:
        width, height = int(words[2]), int(words[3])
        values = dict(zip(names, map(float, words[4:]), strict=True))
    except (ValueError, IndexError) as error:
        raise CameraError(f"{model} must be followed by width, height, {', '.join(names)}", line=line) from error
    fx, fy = values.get("fx", values.get("f", 0.0)), values.get("fy", values.get("f", 0.0))
    lens = [values.get(name, 0.0) for name in ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")]
    K = [[fx, 0, values["cx"] - 0.5], [0, fy, values["cy"] - 0.5], [0, 0, 1]]
    return {"width": width, "height": height, "K": K, "dist": lens if any(lens) else []}


def _size(content: Mapping[Any, Any], size: Size) -> tuple[Any, Any]:
    for wide, high in (("image_width", "image_height"), ("width", "height"), ("image_Width", "image_Height")):
        if wide in content and high in content:
            return content[wide], content[high]
    if size is None:
        raise CameraError("states no width and height; give the image's size")
    return size


def _first(content: Mapping[Any, Any], keys: tuple[str, ...], name: str) -> object:
    for key in keys:
        if key in content:
            return content[key]
    raise CameraError(f"{name}: is missing, and so is {', '.join(keys[1:])}")


def _flat(value: object, where: str) -> list[Any]:
    """The numbers of a matrix, written as {rows, cols, data}, as rows, or as one list."""
    data = value.get("data") if isinstance(value, Mapping) else value
    if not isinstance(data, list):
        raise CameraError(f"{where}: must be a list of numbers or a matrix with data, not {value!r}")
    return [number for row in data for number in (row if isinstance(row, list) else [row])]


def _numbers(value: object, count: int, where: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    flat = _flat(value, where)
    if len(flat) != count or not all(isinstance(number, (int, float)) for number in flat):
        raise CameraError(f"{where}: must hold {count} numbers, not {value!r}")
    return np.array(flat, dtype=np.float64)


class _Constructor(SafeConstructor):
    """Plain YAML, and `!!opencv-matrix` as the mapping that it is."""

    def opencv_matrix(self, node: Any) -> dict[Any, Any]:  # noqa: ANN401 - ruamel's nodes have no common type
        return dict(self.construct_mapping(node, deep=True))


_Constructor.add_constructor("tag:yaml.org,2002:opencv-matrix", _Constructor.opencv_matrix)


def read_yaml(text: str) -> object:
    """The data in `text`: mappings, lists, texts, numbers.

    Raises:
        CameraError: with the line where it can, for anything else.
    """
    if len(text) > MAX_CHARS:
        raise CameraError(f"must be a calibration of at most {MAX_CHARS} characters, not {len(text)}")
    loader = YAML(typ="safe", pure=True)
    loader.Constructor, loader.max_depth = _Constructor, MAX_DEPTH
    try:
        return loader.load(_without_directive(text))
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        deep = isinstance(error, MaxDepthExceededError)
        why = (
            f"nested deeper than {MAX_DEPTH} levels" if deep else " ".join(str(error.problem or error.context).split())
        )
        raise CameraError(f"is not plain YAML: {why}", line=None if mark is None else mark.line + 1) from error
    except (YAMLError, ValueError, RecursionError, TypeError) as error:
        why = " ".join(str(error).split())[:120]
        raise CameraError(f"is not plain YAML: {why}") from error


def _without_directive(text: str) -> str:
    """`text` with OpenCV's `%YAML:1.0`, which is no YAML, made a comment: lines keep their numbers."""
    return f"#{text}" if text.startswith("%YAML:") else text
