"""Which variables hang together: nothing in one connected piece of a graph changes a probability in another."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plogic.inference.graph import FactorGraph


def pieces(graph: FactorGraph) -> list[frozenset[int]]:
    """The connected pieces, by their least variable."""
    home = list(range(len(graph.cards)))

    def root(v: int) -> int:
        while home[v] != v:
            home[v] = v = home[home[v]]
        return v

    for factor in graph.factors:
        for v in factor.scope[1:]:
            x, y = sorted((root(factor.scope[0]), root(v)))
            home[y] = x
    found: dict[int, set[int]] = {}
    for v in range(len(home)):
        found.setdefault(root(v), set()).add(v)
    return [frozenset(found[v]) for v in sorted(found)]
