"""Calibrations of ROS, as a YAML file or as a topic that was echoed, and of OpenCV's FileStorage.

| text | told by |
|---|---|
| ROS `camera_info` YAML | `image_width` or `width`, `camera_matrix` |
| `ros2 topic echo`, `rostopic echo` of a CameraInfo | `k` or `K`; messages between lines `---`, which must agree |
| OpenCV FileStorage YAML | `!!opencv-matrix`, the same keys; `%YAML:1.0` |
| OpenCV FileStorage XML | `<opencv_storage>`, the same keys |
| OpenCV FileStorage JSON, a ROS message as JSON | the same keys (`geometry.files.camera_files`) |

K and D are those of the raw picture. Of an echoed message the binning and the region of interest are applied, so that
the camera is that of the pictures that the driver sends.

YAML is read safely (`geometry.files.calibration_yaml`), XML without entities. What
`ros2 topic echo` prints between messages, such as that one was lost, is passed over.
"""

import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeGuard

from geometry.camera import camera_mistakes
from geometry.digits import whole
from geometry.errors import CameraError, told
from geometry.files.xml_files import XMLMistakeError, root_of

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_CHARS = 100_000  # a calibration is some hundreds, and 50,000 a second are read

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
_FOREIGN = {*_MATRIX_KEYS, *_LENS_KEYS, "distortion_model"} - {"K", "dist"}
_LENSES = ("plumb_bob", "rational_polynomial", "none", "")  # ROS names of the lens models that we have
_ARRAY = re.compile(r"array\((?:'[a-z]', *)?\[(.*)\]\)", re.DOTALL)  # Python's, as early ROS 2 prints it
_LINE = re.compile(r"[A-Za-z_]\w*:(\s|$)|[ #%{}\[\]-]|\r?\n")
"""How a line of a message begins: with a key, or deeper in; YAML is not indented by tabs."""
_WARNING = re.compile(r"\[?(DEBUG|INFO|WARN|WARNING|ERROR|FATAL)\b")
CUT = "..."
"""What stands in an echoed message for what was left out."""
MOST_MESSAGES = 8
"""Messages that differ, of which it is looked at whether their cameras do."""


def calibration(text: str, size: Size) -> dict[str, Any]:
    """The contract's `camera` key of a calibration, or of a topic's messages where they agree. Raises CameraError."""
    contents = [(_message(part), part) for part in _messages(text)] or [(None, text)]
    mappings = [(content, part) for content, part in contents if isinstance(content, Mapping)]
    if not mappings:
        what = type(contents[0][0]).__name__
        raise CameraError(f"must be a camera in JSON, YAML, XML or COLMAP's text, not {what}")
    whole = [each for each in mappings if any(key in each[0] for key in _MATRIX_KEYS)] or mappings
    (first, own), *others = whole
    camera = from_calibration(first, size, own)
    for number, (other, part) in enumerate(others[:MOST_MESSAGES], 2):
        if from_calibration(other, size, part) != camera:
            raise CameraError(
                f"holds messages of different cameras: keep one (the first, and number {number} of those)"
            )
    return camera


def _messages(text: str) -> Iterator[str]:
    """The documents of a text that differ in more than their header, each at its own lines.

    The last, which Ctrl-C may have cut off, is left out where it is the beginning of the first.
    """
    lines, start = text.splitlines(keepends=True), 0
    ends = [n for n, line in enumerate(lines) if line.rstrip() == "---"]
    seen: list[str] = []
    for end in (*ends, len(lines)):
        own, before = lines[start:end], start
        start = end + 1
        body = _without_header(own).strip()
        if body and not any(other == body or (end == len(lines) and other.startswith(body)) for other in seen):
            seen = [*seen, body][: MOST_MESSAGES + 1]
            yield "\n" * before + "".join(own)


def _without_header(lines: list[str]) -> str:
    """The lines that say what a message is, without comments and directives, and the time in its header."""
    inside, kept = False, []
    for line in lines:
        inside = line.startswith("header:") or (inside and line[:1] in (" ", "\t"))
        if not inside and not line.startswith(("#", "%")):
            kept.append(line)
    return "".join(kept)


def is_foreign(content: object) -> TypeGuard[Mapping[Any, Any]]:
    """Whether an object of JSON is a calibration by the keys of others, not the contract's `camera`."""
    return isinstance(content, Mapping) and not _FOREIGN.isdisjoint(content)


def _message(text: str) -> object:
    """One document of a text; where it is no YAML, without the lines that a tool printed between those of a message."""
    from geometry.files.calibration_yaml import read_yaml  # most cameras are JSON

    try:
        return read_yaml(text, MAX_CHARS)
    except CameraError:
        clean = "".join(
            line if _LINE.match(line) and not _WARNING.match(line) else "\n" for line in text.splitlines(keepends=True)
        )
        if clean == text:
            raise
    return read_yaml(clean, MAX_CHARS)


