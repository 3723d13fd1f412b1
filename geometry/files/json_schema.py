"""JSON Schemas, draft 2020-12, of the shapes that documents are held to (``geometry.json_shapes``).

A schema and our own check come to the same verdict, with two exceptions that JSON Schema cannot tell: a whole number
must be written without a point, and no number may be too large for a 64-bit float.
"""

import inspect
from types import NoneType
from typing import Any, Literal, get_args, get_origin, is_typeddict

from geometry.json_shapes import (
    ANY_SIZE,
    LARGEST,
    Lengths,
    Parts,
    Range,
    Row,
    Size,
    options_of,
    parts_of,
    span_of,
)

Schema = dict[str, Any]
SIMPLE = {str: "string", bool: "boolean", NoneType: "null"}
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema_of(shape: Any, title: str) -> Schema:  # noqa: ANN401 - a type
    """The JSON Schema of a document's shape: each table once, under ``$defs``."""
    tables: dict[str, Schema] = {}
    whole = _schema(shape, tables)
    return {"$schema": DIALECT, "title": title, **whole, "$defs": dict(sorted(tables.items()))}


def summary(table: Any) -> str:  # noqa: ANN401 - a TypedDict
    """What a table is, from its docstring."""
    return " ".join((inspect.getdoc(table) or "").split())


def name_of(table: Any) -> str:  # noqa: ANN401 - a TypedDict
    """What a table is called."""
    return str(table.__name__).removesuffix("Row")


def _schema(shape: Any, tables: dict[str, Schema]) -> Schema:  # noqa: ANN401 - a type
    parts = parts_of(shape)
    said = {"description": parts.meaning} if parts.meaning else {}
    if options := options_of(shape):
        return {"anyOf": [_schema(option, tables) for option in options], **said}
    if is_typeddict(parts.of):
        return {"$ref": f"#/$defs/{_name_of(parts.of, tables)}", **said}
    return _plain(parts, tables) | said


def _name_of(table: Any, tables: dict[str, Schema]) -> str:  # noqa: ANN401 - a TypedDict
    """The name of a table, which is now among ``tables``."""
    name = name_of(table)
    if name not in tables:
        tables[name] = {}  # it may hold itself
        keys = table.__annotations__
        tables[name] = {
            "type": "object",
            "description": summary(table),
            "properties": {key: _schema(of, tables) for key, of in keys.items()},
            "required": [key for key in keys if key in table.__required_keys__],
            "additionalProperties": False,
        }
    return name


def _plain(parts: Parts, tables: dict[str, Schema]) -> Schema:
    of, args = parts.of, get_args(parts.of)
    row, size = parts.bound(Row), parts.bound((Size, Lengths), ANY_SIZE)
    if row is not None:
        inner = [_schema(each, tables) for each in row]
        return {"type": "array", "prefixItems": inner, **_ends("Items", Size(len(row)))}
    if get_origin(of) is list:
        return {"type": "array", "items": _schema(args[0], tables), **_ends("Items", size)}
    if get_origin(of) is dict:
        return {"type": "object", "additionalProperties": _schema(args[1], tables), **_ends("Properties", size)}
    if get_origin(of) is Literal:
        return {"const": args[0]} if len(args) == 1 else {"enum": list(args)}
    if of is float or of is int:
        return _number(span_of(parts), "integer" if of is int else "number")
    return {"type": SIMPLE[of], **(_ends("Length", size) if of is str else {})}


def _ends(what: str, size: Size | Lengths) -> Schema:
    """The bounds of a length, where they say something."""
    if isinstance(size, Lengths):
        return {"anyOf": [_ends(what, Size(length)) for length in size]}
    least, most = size.ends()
    low = {f"min{what}": least} if least else {}
    return low | ({f"max{what}": most} if most < ANY_SIZE.ends()[1] else {})


def _number(span: Range, kind: str) -> Schema:
    low = {"exclusiveMinimum" if span.open_low else "minimum": span.low} if span.low > -LARGEST else {}
    return {"type": kind, **low, **({"maximum": span.high} if span.high < LARGEST else {})}
