"""Features, the lobes that they are seen from, and the tree of an object type.

A lobe is from where a detector can see a feature's appearance (§2.7); it bounds a pencil of vectors. The tree is
Φ(x, v, Type, parts) (§2.1-§2.4); ``Tree.graph`` is the same as a ``networkx.DiGraph``.

Vocabulary: ``LobeTable``, all L lobes of one type as arrays in the object's frame; ``Branch``, a nested description:
``Branch("object", "t2", "t2", parts=[Branch("object", "roof", "roof")])``. In the tree a node's name is its path:
``''`` the maximal object, ``'roof'``, ``'roof/apex'``, ``'roof/apex#0'`` an appearance.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from geometry.arrays import frozen
from geometry.frames import compose, from_rotation_translation, is_rigid
from kb.errors import TreeError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import networkx as nx
    from numpy.typing import ArrayLike, NDArray

GRAIN = 1e-9
"""Slack of the cone's and the range's bounds, so that a viewpoint on a bound is inside."""


def freeze(holder: object, **shapes: tuple[int, ...]) -> None:
    """Turn the named fields into read-only float arrays of the given shapes."""
    for name, shape in shapes.items():
        object.__setattr__(holder, name, frozen(getattr(holder, name)).reshape(shape))


@dataclass(frozen=True, eq=False)
class Lobe:
    """What the detector can see of an appearance (§2.7).

    Unit ``axis`` (3,) in the feature's frame, ``half_angle`` rad, range in m.

    ``size``: how wide it is that the detector reports, m, by which a datum's ``scale`` tells the distance; NaN where
    nobody said.
    """

    axis: NDArray[np.float64]
    half_angle: float
    r_min: float
    r_max: float
    size: float = float("nan")

    def __post_init__(self) -> None:
        freeze(self, axis=(3,))


@dataclass(frozen=True, eq=False)
class FeatureAppearance:
    """One appearance of a feature: what detectors report, and its viewpoints (the second slot of Φ, §2.1)."""

    type: str
    lobe: Lobe


@dataclass(frozen=True, eq=False)
class Feature:
    """One feature.

    ``at`` (3,) m and ``rotation`` (3, 3) = object_from_feature, object frame; ``name`` is its path in the tree.

    ``arms`` (K, 3): unit directions, object frame, of the surface's edges that meet here. ``parts`` names the features
    of a compound.
    """

    name: str
    type: str
    at: NDArray[np.float64]
    rotation: NDArray[np.float64]
    appearances: tuple[FeatureAppearance, ...]
    arms: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    parts: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, at=(3,), rotation=(3, 3), arms=(-1, 3))


@dataclass(frozen=True, eq=False)
class LobeTable:
    """``feature`` (L,) index of the feature; ``types`` (L,) appearance types.

    ``at`` (L, 3) m and unit ``axis`` (L, 3), object frame;
    ``cos_half`` (L,); ``r_min``, ``r_max`` (L,) m at the reference focal length; ``features``, their number F; ``size``
    (L,) m, NaN where unknown.
    """

    feature: NDArray[np.intp]
    types: tuple[str, ...]
    at: NDArray[np.float64]
    axis: NDArray[np.float64]
    cos_half: NDArray[np.float64]
    r_min: NDArray[np.float64]
    r_max: NDArray[np.float64]
    features: int
    size: NDArray[np.float64]


def lobe_table(features: Sequence[Feature]) -> LobeTable:
    """Collect the lobes of all appearances of ``features``."""
    rows = [(f, feature, appearance) for f, feature in enumerate(features) for appearance in feature.appearances]
    lobes = [appearance.lobe for _, _, appearance in rows]
    axis = [feature.rotation @ appearance.lobe.axis for _, feature, appearance in rows]
    return LobeTable(
        feature=frozen([f for f, _, _ in rows]).astype(np.intp),
        types=tuple(appearance.type for _, _, appearance in rows),
        at=frozen([feature.at for _, feature, _ in rows]).reshape(-1, 3),
        axis=frozen(axis).reshape(-1, 3),
        cos_half=frozen([np.cos(lobe.half_angle) for lobe in lobes]),
        r_min=frozen([lobe.r_min for lobe in lobes]),
        r_max=frozen([lobe.r_max for lobe in lobes]),
        features=len(features),
        size=frozen([lobe.size for lobe in lobes]),
    )


def in_lobe(table: LobeTable, viewpoints: ArrayLike, granularity: float | None = None) -> NDArray[np.bool_]:
    """(V, L): r_min ≤ |v−p| ≤ r_max and angle(v−p, axis) ≤ half-angle (§2.7).

    ``viewpoints`` (V, 3) m, object frame. ``granularity`` = f / f_ref scales the ranges: a longer lens sees as much
    from farther; None asks for the direction alone. A viewpoint at the feature itself is in no lobe.
    """
    view = np.asarray(viewpoints, dtype=float).reshape(-1, 1, 3) - table.at[None]
    distance = np.linalg.norm(view, axis=2)
    along = np.einsum("vli,li->vl", view, table.axis)
    inside = (along >= table.cos_half * distance - GRAIN) & (distance > GRAIN)
    if granularity is not None:
        inside &= (distance >= table.r_min * granularity - GRAIN) & (distance <= table.r_max * granularity + GRAIN)
    return np.asarray(inside)


def feature_in_lobe(table: LobeTable, viewpoints: ArrayLike, granularity: float | None = None) -> NDArray[np.bool_]:
    """(V, F): v is in one of the feature's lobes."""
    held = in_lobe(table, viewpoints, granularity)
    result = np.zeros((len(held), table.features), dtype=bool)
    for lobe, feature in enumerate(table.feature):
        result[:, feature] |= held[:, lobe]
    return result


