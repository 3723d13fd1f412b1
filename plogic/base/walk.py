"""Walks over graphs of any kind, each node that is reached once, depth first; and groups."""

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

Node = TypeVar("Node")
Key = TypeVar("Key")
Value = TypeVar("Value")


def reached(
    start: Iterable[Node], following: Callable[[Node], Iterable[Node]], seen: set[Node] | None = None
) -> Iterator[Node]:
    """Yield each node that is reached from ``start``; of those that follow one, the last is taken first.

    ``seen``: the nodes so far, for a ``following`` that asks for them.
    """
    seen = set() if seen is None else seen
    stack = list(start)
    while stack:
        node = stack.pop()
        if node not in seen:
            seen.add(node)
            yield node
            stack.extend(following(node))


def by_key(pairs: Iterable[tuple[Key, Value]]) -> dict[Key, list[Value]]:
    """Return the values of each key, in their order; the keys in the order of their first values."""
    groups: dict[Key, list[Value]] = {}
    for key, value in pairs:
        groups.setdefault(key, []).append(value)
    return groups
