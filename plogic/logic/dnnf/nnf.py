"""A formula in negation normal form, deterministic and decomposable (d-DNNF), as lists.

Made smooth, so that every branch weighs every variable.

Nodes are numbered from 0, children before parents. Node 0 is true, node 1 is false; a literal's node is made on demand.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING

from plogic.inference.order import members

if TYPE_CHECKING:
    from collections.abc import Iterable

LITERAL, AND, OR = 0, 1, 2
TRUE, FALSE = 0, 1


@dataclass
class Nnf:
    """``kinds[i]`` and ``children[i]`` of each node.

    ``mentions[i]``: the variables below it, as bits; ``leaf``: literal → its node, ``literals``: the other way round.
    """

    kinds: list[int] = field(default_factory=lambda: [AND, OR])
    children: list[tuple[int, ...]] = field(default_factory=lambda: [(), ()])
    mentions: list[int] = field(default_factory=lambda: [0, 0])
    leaf: dict[int, int] = field(default_factory=dict)
    literals: dict[int, int] = field(default_factory=dict)
    root: int = TRUE
    _free: dict[int, int] = field(default_factory=dict)
    _stands: dict[int, int] = field(default_factory=dict)

    def literal(self, literal: int) -> int:
        """The leaf of a literal, or the node that stands for it."""
        if literal in self._stands:
            return self._stands[literal]
        if literal not in self.leaf:
            node = self.leaf[literal] = self._add(LITERAL, (), 1 << abs(literal))
            self.literals[node] = literal
        return self.leaf[literal]

    def conjunction(self, children: Iterable[int]) -> int:
        """And: its children share no variable."""
        kept = tuple(child for child in children if child != TRUE)
        if FALSE in kept:
            return FALSE
        if len(kept) < 2:
            return kept[0] if kept else TRUE
        return self._add(AND, kept, reduce(or_, (self.mentions[child] for child in kept)))

    def disjunction(self, children: Iterable[int]) -> int:
        """Or: no two of its children are true at once.

        A child that does not mention a variable of another's gets it, either way.
        """
        kept = tuple(child for child in children if child != FALSE)
        if len(kept) < 2:
            return kept[0] if kept else FALSE
        all_mentioned = reduce(or_, (self.mentions[child] for child in kept))
        smooth = tuple(self._smoothed(child, all_mentioned & ~self.mentions[child]) for child in kept)
        return self._add(OR, smooth, all_mentioned)

    def _smoothed(self, child: int, missing: int) -> int:
        if not missing:
            return child
        return self.conjunction((child, *self.frees(missing)))

    def stand_for(self, literal: int, yes: int, no: int, *, whole: bool) -> None:
        """Let ``yes`` stand for a literal and ``no`` for its negation.

        Both mention the same, of which nothing occurs elsewhere if ``whole``.
        """
        self._stands |= {literal: yes, -literal: no}
        if whole:
            free = self.disjunction((yes, no))
            self._free |= dict.fromkeys(members(self.mentions[free]), free)

    def frees(self, variables: int) -> list[int]:
        """Nodes that leave the variables, given as bits, open.

        Together with all that a node which stands for a literal mentions.
        """
        found = []
        while variables:
            found.append(self.free((variables & -variables).bit_length() - 1))
            variables &= ~self.mentions[found[-1]]
        return found

    def free(self, variable: int) -> int:
        """``variable ∨ ¬variable``."""
        if variable not in self._free:
            self._free[variable] = self._add(OR, (self.literal(variable), self.literal(-variable)), 1 << variable)
        return self._free[variable]

    def _add(self, kind: int, children: tuple[int, ...], mentions: int) -> int:
        self.kinds.append(kind)
        self.children.append(children)
        self.mentions.append(mentions)
        return len(self.kinds) - 1


def nodes_under(nnf: Nnf, root: int) -> set[int]:
    """A node and all nodes below it."""
    reached, stack = {root}, [root]
    while stack:
        new = {child for child in nnf.children[stack.pop()] if child not in reached}
        reached |= new
        stack.extend(new)
    return reached
