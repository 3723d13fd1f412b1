"""The part of docs/formats.md on the files that an author writes: kb.yaml and object.yaml, key by key.

All of it is read from the JSON Schemas of the models that the reader holds them to, and from what
``plogic kb new --example`` writes.
"""
# ruff: noqa: INP001 - a script, no package

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kb.files.schema import json_schema
from kb.intake.example_type import BOX, example_files

if TYPE_CHECKING:
    from collections.abc import Iterator

Schema = dict[str, Any]
SHOWN = 26
"""Lines of the example's object.yaml that are shown: two whole features."""
FILES = {
    "kb.yaml": ("kb", "kb.yaml", "What holds for all types of a knowledge base."),
    "object.yaml": (
        "object",
        f"{BOX}/object.yaml",
        "One object type, in `objects/NAME/`. The example's other features are written as these two are.",
    ),
}


def sections() -> list[str]:
    """A section a file: its example, and a table for each of its models."""
    files = example_files("mine")
    parts: list[str] = []
    for title, (which, path, used) in FILES.items():
        schema = json_schema("kb" if which == "kb" else "object")
        lines = files[path].decode().splitlines()
        text = "\n".join(lines[:SHOWN] if which == "object" else lines)
        parts += [f"## File {title}", f"{used} `plogic kb new FOLDER --example` writes it:", f"```yaml\n{text}\n```"]
        parts += [_table(name, table) for name, table in models(schema)]
    return list(dict.fromkeys(parts))  # a table of both files is told once


def models(schema: Schema) -> Iterator[tuple[str, Schema]]:
    """Every model of a schema with its name, the whole first."""
    yield schema["title"], schema
    inside = schema.get("$defs", {})
    yield from inside.items()
    for key in schema["properties"].values():
        options = (one.get("items", one) for one in key.get("anyOf", ()))
        yield from ((one["title"], one) for one in options if "properties" in one)


def _table(name: str, model: Schema) -> str:
    needed = model.get("required", ())
    rows = [
        f"| `{key}` | {'yes' if key in needed else 'no'} | {kind(of)}{_default(of)} | {_plain(of.get('description', ''))} |"
        for key, of in model["properties"].items()
    ]
    summary = " ".join(model.get("description", "").replace("``", "`").split())
    head = ["| key | needed | what it is | what it means |", "|---|---|---|---|"]
    return "\n".join([f"### {name}", "", summary, "", *head, *rows])


def kind(of: Schema) -> str:
    """What a value is, in words, with links to tables."""
    if "$ref" in of or "properties" in of:
        name = of["$ref"].rsplit("/", 1)[-1] if "$ref" in of else of["title"]
        return f"[{name}](#{name.lower()})"
    if "anyOf" in of:
        return _one_of(of)
    if "enum" in of:
        return ", ".join(f"`{value}`" for value in of["enum"])
    if of.get("type") == "array":
        least, most = of.get("minItems"), of.get("maxItems")
        return f"a list{f' of {least}' if least is not None and least == most else ''}: {kind(of['items'])}"
    if of.get("type") == "object":
        (value,) = of["patternProperties"].values()
        return f"a table by name: {kind(value)}"
    return _simple(of)


def _one_of(of: Schema) -> str:
    """Of several kinds; null, which is to leave the key out, is none."""
    options = [one for one in of["anyOf"] if one.get("type") != "null"]
    examples = [text for one in options for text in one.get("examples", ())]
    if examples:
        return f"a number, or a text with its unit such as `{examples[0]}`"
    return " or ".join(kind(one) for one in options)


def _simple(of: Schema) -> str:
    names = {"string": "a text", "boolean": "true or false", "integer": "a whole number", "number": "a number"}
    types = of["type"] if isinstance(of["type"], list) else [of["type"]]
    text = " or ".join(names[each] for each in types)
    bounds = [("exclusiveMinimum", "above"), ("minimum", "from"), ("exclusiveMaximum", "below"), ("maximum", "to")]
    return text + "".join(f", {word} {of[key]:.10g}" for key, word in bounds if key in of)


def _default(of: Schema) -> str:
    """What holds where the key is left out, if that is a number or a flag."""
    value = of.get("default")
    if isinstance(value, bool):
        return f"; `{str(value).lower()}`"
    return f"; `{value:g}`" if isinstance(value, float | int) else ""


def _plain(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
