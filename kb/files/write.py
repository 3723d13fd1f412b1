"""A knowledge base back to its folder; the same objects give the same bytes. Making the text and writing it are two functions."""

from __future__ import annotations

import json
import math
import os
import re
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import quat_xyzw_from_rotation
from kb.clouds.cloud import UNKNOWN_SUPPORT
from kb.errors import KBError
from kb.surfaces.symmetries import symmetry_entries

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    import networkx as nx
    from numpy.typing import NDArray

    from kb.clouds.cloud import Counts, KnowledgeBase, Lobe, ObjectType
    from kb.surfaces.surface import Surface

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
_RESERVED = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}
_UNPRINTED = re.compile(r"[\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff\ufffe\uffff]")
"""What YAML takes for a break, or does not allow as it is."""
_SAFE_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_. -]*")
_KEYS = {"object": "parts", "feature": "features", "appearance": "appearances"}


def kb_text(kb: KnowledgeBase) -> str:
    """``kb.yaml``."""
    rates = kb.rates
    rows = {
        "name": kb.name,
        "appearance_types": list(kb.appearance_types),
        "f_ref": kb.f_ref,
    } | ({"gravity": _gravity(kb)} if kb.gravity else {})
    lines = [f"{key}: {flow(value)}" for key, value in rows.items()]
    lines += ["detector:", f"  hit: {flow(rates.hit)}", f"  clutter: {flow(rates.clutter)}"]
    lines += [
        f"  sigma: {flow(rates.sigma)}",
        f"  sigmas: {flow(rates.sigmas)}",
        f"  match_tolerance: {flow(rates.match_tolerance)}",
    ]
    lines += [] if rates.sigma_angle is None else [f"  sigma_angle: {flow(rates.sigma_angle)}"]
    lines += [f"priors: {flow(rates.prior)}", *_counts_lines(rates.counts)]
    return "\n".join(lines) + "\n"


def _gravity(kb: KnowledgeBase) -> bool | dict[str, float]:
    if kb.unknown_support == UNKNOWN_SUPPORT and kb.ground is None:
        return True
    return {"unknown_support": kb.unknown_support} | ({} if kb.ground is None else {"ground": kb.ground})


def _counts_lines(counts: Counts) -> Iterator[str]:
    if counts:
        yield "counts:"
        for name in ("hit", "clutter", "prior"):
            yield f"  {name}: {flow({key: list(pair) for key, pair in getattr(counts, name).items()})}"


def object_text(kind: ObjectType, mesh: str | None = None, units: str = "m") -> str:
    """``object.yaml`` of a type whose mesh is the file ``mesh`` in ``units``."""
    lines = [f"object: {flow(kind.name)}"]
    lines += [f"mesh: {{file: {flow(mesh)}, units: {units}}}"] if mesh else []
    lines += [f"opaque: {flow(kind.opaque)}", f"symmetries: {flow(symmetry_entries(kind.symmetries))}"]
    return "\n".join([*lines, *_list_lines(kind.tree, "", "")]) + "\n"


def obj_text(surface: Surface) -> str:
    """A surface as Wavefront OBJ, in metres, every digit kept."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in surface.vertices.tolist()]
    return "\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in surface.triangles.tolist()]) + "\n"


def kb_files(kb: KnowledgeBase) -> dict[str, str]:
    """Every file of the folder, by relative path. Surfaces are written as ``mesh.obj`` in metres; textures do not travel.

    Raises:
        KBError: for a type whose name cannot be a folder's; for learned types and their words, which only a copy of the
        folder keeps.
    """
    learned = [kind.name for kind in kb.types if kind.learned is not None]
    if learned or kb.words is not None:
        raise KBError(
            f"{kb.name}: what was learned ({', '.join(learned) or 'words'}) cannot be written anew: copy the knowledge base's folder"
        )
    files = {"kb.yaml": kb_text(kb)} | ({"rules.pl": kb.rules} if kb.rules else {})
    for kind in kb.types:
        if not _SAFE_NAME.fullmatch(kind.name):
            raise KBError(f"the type {kind.name!r} cannot be written: its name cannot be a folder's")
        folder = f"objects/{kind.name}"
        files[f"{folder}/object.yaml"] = object_text(kind, "mesh.obj" if kind.surface else None)
        if kind.surface:
            files[f"{folder}/mesh.obj"] = obj_text(kind.surface)
    return files


def write_kb(kb: KnowledgeBase, folder: Path) -> None:
    """Write every file of ``kb_files``, each whole or not at all, over those that are there.

    Raises:
        KBError: as ``kb_files`` does; nothing is written then.
    """
    for name, text in kb_files(kb).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        rough = path.with_name(f".{path.name}.part")
        rough.write_text(text, encoding="utf-8")
        os.replace(rough, path)  # noqa: PTH105 - the rename is what makes it whole


def _list_lines(tree: nx.DiGraph, node: str, indent: str) -> Iterator[str]:
    """The list of what ``node`` holds; A1 makes it one list."""
    children = list(tree.successors(node))
    if children:
        yield f"{indent}{_KEYS[tree.nodes[children[0]]['kind']]}:"
    for child in children:
        first, *rest = _node_lines(tree, node, child)
        yield f"{indent}  - {first}"
        yield from (f"{indent}    {line}" for line in rest)


def _node_lines(tree: nx.DiGraph, parent: str, node: str) -> Iterator[str]:
    row = tree.nodes[node]
    if row["kind"] == "appearance":
        yield from _appearance_lines(tree, node)
        return
    name = node.rsplit("/", 1)[-1]
    yield f"{'part' if row['kind'] == 'object' else 'feature'}: {flow(name)}"
    if row["kind"] == "feature" or row["type"] != name:
        yield f"type: {flow(row['type'])}"
    yield f"at: {flow(row['at'])}"
    yield from _rotation_lines(tree.edges[parent, node]["parent_from_child"])
    if len(row["arms"]):
        yield f"arms: {flow(row['arms'])}"
    yield from _list_lines(tree, node, "")


def _rotation_lines(frame: NDArray[np.float64]) -> Iterator[str]:
    if not np.array_equal(frame[:3, :3], np.eye(3)):
        yield f"rotation: {{quat_xyzw: {flow(quat_xyzw_from_rotation(frame[:3, :3]))}}}"


def _appearance_lines(tree: nx.DiGraph, node: str) -> Iterator[str]:
    row = tree.nodes[node]
    lines = [f"type: {flow(row['type'])}"]
    if row["viewpoint"] is not None:
        if math.isfinite(row["viewpoint"].size):
            lines.append(f"size: {_number(row['viewpoint'].size)} m")
        lines.append(f"lobe: {_lobe(row['viewpoint'])}")
    if not tree.out_degree(node):
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
