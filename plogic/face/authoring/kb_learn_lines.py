"""One entry in the YAML that somebody wrote: all else in it, comments included, stays."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

from ruamel.yaml.nodes import MappingNode, SequenceNode

from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path
    from typing import Any

    from ruamel.yaml.nodes import Node


def with_entry(file: Path, content: bytes, key: str, value: Mapping[str, str] | Sequence[Mapping[str, Any]]) -> bytes:
    """The content of a file that was read as a mapping, with ``value`` under ``key``: in the place of what is there, or at the end.

    A list of mappings is written in one line, as a mapping is.

    Raises:
        InputError: it is written in a form that cannot be changed so, such as an anchor or a flow; with what to write
        into it.
    """
    from kb.files.folder import load

    document = load(str(file), content)
    if document.data.get(key) == value:
        return content
    text = content.decode("utf-8-sig")
    entry = _flow(value) if isinstance(value, Mapping) else "[" + ", ".join(_flow(item) for item in value) + "]"
    node = next((item for name, item in getattr(document.root, "value", ()) if name.value == key), None)
    changed = (f"{text.rstrip()}\n{key}: {entry}\n" if node is None else _replaced(text, node, entry)).encode()
    again = load(str(file), changed)
    if again.mistakes or again.data != document.data | {
        key: dict(value) if isinstance(value, Mapping) else [dict(item) for item in value]
    }:
        raise InputError(
            f"{file}: cannot be changed as it is written: write this into it, and try again: {key}: {entry}"
        )
    return changed


def _flow(value: Mapping[str, Any]) -> str:
    return "{" + ", ".join(f"{name}: {json.dumps(item, ensure_ascii=False)}" for name, item in value.items()) + "}"


def _replaced(text: str, node: Node, entry: str) -> str:
    """The text with an entry in the place of a node; the comments that follow it stay."""
    start, end = node.start_mark, _last(node).end_mark
    lines = [*text.splitlines(keepends=True), ""]
    before = "".join(lines[: start.line]) + lines[start.line][: start.column]
    after = "".join([lines[end.line][end.column :], *lines[end.line + 1 :]])
    gap = "" if before.endswith((" ", "\n")) else " "
    return before + gap + entry + ("\n" if end.column == 0 else "") + after


def _last(node: Node) -> Node:
    """The node that a node's text ends with: in block style a parent ends where the next key begins, comments included."""
    while isinstance(node, MappingNode | SequenceNode) and node.value and not node.flow_style:
        node = node.value[-1][1] if isinstance(node, MappingNode) else node.value[-1]
    return node
