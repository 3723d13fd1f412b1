"""A knowledge base back to its folder; the same objects give the same bytes.

Making the text and writing it are two functions.
"""

import io
import json
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from geometry.frames import quat_xyzw_from_rotation
from kb.clouds.cloud import ObjectType, Rates
from kb.clouds.lobes import Lobe, Tree
from kb.surfaces.surface import Surface
from kb.surfaces.symmetries import symmetry_entries

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
_RESERVED = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}
_UNPRINTED = re.compile(r"[\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff\ufffe\uffff]")
"""What YAML takes for a break, or does not allow as it is."""
_KEYS = {"object": "parts", "feature": "features", "appearance": "appearances"}


def object_text(kind: ObjectType, mesh: str | None = None, units: str = "m") -> str:
    """``object.yaml`` of a type whose mesh is the file ``mesh`` in ``units``."""
    lines = [f"object: {flow(kind.name)}"]
    lines += [f"mesh: {{file: {flow(mesh)}, units: {units}}}"] if mesh else []
    lines += [f"opaque: {flow(kind.opaque)}", f"symmetries: {flow(symmetry_entries(kind.symmetries))}"]
    if kind.stands is not None:
        rows = [{"down": stand.down, "weight": stand.weight} for stand in kind.stands]
        lines.append(f"stands: {flow(rows or 'never')}")
    return "\n".join([*lines, *_list_lines(kind.tree, "", "")]) + "\n"


def obj_text(surface: Surface) -> str:
    """A surface as Wavefront OBJ, in metres, every digit kept."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in surface.vertices.tolist()]
    return "\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in surface.triangles.tolist()]) + "\n"


def _list_lines(tree: Tree, node: str, indent: str) -> Iterator[str]:
    """The list of what ``node`` holds; A1 makes it one list."""
    children = tree.nodes[node].below
    if children:
        yield f"{indent}{_KEYS[tree.nodes[children[0]].kind]}:"
    for child in children:
        first, *rest = _node_lines(tree, child)
        yield f"{indent}  - {first}"
        yield from (f"{indent}    {line}" for line in rest)


def _node_lines(tree: Tree, node: str) -> Iterator[str]:
    row = tree.nodes[node]
    if row.kind == "appearance":
        yield from _appearance_lines(tree, node)
        return
    name = node.rsplit("/", 1)[-1]
    yield f"{'part' if row.kind == 'object' else 'feature'}: {flow(name)}"
    if row.kind == "feature" or row.type != name:
        yield f"type: {flow(row.type)}"
    yield f"at: {flow(row.at)}"
    yield from _rotation_lines(row.parent_from_node)
    if len(row.arms):
        yield f"arms: {flow(row.arms)}"
    yield from _list_lines(tree, node, "")


def _rotation_lines(frame: NDArray[np.float64]) -> Iterator[str]:
    if not np.array_equal(frame[:3, :3], np.eye(3)):
        yield f"rotation: {{quat_xyzw: {flow(quat_xyzw_from_rotation(frame[:3, :3]))}}}"


def _appearance_lines(tree: Tree, node: str) -> Iterator[str]:
    row = tree.nodes[node]
    lines = [f"type: {flow(row.type)}"]
    if row.viewpoint is not None:
        if math.isfinite(row.viewpoint.size):
            lines.append(f"size: {_number(row.viewpoint.size)} m")
        lines.append(f"lobe: {_lobe(row.viewpoint)}")
    if not row.below:
        yield f"{{{', '.join(lines)}}}"
        return
    yield from lines
    yield from _list_lines(tree, node, "")


def _lobe(lobe: Lobe) -> str:
    reach = f"[{_number(lobe.r_min)} m, {_number(lobe.r_max)} m]"
    return f"{{axis: {flow(lobe.axis)}, half_angle: {_number(math.degrees(lobe.half_angle))} deg, range: {reach}}}"


def flow(value: object) -> str:
    """A value in YAML's flow style; a text that YAML might read as something else is quoted."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        plain = _PLAIN.fullmatch(value) and value.lower() not in _RESERVED
        return (
            value
            if plain
            else _UNPRINTED.sub(lambda sign: f"\\u{ord(sign[0]):04x}", json.dumps(value, ensure_ascii=False))
        )
    if isinstance(value, dict):
        return "{" + ", ".join(f"{flow(key)}: {flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(flow(item) for item in value) + "]"
    return _number(float(value))  # type: ignore[arg-type]  # a number is what is left


def _number(value: float) -> str:
    """15 significant digits: what was written by hand comes back as it was."""
    return f"{float(value) + 0.0:.15g}"


DIGITS = 4
"""Significant digits of a learned rate: a thousand scenes do not tell more."""


def with_rates(text: str, rates: Rates) -> str:
    """The text with the hit rates, clutter and priors that have counts, and with the counts.

    ``text`` must be a KB's that was read.
    """
    yaml = YAML(typ="rt")
    yaml.width = 4096
    yaml.preserve_quotes = True
    document = yaml.load(text)
    counts = rates.counts
    detector = _inner(document, "detector")
    _put(_inner(detector, "hit"), {name: rates.hit[name] for name in counts.hit})
    _put(_inner(detector, "clutter"), {name: rates.clutter[name] for name in counts.clutter})
    _put(_inner(document, "priors"), {name: rates.prior[name] for name in counts.prior})
    table = _inner(document, "counts")
    for key in ("hit", "clutter", "prior"):
        _put(_inner(table, key), {name: _pair(pair) for name, pair in getattr(counts, key).items()})
    buffer = io.StringIO()
    yaml.dump(document, buffer)
    return buffer.getvalue()


def rounded(value: float) -> float:
    """To ``DIGITS`` significant digits."""
    return float(f"{value:.{DIGITS}g}")


def _inner(document: Any, key: str) -> Any:  # noqa: ANN401 - ruamel's own mapping
    """The mapping under a key; a new one where there is none."""
    if document.get(key) is None:
        document[key] = CommentedMap()
    return document[key]


def _put(table: Any, values: Mapping[str, Any]) -> None:  # noqa: ANN401 - ruamel's own mapping
    if not len(table):
        table.fa.set_flow_style()
    for name, value in values.items():
        table[name] = rounded(value) if isinstance(value, float) else value


def _pair(pair: tuple[float, float]) -> Any:  # noqa: ANN401 - ruamel's own list
    numbers = CommentedSeq([int(n) if n == int(n) else round(n, 2) for n in pair])
    numbers.fa.set_flow_style()
    return numbers