Kind = Literal["object", "feature", "appearance"]

Mistaken = tuple[tuple[int, ...], str]

MAY_HOLD: dict[Kind, tuple[Kind, ...]] = {
    "object": ("object", "feature"),
    "feature": ("feature", "appearance"),
    "appearance": ("appearance",),
}
"""A1: what a node's list may hold, all of it of one kind."""


@dataclass(frozen=True, eq=False)
class Branch:
    """One node and what hangs below it. ``at`` (3,) m and ``rotation`` (3, 3) are parent_from_child.

    ``arms`` (K, 3), in the node's frame, are for features alone; ``lobe``, in its feature's, for appearances:
    viewpoints.
    """

    kind: Kind
    name: str
    type: str
    at: ArrayLike = (0.0, 0.0, 0.0)
    rotation: ArrayLike = field(default_factory=lambda: np.eye(3))
    parts: Sequence[Branch] = ()
    lobe: Lobe | None = None
    arms: ArrayLike = ()


NODES: dict[Kind, str] = {"object": "part", "feature": "feature", "appearance": "appearance"}
"""What an author calls a node below the root, by its kind."""


def tree_mistakes(root: Branch) -> list[Mistaken]:
    """Every break of A1, A2, D3 and of the names' rules, as (indices into ``parts`` from the root, message)."""
    found: list[Mistaken] = (
        [] if root.kind == "object" else [((), f"D3: the maximal object must be an object, not a {root.kind}")]
    )
    return found + list(_mistakes(root, (), ()))


def _mistakes(branch: Branch, where: tuple[int, ...], above: tuple[Branch, ...]) -> Iterator[Mistaken]:
    if any(branch is other for other in above):
        yield where, f"A2: {branch.name!r} is a part of itself"
        return
    for message in _own_mistakes(branch):
        yield where, message
    first: dict[str, int] = {}
    for index, part in enumerate(branch.parts):
        if first.setdefault(part.name, index) != index and part.kind != "appearance":
            yield (*where, index), f"{part.name!r} is the name of another {NODES[part.kind]} of {branch.name!r}"
    for index, part in enumerate(branch.parts):
        yield from _mistakes(part, (*where, index), (*above, branch))


def _own_mistakes(branch: Branch) -> Iterator[str]:
    kinds = sorted({part.kind for part in branch.parts})
    if len(kinds) > 1:
        yield f"A1: the parts of {branch.name!r} must be all of one kind, not {' and '.join(kinds)}"
    for kind in kinds:
        if kind not in MAY_HOLD[branch.kind]:
            yield f"A1: {branch.kind} {branch.name!r} may hold {' or '.join(MAY_HOLD[branch.kind])}, not {kind}"
    if branch.kind != "appearance" and (not branch.name or set(branch.name) & set("/#")):
        yield f"the name of {branch.kind} {branch.name!r} must be neither empty nor hold '/' or '#'"
    if not branch.type:
        yield f"D1: {branch.kind} {branch.name!r} must have a type"
    at, rotation = np.asarray(branch.at, dtype=float), np.asarray(branch.rotation, dtype=float)
    if at.shape != (3,) or rotation.shape != (3, 3) or not is_rigid(from_rotation_translation(rotation, at)):
        yield f"A2: {branch.name!r} must stand at 3 finite coordinates, turned by a rotation"


