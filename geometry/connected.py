"""Connected pieces of a graph, without numpy."""

from collections.abc import Iterable


def roots(count: int, scopes: Iterable[tuple[int, ...]]) -> list[int]:
    """Return, for each of ``count`` nodes, the least node of its connected piece; a scope joins its nodes."""
    root = list(range(count))
    for scope in scopes:
        if len(scope) > 1:
            tops = {_top(root, v) for v in scope}
            least = min(tops)
            for top in tops:
                root[top] = least
    for v in range(count):
        root[v] = root[root[v]]
    return root


def _top(root: list[int], v: int) -> int:
    while root[v] != v:
        root[v] = root[root[v]]
        v = root[v]
    return v