def from_calibration(content: Mapping[Any, Any], size: Size, text: str) -> dict[str, Any]:
    """The contract's `camera` key of a ROS `camera_info` or an OpenCV FileStorage calibration, written in a `text`.

    Raises:
        CameraError: with the line of what is wrong.
    """
    model = content.get("distortion_model", "")
    if model not in _LENSES:
        what = f"distortion_model: must be plumb_bob or rational_polynomial, not {model!r:.40}"
        why = "rectify the pictures, and give the camera of the rectified ones"
        raise CameraError(f"{what}: {why}", line=_line_of(text, "distortion_model"))
    matrix = next((key for key in _MATRIX_KEYS if key in content), None)
    if matrix is None:
        raise CameraError(f"camera_matrix: is missing, and so is {', '.join(_MATRIX_KEYS[1:])}")
    lens = next((key for key in _LENS_KEYS if key in content), "")
    K = flat(content[matrix], "camera_matrix", _line_of(text, matrix))
    if len(K) != 9:
        raise CameraError(f"camera_matrix: must hold 9 numbers, not {len(K)}", line=_line_of(text, matrix))
    if not any(K):
        what = "camera_matrix: is all zeros, as a driver says that has no calibration"
        raise CameraError(what, line=_line_of(text, matrix))
    width, height = size_of(content, size)
    dist = flat(content[lens], "distortion_coefficients", _line_of(text, lens)) if lens else []
    camera = _sent({"width": width, "height": height, "K": [K[:3], K[3:6], K[6:]], "dist": dist}, content, text)
    if wrong := camera_mistakes(camera, ("camera",)):
        key = {"K": matrix, "dist": lens}.get(str(wrong[0].place[1]), f"(?:image_)?(?i:{wrong[0].place[1]})")
        raise CameraError(told(wrong, "; "), line=_line_of(text, key))
    return camera


def _line_of(text: str, *keys: str) -> int | None:
    """The line at which a key stands, each below the one before; the keys are patterns. None where it does not.

    It is looked for in the text, which is YAML, JSON or XML, as no reader of all three tells lines.
    """
    at = 0
    for key in keys:
        places = re.finditer(rf"#.*|((?<!\w){key}[\"']?(?=\s*:|>| type_id))", text[at:])
        end = next((place.end() for place in places if place[1]), None)
        if end is None:
            return None
        at += end
    return text.count("\n", 0, at) + 1


def _sent(camera: dict[str, Any], content: Mapping[Any, Any], text: str) -> dict[str, Any]:
    """The camera of the pictures that a driver sends: the region of interest, its pixels joined (binning)."""
    whole = {"width": camera["width"], "height": camera["height"]}
    left, above, width, height = (_count(content, text, "roi", key) for key in ("x_offset", "y_offset", *whole))
    across, down = (max(_count(content, text, key), 1) for key in ("binning_x", "binning_y"))
    if (left, above, width or whole["width"], height or whole["height"], across, down) == (0, 0, *whole.values(), 1, 1):
        return camera
    (fx, skew, cx), (_, fy, cy), last = camera["K"]
    try:
        first = [fx / across, skew / across, (cx - left + 0.5) / across - 0.5]
        second = [0, fy / down, (cy - above + 0.5) / down - 0.5]
        size = {"width": (width or whole["width"]) // across, "height": (height or whole["height"]) // down}
    except (TypeError, OverflowError):
        raise CameraError("camera_matrix, width, height, roi and binning: must be numbers of sensible size") from None
    return {**camera, **size, "K": [first, second, last]}


def _count(content: Mapping[Any, Any], text: str, *keys: str) -> int:
    value: Any = content
    for key in keys:
        value = value.get(key, 0) if isinstance(value, Mapping) else 0
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        what = f"{'.'.join(keys)}: must be a whole number from 0, not {value!r:.40}"
        raise CameraError(what, line=_line_of(text, *keys))
    return value


def size_of(content: Mapping[Any, Any], size: Size) -> tuple[Any, Any]:
    """Width and height as they are stated; `size` where they are not. Raises CameraError where that is None."""
    for wide, high in (("image_width", "image_height"), ("width", "height"), ("image_Width", "image_Height")):
        if wide in content and high in content:
            return content[wide], content[high]
    if size is None:
        raise CameraError("states no width and height; give the image's size")
    return size


def flat(value: object, where: str, line: int | None = None) -> list[Any]:
    """The numbers of a matrix, written as {rows, cols, data}, as rows, as one list, or as Python's array."""
    data = value.get("data") if isinstance(value, Mapping) else value
    if isinstance(data, str) and (array := _ARRAY.fullmatch(data.strip())):
        data = [_number(word.strip()) for word in array[1].split(",") if word.strip()]
    if not isinstance(data, list):
        raise CameraError(f"{where}: must be a list of numbers or a matrix with data, not {value!r:.80}", line=line)
    numbers = [number for row in data for number in (row if isinstance(row, list) else [row])]
    if CUT in numbers:
        raise CameraError(f"{where}: is cut off ('...'): print it whole, ros2 topic echo --full-length", line=line)
    return numbers


def _number(word: str) -> float | str:
    try:
        return float(word)
    except ValueError:
        return word


def xml_calibration(text: str, size: Size) -> dict[str, Any]:
    """The contract's `camera` key of an OpenCV FileStorage in XML. Raises CameraError."""
    if len(text) > MAX_CHARS:
        raise CameraError(f"must be a calibration of at most {MAX_CHARS} characters, not {len(text)}")
    try:
        root = root_of(text, "calibration")
    except XMLMistakeError as error:
        raise CameraError(str(error), line=error.line) from None
    if root.tag != "opencv_storage":
        raise CameraError(f"is no OpenCV FileStorage: its first element is <{root.tag:.60}>, not <opencv_storage>")
    return from_calibration({element.tag: _value_of(element) for element in root}, size, text)


def _value_of(element: "Element") -> object:
    """A number, a text, or a matrix as the mapping that it is in YAML."""
    data = element.find("data")
    if data is not None:
        return {"data": [_number(word) for word in (data.text or "").split()]}
    text = (element.text or "").strip()
    number = whole(text, 10**9)  # no width is as large
    return _number(text) if number is None else number
