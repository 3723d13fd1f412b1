"""The text of docs/formats.md: every format with an example, and every key with what it is and means.

All of it is read from the shapes that the readers hold documents to, and from the files in examples/formats;
of kb.yaml and object.yaml: ``kb_page``.
"""
# ruff: noqa: INP001 - a script, no package

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args, is_typeddict

from kb_page import sections

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
([conventions](conventions.md)). The files of a knowledge base are YAML: [kb.yaml](#file-kbyaml),
[object.yaml](#file-objectyaml), `plogic kb schema`, and how to write them: [knowledge bases](knowledge-bases.md).

`plogic schema NAME` prints a format as JSON Schema (draft 2020-12), made of the same shapes. Every key that a table below
does not name is a mistake. Whole numbers are written without a point. What is wrong is told with line and column, all of
it at once:

```text
gamma.json:4:41: appearances.0.uv: a list of 1, and not of 2
```

What no schema says, and the readers check too: a pose is rigid, ids are told once, `uv` lies in the image, an appearance's
type is one of the KB's, `depth` and `depth_sigma` come together, a hypothesis or an appearance that is named is there, and
a move has one of its two poses."""


def page() -> str:
    """The page."""
    known: set[Any] = set()
    parts = [HEAD, _contents(formats())]
    for name, one in formats().items():
        kinds = " or ".join(map(_link, options_of(one.shape)))
        kinds = f" A document is one {kinds}." if kinds else ""
        parts += [f"## Format {name}", f"{one.title}. {one.used}{kinds}", f"```json\n{_example(name)}```"]
        parts += [_table(table) for table in tables(one.shape) if table not in known]
        known |= set(tables(one.shape))
    return "\n\n".join([*parts, *sections()]) + "\n"


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
