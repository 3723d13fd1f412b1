"""From a set of choices that entails a goal to the tree of reasons: rule by rule, down to facts and choices.

``Truth`` says what follows from the choices in the engine's own formula, cycles and all: true, false, or open; and its
reasons. The formula is a ground logic program: its meaning is its least model, stratum by stratum. The certain and the
possible nodes are two least fixpoints that bound each other (the alternating fixpoint of the well-founded semantics,
Van Gelder 1989), with the open choices taken as false in one and as true in the other.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from plogic.base.walk import reached
from plogic.logic.proof.cone import NONE_TAKEN, Choice, Selection
from plogic.logic.proof.ground_proofs import Grounding, Key, Tree, bound_values, choice_literal, joined
from plogic.logic.proof.rewrite import Literal, Rule
from plogic.logic.proof.terms import Bindings, Small, canonical, is_ground, resolved, unify


@dataclass
class Truth:
    """Values under one selection; nodes are evaluated when they are first asked for.

    ``rank``: the order in which nodes became certain.
    """

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
        def following(node: int) -> list[int]:
            return [abs(child) for child in self.ground.children(node) if child and abs(child) not in self.certain]

        return sorted(reached([root], following))

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
        for node in reached([abs(key)] if key else [], lambda node: self._deciding(node, seen), seen):
            found = self.ground.choice(node)
            if found is not None and found[0] in self.selection:
                needed[found[0]] = self.selection[found[0]]
        return sorted(needed.items(), key=lambda item: item[0].order)

    def _deciding(self, node: int, seen: set[int]) -> list[int]:
        decisive = type(self.ground.formula.get_node(node)).__name__ == "disj"
        children = [child for child in self.ground.children(node) if child]
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

        def following(node: int) -> list[int]:
            children = reversed(self.ground.children(node))
            return [abs(child) for child in children if child and self.value(child) is None]

        nodes = reached([abs(key)] if key and self.value(key) is None else [], following)
        choices = (found[0] for node in nodes if (found := self.ground.choice(node)) is not None)
        return next((c for c in choices if c not in self.selection and c.sure is None), None)


MOST_CASES = 12
"""Ways that a tree by cases tells."""
DEEPEST_CASES = 2
"""Open choices that are told apart, one within the other; beyond that a tree only says that the goal holds whichever
way they fall."""


@dataclass
class Trees:
    """Builds trees under one selection."""

    ground: Grounding
    truth: Truth
    depth: int = 0
    done: dict[Small, Tree] = field(default_factory=dict)

    def of(self, goal: Small, key: Key) -> Tree:
        """Why the instance of a goal, whose node is ``key``, holds; by cases where no single proof does."""
        if self.truth.value(key):
            found = self._atom(goal, frozenset())
            return found if found is not None else Tree(goal, "computed", self._choices(key))
        return self._open(goal, frozenset())

    def against(self, goal: Small, key: Key) -> Tree:
        """Why the negation of a goal holds, ``key`` being the goal's node."""
        return self._absent(goal, key) if self.truth.value(key) is False else self._by_choices(("\\+", goal), key)

    def _open(self, goal: Small, above: frozenset[Small]) -> Tree:
        """Why a goal holds though no single proof of it is certain: one of several rules' instances gives it in every world."""
        known = canonical(goal)
        ways = list(self._possible(goal)) if known not in above else []
        if len(ways) == 1:
            rule, _, instance, _ = ways[0]
            children = self._conditions(rule, instance, above | {known})
            if children is not None:
                return Tree(goal, "rule" if rule.is_certain else "choice", tuple(children))
        if len(ways) > 1:
            return Tree(goal, "cases", tuple(self._case(*way, above | {known}) for way in ways[:MOST_CASES]))
        return Tree(goal, "cases")

    def _possible(self, goal: Small) -> Iterator[tuple[Rule, int, Small, bool]]:
        """The instances of rules that may give the goal, and whether their own choice is open."""
        for rule, index, instance, key in self._instances(goal):
            taken = index if rule.is_certain else self._taken(rule, instance)
            if self.truth.value(key) is not False and taken in (index, None):
                yield rule, index, instance, taken is None

    def _instances(self, goal: Small) -> Iterator[tuple[Rule, int, Small, Key]]:
        """The instances of rules one of whose heads is the goal, with the node of their conditions."""
        for rule, index in self.ground.rules.matching(goal):
            bindings: Bindings = {}
            if unify(rule.heads[index], goal, bindings):
                ask = resolved(rule.ask, bindings)
                yield from ((rule, index, *found) for found in (self.ground.ask(ask) if rule.literals else [(ask, 0)]))

    def _case(self, rule: Rule, index: int, instance: Small, is_open: bool, above: frozenset[Small]) -> Tree:  # noqa: FBT001
        """One instance: what is open of it is what it needs; what is certain, is told."""
        bound = bound_values(rule.variables, instance)
        needed: list[Small] = []
        told: list[Tree] = []
        for literal in rule.literals:
            if self._value(literal, bound) is None:
                goal = resolved(literal.goal, bound)
                needed.append(("\\+", goal) if literal.kind == "not" else goal)
            else:
                told += self._literal(literal, bound, above) or []
        if is_open:
            needed.append(resolved(rule.heads[index], bound))
        elif not rule.is_certain:
            choice = self.ground.made[rule.number, tuple(map(canonical, instance[1:]))]
            told.append(Tree(choice_literal(self.ground, choice, index), "choice"))
        return Tree(joined(",", needed) if needed else ("true",), "case", tuple(told))

    def _value(self, literal: Literal, bound: Bindings) -> bool | None:
        if literal.kind == "check":
            return True
        value = self.truth.value(self.ground.exists(resolved(literal.ask, bound)))
        return value if literal.kind != "not" or value is None else not value

    def _conditions(self, rule: Rule, instance: Small, above: frozenset[Small]) -> list[Tree] | None:
        """Those of the only instance there is: each that is open holds by cases itself."""
        bound = bound_values(rule.variables, instance)
        children: list[Tree] = []
        for literal in rule.literals:
            goal, ask = resolved(literal.goal, bound), resolved(literal.ask, bound)
            found = self._literal(literal, bound, above)
            if self._value(literal, bound) is None:
                found = [Tree(("\\+", goal), "cases") if literal.kind == "not" else self._open(ask, above)]
                if literal.kind == "part":
                    found = [Tree(goal, "cases", found[0].children)]
            if found is None:
                return None
            children += found
        return children

    def _by_choices(self, goal: Small, key: Key) -> Tree:
        """A negation that holds whichever way an open choice falls."""
        choice = self.truth.open_choice(key)
        if choice is None or self.depth == DEEPEST_CASES:
            return Tree(goal, "cases")
        cases = []
        for taken in sorted(choice.domain, key=lambda i: (i == NONE_TAKEN, i)):
            deeper = Trees(self.ground, Truth(self.ground, {**self.truth.selection, choice: taken}), self.depth + 1)
            below = deeper.against(goal[1], key)
            cases.append(
                Tree(
                    choice_literal(self.ground, choice, taken),
                    "case",
                    below.children if below.kind == "absent" else (below,),
                )
            )
        return Tree(goal, "cases", tuple(cases))

    def _atom(self, goal: Small, above: frozenset[Small]) -> Tree | None:
        """The proof of a goal whose node is certain; None if there is none that avoids the goals above it."""
        known = canonical(goal)
        if known in self.done:
            return self.done[known]
        if known in above:
            return None
        for rule, index, instance in self._certain(goal):
            children = self._body(rule, instance, above | {known})
            if children is not None:
                head = resolved(rule.heads[index], bound_values(rule.variables, instance))
                kind = "choice" if not rule.is_certain else "rule" if rule.literals else "fact"
                self.done[known] = Tree(head, kind, children)
                return self.done[known]
        return None

    def _certain(self, goal: Small) -> Iterator[tuple[Rule, int, Small]]:
        """The instances of rules that certainly give the goal, in the order in which they became certain."""
        found = [
            (self.truth.order(key), (rule, index, instance))
            for rule, index, instance, key in self._instances(goal)
            if self.truth.value(key) and (rule.is_certain or self._taken(rule, instance) == index)
        ]
        yield from (way for _, way in sorted(found, key=lambda f: f[0]))

    def _taken(self, rule: Rule, instance: Small) -> int | None:
        choice = self.ground.made.get((rule.number, tuple(canonical(v) for v in instance[1:])))
        return None if choice is None else self.truth.selection.get(choice, choice.sure)

    def _body(self, rule: Rule, instance: Small, above: frozenset[Small]) -> tuple[Tree, ...] | None:
        bound = bound_values(rule.variables, instance)
        children: list[Tree] = []
        for literal in rule.literals:
            found = self._literal(literal, bound, above)
            if found is None:
                return None
            children += found
        return tuple(children)

    def _literal(self, literal: Literal, bound: Bindings, above: frozenset[Small]) -> list[Tree] | None:
        goal, ask = resolved(literal.goal, bound), resolved(literal.ask, bound)
        if literal.kind == "check":
            return [Tree(goal, "check")]
        if literal.kind == "not":
            return [self._absent(goal, self.ground.exists(ask))]
        if literal.kind == "computed":
            key = next((key for _, key in self.ground.ask(ask) if self.truth.value(key)), 0)
            return [Tree(goal, "computed", self._choices(key))]
        tree = self._instance(ask, above)
        if tree is None:
            return None
        return list(tree.children) if literal.kind == "part" else [tree]

    def _instance(self, goal: Small, above: frozenset[Small]) -> Tree | None:
        if is_ground(goal):
            return self._atom(goal, above)
        certain = [
            (self.truth.order(key), instance) for instance, key in self.ground.ask(goal) if self.truth.value(key)
        ]
        found = (self._atom(instance, above) for _, instance in sorted(certain, key=lambda c: c[0]))
        return next((tree for tree in found if tree is not None), None)

    def _absent(self, goal: Small, key: Key) -> Tree:
        """A negation that holds, by the choices that break what it denies; itself a choice where that is all."""
        denied, reasons = ("\\+", goal), self._choices(key)
        return reasons[0] if len(reasons) == 1 and reasons[0].goal == denied else Tree(denied, "absent", reasons)

    def _choices(self, key: Key) -> tuple[Tree, ...]:
        return tuple(
            Tree(choice_literal(self.ground, choice, taken), "choice") for choice, taken in self.truth.reasons(key)
        )
