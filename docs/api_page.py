"""The text of docs/api.md, from the signatures and the docstrings of what ``from plogic import ...`` gives."""
# ruff: noqa: INP001 - a script, no package

from __future__ import annotations

import inspect
from dataclasses import fields, is_dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import plogic

if TYPE_CHECKING:
    from collections.abc import Iterator

HEAD = """# From Python

Written by `python docs/generate.py` from the code. Do not edit. `examples/quickstart.ipynb` shows it at work, and
`examples/test_measures.py` how measures are compared in a test.

`import plogic` alone takes no time: names load when they are used. Arrays are numpy's; images are (H, W, 3) `uint8`, blue first.
Whatever is a table iterates over rows with named fields, compares equal by value, has `to_pandas()`, and shows itself in a notebook.
Bad input raises a subclass of `plogic.Error` with the command's own message; nothing prints, and nothing exits.
"""


def api() -> str:
    """The text of docs/api.md."""
    things = [(name, getattr(plogic, name)) for name in plogic.__all__]
    functions = [_function(name, thing) for name, thing in things if inspect.isfunction(thing)]
    classes = [_class(name, thing) for name, thing in things if inspect.isclass(thing)]
    return "\n\n".join([HEAD.rstrip(), "## Functions", *functions, "## Classes", *classes]) + "\n"


def _function(name: str, function: object) -> str:
    return f"### `{name}{_signature(function)}`\n\n{_text(function)}"


def _class(name: str, kind: type) -> str:
    row = is_dataclass(kind)
    named = ", ".join(field.name for field in fields(kind)) if row else ""
    head = f"### `{name}`\n\n{_text(kind)}" + (f"\n\nFields: {named}." if row else "")
    return "\n\n".join([head, *_members(kind)])


def _members(kind: type) -> Iterator[str]:
    """A line each method and property of one's own, and of bases of ours."""
    lines = [
        f"* `{_call(kind, name)}`: {_first(member)}"
        for name, member in inspect.getmembers(kind)
        if not name.startswith("_") and _is_ours(kind, name) and _first(member)
    ]
    if lines:
        yield "\n".join(lines)


def _is_ours(kind: type, name: str) -> bool:
    """Whether a method or a property is of one of our classes; the value of a field is none."""
    owner = next((base for base in kind.__mro__ if name in vars(base)), object)
    member = inspect.getattr_static(kind, name)
    if not (inspect.isfunction(member) or isinstance(member, (property, cached_property, classmethod))):
        return False
    return owner.__module__.split(".")[0] in ("plogic", "geometry", "sensing")


def _call(kind: type, name: str) -> str:
    member = inspect.getattr_static(kind, name)
    if isinstance(member, (classmethod, staticmethod)) or inspect.isfunction(member):
        return f"{name}{_signature(getattr(kind, name))}"
    return name


def _signature(function: object) -> str:
    parameters = [p for p in inspect.signature(function).parameters.values() if p.name != "self"]  # type: ignore[arg-type]
    kept = [p.replace(annotation=inspect.Parameter.empty) for p in parameters]
    return str(inspect.Signature(kept))


def _first(member: object) -> str:
    """The first sentence or two of a docstring: its first paragraph, on one line."""
    return " ".join(_text(member).partition("\n\n")[0].split())


def _text(thing: object) -> str:
    member = thing.func if hasattr(thing, "func") else thing
    text = inspect.getdoc(member) or ""
    head, *sections = text.split("\n\n")
    return "\n\n".join([head, *(_section(s) for s in sections)])


def _section(text: str) -> str:
    """A section such as ``Args:`` as a list."""
    title, *lines = text.splitlines()
    if not title.endswith(":") or " " in title:
        return text
    items: list[str] = []
    for line in lines:
        if line.startswith("     "):
            items[-1] += f" {line.strip()}"
        else:
            items.append(f"* {line.strip()}")
    return f"{title}\n\n" + "\n".join(items)
