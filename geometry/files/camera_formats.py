"""Each foreign description of a camera, as the contract's `camera` key, whose numbers are checked afterwards."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from geometry.errors import CameraError
from geometry.frames import from_rotation_translation, inverse

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
