"""What a knowledge base holds, for people and for programs, and what in it may be meant otherwise."""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from math import isfinite
from typing import Any

import numpy as np

from geometry.bodies.resting import meant, resting_faces
from geometry.frames import transform_points
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.lobes import Feature, Lobe, Node, Tree, object_nodes
from kb.shown.cautions import cautions, learned_summary
from kb.shown.seen_from import MOST_NAMED
from kb.surfaces.symmetries import symmetry_words

CLOSE = 0.01
"""A symmetry may move the surface's vertices by this share of its diameter."""


def check_report(kb: KnowledgeBase) -> list[str]:
    """A line for each fault (``warning:``) and ambiguity (``note:``), then one about the KB and one about each type."""
    words = f", {_count(len(kb.words.names), 'visual word')}" if kb.words is not None else ""
    own = len(kb.appearance_types) - (len(kb.words.names) if kb.words is not None else 0)
    head = f"{kb.name}: {_count(len(kb.types), 'type')}, {_count(own, 'appearance type')}{words}, no mistakes"
    summaries = (line for kind in kb.types for line in _summary(kind))
    warnings = (f"warning: {caution}" for caution in cautions(kb))
    return [*warnings, *(f"note: {note}" for note in _notes(kb)), head, *summaries]


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"


def _summary(kind: ObjectType) -> Iterator[str]:
    body = f"{len(kind.surface.triangles)} facets, {kind.surface.volume:.4g} m3" if kind.surface else "no surface"
    body += f", {'opaque' if kind.opaque else 'not opaque'}, {symmetry_words(kind.symmetries)}"
    if kind.learned is not None:
        first, second = learned_summary(kind).lines
        yield f"{kind.name}: {first}, {body}"
        yield f"  {second}"
        return
    counts = ", ".join(f"{name} {number}" for name, number in sorted(feature_counts(kind).items()))
    features, lobes = _count(len(kind.all_features), "feature"), _count(len(kind.lobes.types), "lobe")
    yield f"{kind.name}: {features}{f' ({counts})' if counts else ''}, {lobes}, {body}"


def feature_counts(kind: ObjectType) -> dict[str, int]:
    """How many features of each feature type: S of §5.1 counts every Feature node."""
    return dict(Counter(feature.type for feature in kind.all_features))


def _notes(kb: KnowledgeBase) -> Iterator[str]:
    if not kb.types:
        yield "there is no type: nothing can be perceived; make one: plogic kb add NAME --mesh FILE --kb KB"
    seen = {name for kind in kb.types for name in kind.lobes.types} | set(
        kb.words.names if kb.words is not None else ()
    )
    unused = [repr(name) for name in kb.appearance_types if name not in seen]
    if unused and kb.types:
        yield f"no feature looks like {', '.join(unused[:MOST_NAMED])}{_more(len(unused))}"
    for kind in kb.types:
        yield from (f"{kind.name}: {note}" for note in _type_notes(kind))


def _more(number: int) -> str:
    return f" and {number - MOST_NAMED} more" if number > MOST_NAMED else ""


def _type_notes(kind: ObjectType) -> Iterator[str]:
    if kind.surface is None:
        yield "has no mesh, so it hides nothing"
    if len(object_nodes(kind.tree)) > 1 and "" in learned_counts(kind):
        yield "its learned features belong to none of its parts: learn it again"
    for feature in kind.features if kind.learned is None else ():
        if not feature.appearances:
            yield f"{feature.name} has no appearance, so it is never expected"
    yield from _unsteady(kind)
    for index, moved in enumerate(_moved(kind)):
        if moved > CLOSE:
            yield f"symmetry {index} moves the mesh's vertices by up to {moved:.0%} of its size"


def _unsteady(kind: ObjectType) -> Iterator[str]:
    """Stated ways to stand in which the mesh does not rest."""
    if kind.surface is None or not kind.stands:
        return
    faces, down = resting_faces(kind.surface.vertices), np.array([stand.down for stand in kind.stands])
    for index in np.flatnonzero(meant(faces, down) < 0):
        nearest = np.degrees(np.arccos(np.clip((down[index] @ faces.down.T).max(initial=-1.0), -1.0, 1.0)))
        near = f"the nearest face that it can is {nearest:.0f} deg off" if len(faces.down) else "it has no volume"
        yield f"stands.{index}: its mesh cannot stand on {_row(down[index])}: {near}; it is taken as what touches a plane there"


