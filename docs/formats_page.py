"""The text of docs/formats.md: every format with an example, and every key with what it is and means.

All of it is read from the shapes that the readers hold documents to, and from the files in examples/formats.
"""
# ruff: noqa: INP001 - a script, no package

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args, is_typeddict

from geometry.files.json_schema import name_of, summary
from geometry.json_shapes import Row, described, options_of, parts_of
from plogic.face.commands.formats import Format, formats

if TYPE_CHECKING:
    from collections.abc import Iterator

EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "formats"
HEAD = """# The formats of files

Written by `python docs/generate.py` from the shapes that the commands hold files to. Do not edit.

Metres and radians. Camera frame: x right, y down, z forward; an integer pixel is a pixel's centre. World: z up. Poses are
4x4, row by row, and are named by their frames: `T_camera_object` maps object coordinates to camera coordinates
([conventions](conventions.md)). The files of a knowledge base are YAML: [knowledge bases](knowledge-bases.md),
`plogic kb schema`.

`plogic schema NAME` prints a format as JSON Schema (draft 2020-12), made of the same shapes. Every key that a table below
does not name is a mistake. Whole numbers are written without a point. What is wrong is told with line and column, all of
it at once:

```text
gamma.json:4:41: appearances.0.uv: a list of 1, and not of 2
```

What no schema says, and the readers check too: a pose is rigid, ids are told once, `uv` lies in the image, an appearance's
type is one of the KB's, `depth` and `depth_sigma` come together, a hypothesis or an appearance that is named is there, and
a move has one of its two poses."""

CAMERAS = """### Cameras from elsewhere

A picture's camera is told in one of these ways; two at once are an error (`perceive`, `batch`, `kb learn --photo`):

| option | the camera |
|---|---|
| `--camera FILE` | that of the file: the JSON above, alone or as the key `camera` of another document, or a kind of the next table |
| `--camera FILE#NAME` | one of many: COLMAP's camera id, BOP's image number. Without a name the picture's own is taken: by its name in `images.txt` or `images.bin`, by its number in `scene_camera.json` |
| `--fov DEG` | ideal, with this field of view from the left edge to the right |
| `--fov-diagonal DEG` | ideal, with this field of view from corner to corner, as phones state it |
| `--focal PX` | ideal, with this focal length |
| none | `batch`: that of `camera.json` beside the picture. Else ideal, with the focal length in the picture's EXIF, and one line says so |

An ideal camera has square pixels, no lens distortion, and its principal point in the middle of the picture.

| file | what is read, and what is put right |
|---|---|
| ROS `camera_info` YAML | K and D, those of raw pictures; `plumb_bob` and `rational_polynomial` |
| `ros2 topic echo`, `rostopic echo` | the same of printed messages, which must agree; binning and region of interest are applied. What was cut off (`'...'`) is an error: `--full-length` prints it |
| OpenCV FileStorage YAML | `camera_matrix`, `distortion_coefficients`, `image_width`, `image_height` |
| BOP `camera.json`, `scene_camera.json` | millimetres become metres |
| COLMAP `cameras.txt`, `cameras.bin`, or a folder that holds one, also in `sparse/0` or `sparse` | SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV. A pixel's centre is at .5 there and at .0 here, so half a pixel is taken from the principal point. Poses are not read: they have no scale |

EXIF is read of JPEG, PNG (`eXIf`), WebP and TIFF. FocalLengthIn35mmFilm is an equivalent by the diagonal, whatever the shape
of the picture (CIPA DCG-001): focal length in pixels = diagonal in pixels × equivalent / 43.27 mm. Without it, FocalLength
with FocalPlaneXResolution. A picture of another shape than EXIF's was cut, and nothing is guessed. Pixels are those of the
file as it is stored: an orientation tag turns nothing, which is said (OpenCV itself turns a TIFF). Where a camera is given
and EXIF tells a focal length that is a third longer or shorter, a line warns.

A picture of another size than its camera is an error. Where it has the same shape, the error tells the numbers of the camera
that was scaled with it: nothing is scaled unasked, for a cut for video has the same shape, too."""


def page() -> str:
    """The page."""
    known: set[Any] = set()
    parts = [HEAD, _contents(formats())]
    for name, one in formats().items():
        kinds = " or ".join(map(_link, options_of(one.shape)))
        kinds = f" A document is one {kinds}." if kinds else ""
        parts += [f"## Format {name}", f"{one.title}. {one.used}{kinds}", f"```json\n{_example(name)}```"]
        parts += [_table(table) for table in tables(one.shape) if table not in known]
        parts += [CAMERAS] if name == "camera" else []
        known |= set(tables(one.shape))
    return "\n\n".join(parts) + "\n"


def _example(name: str) -> str:
    return (EXAMPLES / f"{name}.json").read_text(encoding="utf-8")


def _contents(every: dict[str, Format]) -> str:
    rows = [f"| [{name}](#format-{name}) | {one.title} | {one.used} |" for name, one in every.items()]
    return "\n".join(["| name | what it is | who writes it, who reads it |", "|---|---|---|", *rows])


def tables(shape: Any) -> list[Any]:  # noqa: ANN401 - a type
    """Every table of a shape, each once, a table before those in it."""
    return list(dict.fromkeys(_tables(shape, ())))


def _tables(shape: Any, above: tuple[Any, ...]) -> Iterator[Any]:  # noqa: ANN401 - a type
    parts = parts_of(shape)
    inside = options_of(shape) or parts.bound(Row) or ()
    if is_typeddict(parts.of) and parts.of not in above:
        yield parts.of
        inside, above = tuple(parts.of.__annotations__.values()), (*above, parts.of)
    elif not inside:
        inside = get_args(parts.of)
    for each in inside:
        yield from _tables(each, above) if not isinstance(each, str) else ()


def _table(table: Any) -> str:  # noqa: ANN401 - a TypedDict
    keys = table.__annotations__
    rows = [
        f"| `{key}` | {'yes' if key in table.__required_keys__ else 'no'} | {_plain(described(of, _link))} | {parts_of(of).meaning} |"
        for key, of in keys.items()
    ]
    head = [
        f"### {name_of(table)}",
        "",
        summary(table),
        "",
        "| key | needed | what it is | what it means |",
        "|---|---|---|---|",
    ]
    return "\n".join([*head, *rows])


def _link(table: Any) -> str:  # noqa: ANN401 - a TypedDict
    return f"[{name_of(table)}](#{name_of(table).lower()})"


def _plain(text: str) -> str:
    return text.replace("|", "\\|").replace("-1e-06", "0").replace("1.000001", "1")