@dataclass(frozen=True, eq=False)
class Node:
    """One node of a tree.

    ``at`` (3,) m relative to the parent; ``viewpoint``: Φ's second slot for appearances; ``arms`` (K, 3). ``above``:
    its parent, None of the maximal object; ``parent_from_node`` (4, 4); ``below``: its children, in order.
    """

    kind: Kind
    type: str
    at: NDArray[np.float64]
    viewpoint: Lobe | None
    arms: NDArray[np.float64]
    above: str | None
    parent_from_node: NDArray[np.float64]
    below: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Tree:
    """Φ of one type: its nodes by their names, each after its parent, in the description's order."""

    nodes: dict[str, Node]

    @cached_property
    def graph(self) -> nx.DiGraph:
        """The tree for who asks more of it, made when it is first asked for: networkx is long to import.

        Nodes carry ``kind``, ``type``, ``at``, ``viewpoint`` and ``arms``; an edge carries ``parent_from_child``.
        """
        import networkx as nx

        graph = nx.DiGraph()
        for name, node in self.nodes.items():
            row = {"kind": node.kind, "type": node.type, "at": node.at, "viewpoint": node.viewpoint, "arms": node.arms}
            graph.add_node(name, **row)
            if node.above is not None:
                graph.add_edge(node.above, name, parent_from_child=node.parent_from_node)
        return graph


def build_tree(root: Branch) -> Tree:
    """The tree that ``root`` describes.

    Raises:
        TreeError: for the first of ``tree_mistakes``.
    """
    mistakes = tree_mistakes(root)
    if mistakes:
        raise TreeError(mistakes[0][1])
    return Tree(dict(_grown(root, "", None)))


def _grown(branch: Branch, name: str, above: str | None) -> Iterator[tuple[str, Node]]:
    """A node and all below it, by their names."""
    at, arms = np.array(branch.at, dtype=float), np.array(branch.arms, dtype=float).reshape(-1, 3)
    frame = from_rotation_translation(branch.rotation, branch.at)
    children = [
        f"{name}#{index}" if part.kind == "appearance" else f"{name}/{part.name}".lstrip("/")
        for index, part in enumerate(branch.parts)
    ]
    yield name, Node(branch.kind, branch.type, at, branch.lobe, arms, above, frame, tuple(children))
    for child, part in zip(children, branch.parts, strict=True):
        yield from _grown(part, child, name)


def object_nodes(tree: Tree) -> list[str]:
    """The maximal object and its parts that are objects, in the description's order."""
    return [name for name, node in tree.nodes.items() if node.kind == "object"]


def place(tree: Tree, node: str) -> NDArray[np.float64]:
    """object_from_node (4, 4): steps add along the path from the maximal object, with the frames' rotations (A2).

    Raises:
        TreeError: for a node that the tree does not have.
    """
    if node not in tree.nodes:
        raise TreeError(f"{node!r} is no node of the tree")
    steps = []
    while (above := tree.nodes[node].above) is not None:
        steps.append(tree.nodes[node].parent_from_node)
        node = above
    return np.asarray(compose(*reversed(steps)))


def features_of(tree: Tree) -> tuple[tuple[Feature, ...], tuple[Feature, ...]]:
    """The maximal features, and every Feature node, in the description's order (A1).

    A compound has no appearances of its own: it looks like any of its parts, so it takes over their appearances, each
    lobe turned into its frame and based at its place.
    """
    features = {name: _feature(tree, name) for name, node in tree.nodes.items() if node.kind == "feature"}
    inner = {part for feature in features.values() for part in feature.parts}
    return tuple(f for node, f in features.items() if node not in inner), tuple(features.values())


def _feature(tree: Tree, name: str) -> Feature:
    frame, node = place(tree, name), tree.nodes[name]
    return Feature(
        name=name,
        type=node.type,
        at=frame[:3, 3],
        rotation=frame[:3, :3],
        appearances=tuple(_appearances(tree, node, np.eye(3))),
        arms=node.arms @ frame[:3, :3].T,
        parts=tuple(part for part in node.below if tree.nodes[part].kind == "feature"),
    )


def _appearances(tree: Tree, node: Node, turn: NDArray[np.float64]) -> Iterator[FeatureAppearance]:
    """The appearances below ``node``; ``turn`` (3, 3) = feature_from_node."""
    for part in (tree.nodes[name] for name in node.below):
        onward = turn @ part.parent_from_node[:3, :3]
        if part.viewpoint is not None:
            turned = replace(part.viewpoint, axis=onward @ part.viewpoint.axis)
            yield FeatureAppearance(part.type, turned)
        yield from _appearances(tree, part, onward)