def _moved(kind: ObjectType) -> list[float]:
    """How far each symmetry takes a vertex from the nearest one, as a share of the diameter."""
    if kind.surface is None or len(kind.symmetries) == 1:
        return []
    from scipy.spatial import cKDTree

    places = cKDTree(kind.surface.vertices)
    moved = [places.query(transform_points(motion, kind.surface.vertices))[0].max() for motion in kind.symmetries]
    return [float(distance) / kind.surface.diameter for distance in moved]


def tree_text(kb: KnowledgeBase) -> str:
    """The trees of all types: a line for each object and feature, one for all the appearances of a feature.

    A few lines stand for the features of a learned type: there are too many to list.
    """
    lines: list[str] = []
    for kind in kb.types:
        lines += _tree_lines(kind, "", kind.name, "")
        lines += [f"  {line}" for line in learned_summary(kind).lines] if kind.learned is not None else []
        lines += _stand_lines(kind)
    return "\n".join(lines) + "\n"


MOST_STANDS = 6
"""Ways to stand that are told to people."""


def stand_rows(kind: ObjectType) -> list[dict[str, Any]]:
    """``[{"down": [0, 0, -1], "reach": 0.1, "weight": 0.8}]``: the faces that it stands on, the likeliest first; m."""
    faces = kind.resting
    order = np.argsort(-np.round(faces.weight, 9), kind="stable")
    return [
        {"down": faces.down[k].tolist(), "reach": float(faces.reach[k]), "weight": float(faces.weight[k])}
        for k in order
    ]


def _stand_lines(kind: ObjectType) -> Iterator[str]:
    if kind.surface is None:
        return
    rows = stand_rows(kind)
    shown = [f"{_row(row['down'])} {row['weight']:.3g}" for row in rows[:MOST_STANDS]]
    rest = rows[MOST_STANDS:]
    shown += [f"{len(rest)} more {sum(row['weight'] for row in rest):.3g}"] if rest else []
    said = "as its mesh can" if kind.stands is None else "as object.yaml says"
    yield f"  stands {said}, on {_count(len(rows), 'face')}{': ' if rows else ''}{', '.join(shown)}"


def _tree_lines(kind: ObjectType, node: str, label: str, indent: str) -> Iterator[str]:
    tree, row = kind.tree, kind.tree.nodes[node]
    place = f" at {_row(row.at)}" if node else ""
    sort = "" if row.type == label else f": {row.type}"
    yield f"{indent}{row.kind} {label}{sort}{place}{_looks(tree, node)}{_learned_count(kind, node)}"
    for part in row.below:
        if tree.nodes[part].kind != "appearance":
            yield from _tree_lines(kind, part, part.rsplit("/", 1)[-1], f"{indent}  ")


def _learned_count(kind: ObjectType, node: str) -> str:
    number = learned_counts(kind).get(node, 0)
    return f", {_count(number, 'learned feature')}" if node and number else ""


def learned_counts(kind: ObjectType) -> dict[str, int]:
    """How many learned features each object of a type's tree has for its own, by the objects' paths."""
    if kind.learned is None:
        return {}
    nodes = object_nodes(kind.tree)
    return {nodes[part]: number for part, number in sorted(Counter(kind.learned.part.tolist()).items())}


def _looks(tree: Tree, node: str) -> str:
    below = (tree.nodes[part] for part in tree.nodes[node].below)
    types = Counter(part.type for part in below if part.kind == "appearance")
    looks = ", ".join(name if number == 1 else f"{name} x{number}" for name, number in types.items())
    return f", looks like {looks}" if looks else ""


def _row(values: Iterable[float]) -> str:
    return "[" + ", ".join(f"{value + 0.0:.4g}" for value in values) + "]"


