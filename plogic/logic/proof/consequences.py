"""What follows from a set of choices, in the engine's own formula, cycles and all: true, false, or open; and what it rests on.

The formula is a ground logic program: its meaning is its least model, stratum by stratum. What is certain and what is
possible are two least fixpoints that bound each other (the alternating fixpoint of the well-founded semantics, Van
Gelder 1989), with the open choices taken as false in one and as true in the other.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plogic.logic.proof.choices import Choice, Selection
    from plogic.logic.proof.ground_proofs import Grounding, Key


@dataclass
class Truth:
    """Values under one selection; nodes are evaluated when they are first asked for. ``rank``: the order in which nodes became certain."""

    ground: Grounding
    selection: Selection
    certain: dict[int, bool] = field(default_factory=dict)
    possible: dict[int, bool] = field(default_factory=dict)
    rank: dict[int, int] = field(default_factory=dict)

    def value(self, key: Key) -> bool | None:
        """Of a node or its negation."""
        if not key:
            return key is not None
        self._evaluate(abs(key))
        if self.certain[abs(key)]:
            return key > 0
        return None if self.possible[abs(key)] else key < 0

    def order(self, key: Key) -> int:
        """When a node became certain: what it rests on came no later."""
        return self.rank.get(key or 0, 0)

    def _evaluate(self, root: int) -> None:
        if root in self.certain:
            return
        nodes = self._new(root)
        for node in nodes:
            self.certain[node], self.possible[node] = False, True
        while True:
            certain = self._least(nodes, self.certain, self.possible, open_is=False)
            possible = self._least(nodes, self.possible, certain, open_is=True)
            if all(self.certain[n] == certain[n] and self.possible[n] == possible[n] for n in nodes):
                return
            self.certain.update((n, certain[n]) for n in nodes)
            self.possible.update((n, possible[n]) for n in nodes)

    def _new(self, root: int) -> list[int]:
        found: set[int] = set()
        stack = [root]
        while stack:
            node = stack.pop()
            if node not in found and node not in self.certain:
                found.add(node)
                stack.extend(abs(child) for child in self.children(node) if child)
        return sorted(found)

    def children(self, node: int) -> tuple[Key, ...]:
        """Of a gate; an atom has none."""
        return tuple(getattr(self.ground.formula.get_node(node), "children", ()))

    def _least(
        self, nodes: list[int], known: dict[int, bool], opposite: dict[int, bool], *, open_is: bool
    ) -> dict[int, bool]:
        """The least fixpoint over the new nodes, negations taken from ``opposite``."""
        values = {**known, **dict.fromkeys(nodes, False)}
        changed = True
        while changed:
            changed = False
            for node in nodes:
                if not values[node] and self._holds(node, values, opposite, open_is=open_is):
                    values[node] = changed = True
                    if not open_is:
                        self.rank[node] = len(self.rank) + 1 if node not in self.rank else self.rank[node]
        return values

    def _holds(self, node: int, values: dict[int, bool], opposite: dict[int, bool], *, open_is: bool) -> bool:
        content: Any = self.ground.formula.get_node(node)
        kind = type(content).__name__
        if kind == "atom":
            return self._atom(node, open_is=open_is)
        flags = (
            child is not None if not child else values[child] if child > 0 else not opposite.get(-child, False)
            for child in content.children
        )
        return all(flags) if kind == "conj" else any(flags)

    def _atom(self, node: int, *, open_is: bool) -> bool:
        found = self.ground.choice(node)
        if found is None:
            return open_is
        choice, head = found
        taken = self.selection.get(choice, choice.sure)
        return open_is if taken is None else taken == head

    def reasons(self, key: Key) -> list[tuple[Choice, int]]:
        """Choices of the selection that give a node its value: one side of an OR that holds, or of an AND that does not; else all."""
        needed: dict[Choice, int] = {}
        seen: set[int] = set()
        stack = [abs(key)] if key else []
        while stack:
            node = stack.pop()
            if node in seen:
                continue
            seen.add(node)
            found = self.ground.choice(node) if type(self.ground.formula.get_node(node)).__name__ == "atom" else None
            if found is not None and found[0] in self.selection:
                needed[found[0]] = self.selection[found[0]]
            stack.extend(self._deciding(node, seen))
        return sorted(needed.items(), key=lambda item: item[0].order)

    def _deciding(self, node: int, seen: set[int]) -> list[int]:
        content = self.ground.formula.get_node(node)
        decisive = type(content).__name__ == "disj"
        children = [child for child in self.children(node) if child]
        deciding = [child for child in children if self.value(child) is decisive]
        if not deciding:
            return [abs(child) for child in children]
        if self.value(node) is not decisive or any(
            abs(child) in seen and self.order(child) < self.order(node) for child in deciding
        ):
            return []
        first = min(deciding, key=lambda child: (self.order(child), abs(child)))
        return [abs(first)]

    def open_choice(self, key: Key) -> Choice | None:
        """A choice that an open node still waits for."""
        seen: set[int] = set()
        stack = [abs(key)] if key and self.value(key) is None else []
        while stack:
            node = stack.pop()
            if node in seen:
                continue
            seen.add(node)
            if type(self.ground.formula.get_node(node)).__name__ == "atom":
                found = self.ground.choice(node)
                if found is not None and found[0] not in self.selection and found[0].sure is None:
                    return found[0]
            stack.extend(abs(child) for child in reversed(self.children(node)) if child and self.value(child) is None)
        return None
