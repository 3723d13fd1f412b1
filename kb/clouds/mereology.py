"""Part and whole over a tree, as in RCC (A3): proper part, part, overlap, discreteness.

Appearances are no parts: every relation raises TreeError for one, and for a node that the tree does not have.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import networkx as nx

from kb.errors import TreeError

if TYPE_CHECKING:
    from collections.abc import Set as AbstractSet


def wholly(tree: nx.DiGraph, x: str) -> AbstractSet[str]:
    """Everything that is part of x, x among it."""
    if x not in tree or tree.nodes[x]["kind"] == "appearance":
        raise TreeError(f"A3: {x!r} is no object and no feature of the tree")
    return {x} | {node for node in nx.descendants(tree, x) if tree.nodes[node]["kind"] != "appearance"}


def p(tree: nx.DiGraph, x: str, y: str) -> bool:
    """P(x, y) is true if x is y, or a proper part of y."""
    return wholly(tree, x) <= wholly(tree, y)


def pp(tree: nx.DiGraph, x: str, y: str) -> bool:
    """PP(x, y) is true if x is a part of y, and y is no part of x."""
    return wholly(tree, x) < wholly(tree, y)


def o(tree: nx.DiGraph, x: str, y: str) -> bool:
    """O(x, y) is true if something is part of both."""
    return bool(wholly(tree, x) & wholly(tree, y))


def dr(tree: nx.DiGraph, x: str, y: str) -> bool:
    """DR(x, y) is true if nothing is part of both: ¬O(x, y)."""
    return not o(tree, x, y)