def part_rows(kind: ObjectType) -> list[dict[str, Any]]:
    """The whole and each object that is a part of it: ``{"name": "roof", "under": 0, "counts": {"apex": 1}}``.

    ``under`` is the index of the part above, None for the whole; ``counts`` the Feature nodes of each type, those of
    its own parts left out.
    """
    objects = _objects(kind)
    counts: list[Counter[str]] = [Counter() for _ in objects]
    for part, feature in zip(_parts_of(kind, kind.all_features), kind.all_features, strict=True):
        counts[part][feature.type] += 1
    return [
        {
            "name": node.rsplit("/", 1)[-1] or kind.name,
            "under": None if (above := kind.tree.nodes[node].above) is None else objects[above],
            "counts": dict(sorted(own.items())),
        }
        for node, own in zip(objects, counts, strict=True)
    ]


def part_of_features(kind: ObjectType) -> list[int]:
    """The index in ``part_rows`` of the part that each of ``kind.seen_features`` belongs to."""
    return _parts_of(kind, kind.seen_features)


def _objects(kind: ObjectType) -> dict[str, int]:
    return {node: index for index, node in enumerate(object_nodes(kind.tree))}


def _parts_of(kind: ObjectType, features: Iterable[Feature]) -> list[int]:
    """A learned feature is in no tree: its path names its part, or nothing, the whole."""
    objects = _objects(kind)

    def part(node: str) -> int:
        above = (kind.tree.nodes[node].above or "") if node in kind.tree.nodes else node.rpartition("/")[0]
        return objects[above] if above in objects else part(above)

    return [part(feature.name) for feature in features]


def tree_document(kb: KnowledgeBase) -> dict[str, Any]:
    """The whole KB but its surfaces, as plain data for JSON: ``{"format": "kb/1", "name": ..., "types": [...]}``.

    M and rad.
    """
    rates = kb.rates
    return {
        "format": "kb/1",
        "name": kb.name,
        "digest": kb.digest,
        "f_ref": kb.f_ref,
        "gravity": "maybe" if kb.maybe else kb.gravity,
        "rests": kb.rests,
        **({"unknown_support": kb.unknown_support, "ground": kb.ground} if kb.gravity else {}),
        "appearance_types": list(kb.appearance_types),
        "detector": {
            "hit": rates.hit,
            "clutter": rates.clutter,
            "sigma": rates.sigma,
            "sigmas": rates.sigmas,
            "match_tolerance": rates.match_tolerance,
            "sigma_angle": rates.sigma_angle,
        },
        "priors": rates.prior,
        "types": [_type_document(kind) for kind in kb.types],
    }


def _type_document(kind: ObjectType) -> dict[str, Any]:
    surface, counts = kind.surface, learned_counts(kind)
    nodes = [_node_document(*item) for item in kind.tree.nodes.items()]
    if kind.learned is not None:
        nodes = [row | {"learned_features": counts.get(row["id"], 0)} for row in nodes]
    return {
        "name": kind.name,
        "opaque": kind.opaque,
        "symmetries": np.asarray(kind.symmetries).tolist(),
        "surface": {"facets": len(surface.triangles), "volume": surface.volume} if surface else None,
        "stands": stand_rows(kind),
        "features": feature_counts(kind),
        "learnt": asdict(learned_summary(kind)) if kind.learned is not None else None,
        "nodes": nodes,
    }


def _node_document(name: str, node: Node) -> dict[str, Any]:
    head = {"id": name, "parent": node.above, "kind": node.kind, "type": node.type}
    if node.kind == "appearance":
        return head | {"lobe": _lobe_document(node.viewpoint)}
    arms = {"arms": node.arms.tolist()} if node.kind == "feature" else {}
    return head | {"parent_from_node": node.parent_from_node.tolist()} | arms


def _lobe_document(lobe: Lobe | None) -> dict[str, Any] | None:
    if lobe is None:
        return None
    size = {"size": lobe.size} if isfinite(lobe.size) else {}
    return {"axis": lobe.axis.tolist(), "half_angle": lobe.half_angle, "range": [lobe.r_min, lobe.r_max]} | size
