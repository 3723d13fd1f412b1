"""Which hypotheses hang together: worlds are enumerated one connected component at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import networkx as nx

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.dependence import Dependence, Scene


def components(scene: Scene, graph: Dependence) -> list[tuple[str, ...]]:
    """The components, each in the order of Δh: nothing in one of them changes a probability in another."""
    links = nx.Graph()
    order = [h.id for h in scene.situation.hypotheses]
    links.add_nodes_from(order)
    links.add_edges_from(_links(scene, graph))
    found = [set(component) for component in nx.connected_components(links)]
    return sorted((tuple(h for h in order if h in component) for component in found), key=lambda c: order.index(c[0]))


def _links(scene: Scene, graph: Dependence) -> Iterator[tuple[str, str]]:
    situation = scene.situation
    yield from situation.overlaps
    if situation.reading == "score":
        yield from situation.exclusive
        yield from ((h, g) for h, gs in graph.of.items() for g in gs)
    else:
        yield from _posterior_links(scene)


def _posterior_links(scene: Scene) -> Iterator[tuple[str, str]]:
    for h in scene.situation.hypotheses:
        yield from ((h.id, g.id) for g in scene.situation.hypotheses if g.group == h.group)
        yield from ((h.id, g) for f in h.features if h.candidate(f) for g in scene.hiders(h, f))
    for claimants in scene.claimants.values():
        first = claimants[0][0].id
        yield from ((first, h.id) for h, _ in claimants[1:])
