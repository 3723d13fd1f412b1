"""Why not: each rule that could have given a goal, with every condition looked at; what lacks least comes first.

Two passes: ``candidates`` walks the rules and lets the engine ground each condition as far as the ones before it bind
its variables; when the program is compiled and P(condition | evidence) is known, ``told`` ranks what was found and says
it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import prod
from typing import TYPE_CHECKING

from plogic.logic.proof.terms import Bindings, Small, fresh, is_ground, refs, resolved, unify

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from plogic.logic.proof.ground_proofs import Grounding, Key
    from plogic.logic.proof.rule_base import Literal, Rule

DEEPEST = 4
INSTANCES = 40
"""Instances of one rule that are looked at."""
CONDITIONS = 400
"""Conditions that are looked at in all."""


@dataclass
class Condition:
    """One condition of a rule's instance: its node, and the rules that could give it (of a negation, those that give what it denies).

    ``is_open``: it cannot be asked, since a condition before it failed to bind its variables.
    """

    goal: Small
    key: Key
    is_negated: bool = False
    is_open: bool = False
    below: list[Candidate] = field(default_factory=list)


@dataclass
class Candidate:
    """One instance of a rule whose ``index``-th head gives ``goal``; no rule where the goal is itself the conditions."""

    goal: Small
    rule: Rule | None
    index: int
    conditions: list[Condition]


@dataclass
class Looking:
    """Finds candidates; ``left`` is what may still be looked at, ``skipped`` counts the goal's own rule instances that were not."""

    ground: Grounding
    left: int = CONDITIONS
    skipped: int = 0

    def candidates(self, goal: Small, depth: int = 0, above: tuple[Small, ...] = ()) -> list[Candidate]:
        """Every instance of every rule whose head fits the goal."""
        wanted = fresh(goal)
        found: list[Candidate] = []
        for rule, index in self.ground.rules.matching(wanted):
            bindings: Bindings = {}
            if not unify(rule.heads[index], wanted, bindings):
                continue
            if not rule.literals:
                found.append(Candidate(resolved(wanted, bindings), rule, index, []))
                continue
            ways = list(self._ways(rule, bindings, depth, (*above, goal)))
            found += [Candidate(resolved(wanted, bound), rule, index, conditions) for bound, conditions in ways]
        return found

    def _ways(
        self, rule: Rule, bindings: Bindings, depth: int, above: tuple[Small, ...]
    ) -> Iterator[tuple[Bindings, list[Condition]]]:
        """Ways through a body from left to right, a condition that fails leaving its variables unbound."""
        partial: list[tuple[Bindings, list[Condition]]] = [(bindings, [])]
        for literal in rule.literals:
            partial = [
                (b, [*done, condition])
                for bound, done in partial
                for b, condition in self._next(literal, bound, done, depth, above)
            ]
            self.skipped += max(0, len(partial) - INSTANCES) if depth == 0 else 0
            partial = sorted(partial, key=lambda way: sum(_fails(c) for c in way[1]))[:INSTANCES]
        yield from partial

    def _next(
        self, literal: Literal, bound: Bindings, done: list[Condition], depth: int, above: tuple[Small, ...]
    ) -> list[tuple[Bindings, Condition]]:  # fmt: skip
        """The condition; open where a variable stayed unbound since one before it failed: the program itself would never ask that."""
        if any(map(_fails, done)) and not is_ground(resolved(literal.ask, bound)):
            goal = resolved(literal.goal, bound)
            return [(bound, Condition(("\\+", goal) if literal.kind == "not" else goal, None, is_open=True))]
        return self._one(literal, bound, depth, above)

    def _one(
        self, literal: Literal, bound: Bindings, depth: int, above: tuple[Small, ...]
    ) -> list[tuple[Bindings, Condition]]:
        self.left -= 1
        goal, ask = resolved(literal.goal, bound), resolved(literal.ask, bound)
        if literal.kind == "not":
            key = self.ground.exists(ask)
            below = self._below(ask, depth, above) if key is not None else []
            return [(bound, Condition(("\\+", goal), _negated(key), is_negated=True, below=below))]
        found = self.ground.tested(ask)
        if found is None:
            return [(bound, Condition(goal, None, is_open=True))]
        if not found:
            below = self._below(ask, depth, above) if literal.kind in ("atom", "part") else []
            is_open = literal.kind in ("check", "computed") and any(True for _ in refs(ask))
            return [(bound, Condition(goal, None, is_open=is_open, below=below))]
        return [self._instance(literal, bound, ask, instance, key, depth, above) for instance, key in found]

    def _instance(
        self, literal: Literal, bound: Bindings, ask: Small, instance: Small, key: Key, depth: int, above: tuple[Small, ...]
    ) -> tuple[Bindings, Condition]:  # fmt: skip
        further = dict(bound)
        unify(ask, instance, further)
        followed = literal.kind in ("atom", "part") and key != 0
        below = self._below(instance, depth, above) if followed else []
        goal = resolved(literal.goal, further)
        is_open = literal.kind == "check" and any(True for _ in refs(goal))
        return further, Condition(goal, None if is_open else key, is_open=is_open, below=below)

    def _below(self, goal: Small, depth: int, above: tuple[Small, ...]) -> list[Candidate]:
        if depth >= DEEPEST or self.left <= 0 or goal in above:
            return []
        return self.candidates(goal, depth + 1, above)


def conditions(candidates: list[Candidate]) -> Iterator[Condition]:
    """All of them, those below included."""
    for candidate in candidates:
        for condition in candidate.conditions:
            yield condition
            yield from conditions(condition.below)


def _negated(key: Key) -> Key:
    return 0 if key is None else None if key == 0 else -key


def _fails(condition: Condition) -> bool:
    return condition.key is None


def lacking(candidate: Candidate, p: Callable[[Condition], float]) -> tuple[int, float]:
    """How many conditions cannot hold, and minus the product of the others' probabilities: the order of misses."""
    chances = [0.0 if condition.is_open else p(condition) for condition in candidate.conditions]
    return sum(chance <= 0 for chance in chances), -prod(chance for chance in chances if chance > 0)
