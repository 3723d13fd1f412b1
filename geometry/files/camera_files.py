"""Cameras from the files that others write.

| file | told by | what is put right |
|---|---|---|
| the contract's `camera` key as JSON | `width` and `K` | K of nine numbers in a row becomes 3x3 |
| `gamma/1` and `interpretation/1` JSON | `camera` | |
| BOP `camera.json` | `fx` | |
| BOP `scene_camera.json` | numbered keys with `cam_K` | mm to m; size from a `camera.json` beside or above |
| COLMAP `cameras.txt`, `cameras.bin`, a folder with one | `geometry.files.colmap_files` | principal point - 0.5 px |
| K alone: nine numbers, in rows or one | nothing else is there | the size is the picture's |
| ROS `camera_info`, OpenCV FileStorage YAML, XML, JSON | `geometry.files.calibration_files` | |

Each foreign description of a camera, as the contract's `camera` key, whose numbers are checked afterwards.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from geometry.arrays import Floats, numbers_of
from geometry.camera import Camera, camera_from_dict, camera_mistakes
from geometry.errors import CameraError, Keys, Mistake, WhichCameraError, told
from geometry.files.calibration_files import (
    Size,
    calibration,
    flat,
    from_calibration,
    is_foreign,
    size_of,
    xml_calibration,
)
from geometry.files.colmap_files import Stated, cameras_file, colmap_binary, colmap_text, taken_by
from geometry.files.documents import Document, parsed_json, read_json
from geometry.files.plain_files import content_of, fault_of, text_of
from geometry.frames import from_rotation_translation, inverse
from geometry.json_checks import shown

MAX_BYTES = 64 * 2**20  # a BOP scene of 10^5 images stays below
HOLDS = "it should hold a camera"
NOWHERE: Keys = ()
_JSON = re.compile(r"[\ufeff\s]*(\{|\[(?![A-Z]))")
"""How JSON begins; `[INFO]` does not."""
_COMMENT, _NUMBERS, _WORD = re.compile(r"#[^\n]*"), re.compile(r"[-+.,;\deE\s\[\]]*"), re.compile(r"[^,;\s\[\]]+")
"""K alone: numbers, and what stands between them."""
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
    file = cameras_file(Path(path))
    if file.suffix == ".bin":
        with _told_of(file):
            return _of_colmap(colmap_binary(content_of(file, MAX_BYTES, CameraError)), file, frame, photo)
    text = text_of(file, MAX_BYTES, CameraError, "camera")
    with _told_of(file):
        if alone := _of_matrix(text, size):
            return camera_from_dict(alone)
    if _JSON.match(text):
        document = parsed_json(text, str(path), HOLDS, CameraError, single=True)
        return _from_json(document, file, frame, size, photo)
    with _told_of(file):
        if text.lstrip("\ufeff \t\r\n").startswith("<"):
            return camera_from_dict(xml_calibration(text.lstrip("\ufeff"), size))
        if cameras := colmap_text(text):
            return _of_colmap(cameras, file, frame, photo)
        return camera_from_dict(calibration(text, size))


@contextmanager
def _told_of(file: Path) -> Iterator[None]:
    """An error names the file, unless it names one already."""
    try:
        yield
    except CameraError as error:
        if error.path is not None:
            raise
        raise type(error)(error.message, path=file, line=error.line) from error


def _of_matrix(text: str, size: Size) -> dict[str, Any] | None:
    """The contract's `camera` key of K alone, in rows (`numpy.savetxt`, `numpy`'s own print, CSV) or one; None of else.

    Raises:
        CameraError: numbers alone, but not nine of them, or no size.
    """
    plain = _COMMENT.sub("", text.lstrip("\ufeff"))
    if not _NUMBERS.fullmatch(plain):
        return None
    try:
        rows = [[float(word) for word in words] for line in plain.splitlines() if (words := _WORD.findall(line))]
    except ValueError:
        return None
    values = [value for row in rows for value in row]
    if not values or (len(values) != 9 and _JSON.match(text)):
        return None
    if len(values) != 9 or len({len(row) for row in rows}) > 1:
        lengths = shown([len(row) for row in rows])
        raise CameraError(f"holds numbers alone, and K alone is three rows of three, or nine in one row, not {lengths}")
    width, height = size_of({}, size)
    return {"width": width, "height": height, "K": [values[:3], values[3:6], values[6:]], "dist": []}


def _of_colmap(cameras: Mapping[str, Stated], file: Path, name: str | int | None, photo: str | Path | None) -> Camera:
    """The camera of a name, or of the photo, or the only one."""
    why = ""
    if name is None and photo is not None and len(cameras) > 1:
        name = taken_by(file, photo)
        why = f"; {file.with_name('images').name}{file.suffix} tells no one camera for {Path(photo).name}"
    return camera_from_dict(_chosen(cameras, name, "camera", why)[1].described())


def _from_json(document: Document, path: Path, frame: str | int | None, size: Size, photo: str | Path | None) -> Camera:
    content, keys = document.data, NOWHERE
    if isinstance(content, dict) and "camera" in content:
        content, keys = content["camera"], ("camera",)
    elif _is_bop(content):
        number = Path(photo or "").stem.lstrip("0") or "0"
        known = photo is not None and frame is None and isinstance(content, dict) and number in content
        return _from_bop(document, path, number if known else frame, size)
    if is_foreign(content):
        with _told_of(path):
            return camera_from_dict(from_calibration(content, size, document.text))
    if isinstance(content, dict) and isinstance(K := content.get("K"), list) and len(K) == 9:
        content = content | {"K": [K[:3], K[3:6], K[6:]]}
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
        raise type(error)(told(document.told([Mistake(keys, error.message)]))) from None


def _chosen(entries: Mapping[str, Any], frame: str | int | None, kind: str, why: str = "") -> tuple[str, Any]:
    """The entry called `frame`, with its name; the only one where no name is given."""
    if not entries:
        raise CameraError("has no camera")
    if frame is None and len(entries) == 1:
        return next(iter(entries.items()))
    known = ", ".join([*entries][:8]) + (", ..." if len(entries) > 8 else "")
    if frame is None:
        raise WhichCameraError(
            f"has {len(entries)} cameras; say which {kind}: {known} (FILE#{next(iter(entries))}){why}"
        )
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


def from_bop_intrinsics(content: Mapping[str, Any], size: Size) -> dict[str, Any]:
    """BOP's `camera.json`: fx, fy, cx, cy, width, height."""
    missing = [key for key in ("fx", "fy", "cx", "cy") if key not in content]
    if missing:
        raise CameraError(f"{missing[0]}: is missing beside fx")
    width, height = size_of(content, size)
    K = [[content["fx"], 0, content["cx"]], [0, content["fy"], content["cy"]], [0, 0, 1]]
    return {"width": width, "height": height, "K": K, "dist": []}


def from_bop_scene(entry: object, size: Size) -> dict[str, Any]:
    """One frame of BOP's `scene_camera.json`: cam_K, and cam_R_w2c with cam_t_w2c in mm where there are any."""
    if not isinstance(entry, Mapping):
        raise CameraError(f"a frame must be an object, not {type(entry).__name__}")
    K = _numbers(entry.get("cam_K"), 9, "cam_K")
    width, height = size_of(entry, size)
    camera = {"width": width, "height": height, "K": K.reshape(3, 3).tolist(), "dist": []}
    if "cam_R_w2c" in entry:
        R = _numbers(entry["cam_R_w2c"], 9, "cam_R_w2c").reshape(3, 3)
        t = _numbers(entry.get("cam_t_w2c"), 3, "cam_t_w2c") / 1000
        camera["T_world_camera"] = inverse(from_rotation_translation(R, t)).tolist()
    return camera


def _numbers(value: object, count: int, where: str) -> Floats:
    numbers = flat(value, where)
    found = numbers_of(numbers, count)
    if found is None:
        raise CameraError(f"{where}: must hold {count} numbers, not {shown(numbers)}")
    return found
