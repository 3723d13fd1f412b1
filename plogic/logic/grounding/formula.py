"""A growing ground formula: gates over choices, simplified and shared as they are made; acyclic, since children come first."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from plogic.logic.grounding.ground_program import Choice, Gate

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from plogic.logic.grounding.ground_program import Literal, Node


@dataclass
class Formula:
    """``nodes[i]`` is variable i + 1."""

    nodes: list[Node] = field(default_factory=list)
    index: dict[Hashable, int] = field(default_factory=dict)

    def choice(self, key: Hashable, group: Hashable, share: float, name: Callable[[], Any]) -> int:
        """The variable of a choice; the same key is the same choice."""
        if key not in self.index:
            self.nodes.append(Choice(share, group, name))
            self.index[key] = len(self.nodes)
        return self.index[key]

    def conjunction(self, literals: tuple[int, ...]) -> Literal:
        """And of literals, none of which is a constant; see ``fails``."""
        return None if fails(literals) else self._gate("and", tuple(dict.fromkeys(literals)))

    def disjunction(self, literals: tuple[Literal, ...]) -> Literal:
        """Or of literals and constants."""
        if 0 in literals:
            return 0
        kept = tuple(dict.fromkeys(literal for literal in literals if literal is not None))
        return self._gate("or", kept)

    def _gate(self, kind: str, children: tuple[int, ...]) -> Literal:
        if len(children) < 2:
            return children[0] if children else 0 if kind == "and" else None
        if kind == "or" and len({abs(child) for child in children}) < len(children):
            return 0
        key = Gate(kind, children)
        if key not in self.index:
            self.nodes.append(key)
            self.index[key] = len(self.nodes)
        return self.index[key]


def fails(literals: tuple[int, ...]) -> bool:
    """Whether a conjunction is false where ProbLog sees that: its last literal, and the last that differs from it, are opposites.

    Any other contradiction is a gate that never holds, so that an answer is listed with probability 0 where ProbLog
    lists it.
    """
    differing = next((literal for literal in reversed(literals) if literal != literals[-1]), None)
    return differing is not None and differing == -literals[-1]
