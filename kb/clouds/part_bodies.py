"""What of a type's surface is which part's: a part that is an object has a body of its own, so that parts can occlude (§3.5-3.7).

A facet belongs to the part that holds the feature nearest to the facet's middle (the first of equals, in the tree's
order), and with it to every part that this part is a part of. So the bodies of parts that hold none of each other share
no facet, and they are open where the part meets the rest. A part that no facet is nearest to has no body, and nothing
is said of what it hides.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kb.clouds.tree import object_nodes
from kb.surfaces.surface import Surface

if TYPE_CHECKING:
    import networkx as nx
    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType


def part_bodies(kind: ObjectType) -> dict[str, Surface]:
    """The bodies, object frame, of the parts that are objects, by node, in the tree's order; the maximal object is not among them."""
    parts = [node for node in object_nodes(kind.tree) if node]
    features = kind.seen_features
    if kind.surface is None or not parts or not features:
        return {}
    middles = kind.surface.vertices[kind.surface.triangles].mean(axis=1)
    nearest = _nearest(middles, np.array([feature.at for feature in features]))
    owner = [_owner(kind.tree, feature.name) for feature in features]
    owners = np.array([owner[f] for f in nearest])
    bodies = {part: np.flatnonzero([name == part or name.startswith(f"{part}/") for name in owners]) for part in parts}
    return {part: _body(kind.surface, facets) for part, facets in bodies.items() if len(facets)}


def _nearest(points: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.intp]:
    """(N,) the place (P, 3) nearest to each of the points (N, 3); the first of equals."""
    from scipy.spatial import cKDTree

    far = cKDTree(places).query(points)[0]
    close = cKDTree(places).query_ball_point(points, far * (1 + 1e-9) + 1e-12)
    return np.array([min(some) for some in close], dtype=np.intp)


def _owner(tree: nx.DiGraph, name: str) -> str:
    """The innermost object on the path to a feature; '' for the maximal one."""
    steps = name.split("/")
    paths = ("/".join(steps[:n]) for n in range(len(steps) - 1, 0, -1))
    return next((path for path in paths if path in tree and tree.nodes[path]["kind"] == "object"), "")


def _body(surface: Surface, facets: NDArray[np.intp]) -> Surface:
    used, index = np.unique(surface.triangles[facets], return_inverse=True)
    return Surface(surface.vertices[used], index.reshape(-1, 3))
