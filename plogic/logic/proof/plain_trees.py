"""Trees and misses as plain data, numbers put to the conditions.

Misses tell why not: each rule that could have given a goal, with every condition looked at, the fewest lacking
conditions first. Two passes: ``Looking`` walks the rules and lets the engine ground each condition as far as the ones
before it bind its variables; when the program is compiled and P(condition | evidence) is known, ``missed`` ranks the
candidates.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any

from plogic.logic.grounding.ground_program import negated
from plogic.logic.proof.cone import Steps
from plogic.logic.proof.ground_proofs import Grounding, Key, Tree, body_goal
from plogic.logic.proof.relevant_evidence import numbers_of
from plogic.logic.proof.rewrite import Literal, Rule
from plogic.logic.proof.terms import LETTERS, Bindings, Small, fresh, is_ground, refs, resolved, signature, text, unify
from plogic.logic.safety.atoms import Names

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
    below: "list[Candidate]" = field(default_factory=list)


@dataclass
class Candidate:
    """One instance of a rule whose ``index``-th head gives ``goal``.

    No rule where the goal is itself the conditions.
    """

    goal: Small
    rule: Rule | None
    index: int
    conditions: list[Condition]


@dataclass
class Looking:
    """Finds candidates.

    ``left`` is what may still be looked at, ``skipped`` counts the goal's own rule instances that were not.
    """

    ground: Grounding
    left: int = CONDITIONS
    skipped: int = 0

    def candidates(self, goal: Small, depth: int = 0, above: tuple[Small, ...] = ()) -> list[Candidate]:
        """Every instance of every rule whose head fits the goal."""
        wanted = fresh(goal)
        found: list[Candidate] = []
        for rule, index in self.ground.rules.matching(wanted):
            bindings: Bindings = {}
            if unify(rule.heads[index], wanted, bindings):
                ways = self._ways(rule, bindings, depth, (*above, goal))
                found += [Candidate(resolved(wanted, bound), rule, index, conditions) for bound, conditions in ways]
        return found

    def _ways(
        self, rule: Rule, bindings: Bindings, depth: int, above: tuple[Small, ...]
    ) -> list[tuple[Bindings, list[Condition]]]:
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
        return partial

    def _next(
        self, literal: Literal, bound: Bindings, done: list[Condition], depth: int, above: tuple[Small, ...]
    ) -> list[tuple[Bindings, Condition]]:  # fmt: skip
        """The condition.

        Open where a variable stayed unbound since one before it failed: the program itself would never ask that.
        """
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
            return [(bound, Condition(("\\+", goal), negated(key), is_negated=True, below=below))]
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
        return [] if depth >= DEEPEST or self.left <= 0 or goal in above else self.candidates(goal, depth + 1, above)


def conditions(candidates: list[Candidate]) -> Iterator[Condition]:
    """All of them, those below included."""
    for candidate in candidates:
        for condition in candidate.conditions:
            yield condition
            yield from conditions(condition.below)


def _fails(condition: Condition) -> bool:
    return condition.key is None


def lacking(candidate: Candidate, p: Callable[[Condition], float]) -> tuple[int, float]:
    """How many conditions cannot hold, and minus the product of the others' probabilities: the order of misses."""
    chances = [0.0 if condition.is_open else p(condition) for condition in candidate.conditions]
    return sum(chance <= 0 for chance in chances), -prod(chance for chance in chances if chance > 0)


Data = dict[str, Any]
CERTAIN = 1e-12
TOLD_BELOW = 0.5
"""A condition less probable than this is told with what it lacks."""


@dataclass(frozen=True)
class Miss:
    """One way in which the goal could have been, with P(all its conditions | evidence), and P of each condition by its place in memory."""

    candidate: Candidate
    failed: int
    probability: float
    chances: dict[int, float]


def tree_data(tree: Tree, names: Names | None) -> Data:
    """A proof."""
    return _node(text(tree.goal, names), tree.kind, [tree_data(child, names) for child in tree.children])


def _node(goal: str, kind: str, children: list[Data], probability: float | None = None) -> Data:
    return {"goal": goal, "kind": kind, "children": children, "probability": probability}


def missed(ground: Grounding, goal: Small, ask: Small, steps: Steps) -> tuple[list[Miss], list[str]]:
    """Every way that was looked at, what lacks least first; and what was not looked at, in words."""
    looking = Looking(ground)
    followed = signature(goal) in ground.rules.by_signature
    found = (
        looking.candidates(goal) if followed else [replace(c, goal=goal, rule=None) for c in looking.candidates(ask)]
    )
    candidates = [c for c in found if c.conditions or c.rule is None or not c.rule.is_certain]
    listed = list(conditions(candidates))
    numbers = numbers_of(ground, [c.key for c in listed], steps)
    chances = {id(c): p for c, p in zip(listed, numbers.compiled.probabilities(numbers.literals), strict=True)}
    literal = {id(c): lit for c, lit in zip(listed, numbers.literals, strict=True)}
    joint = numbers.joint([[literal[id(x)] for x in c.conditions] for c in candidates])
    lacks = [lacking(candidate, lambda c: chances[id(c)]) for candidate in candidates]
    misses = [
        ((failed, -p, product), Miss(candidate, failed, p, chances))
        for candidate, p, (failed, product) in zip(candidates, joint, lacks, strict=True)
    ]
    notes = [f"{looking.skipped} further instances of rules were not looked at"] if looking.skipped else []
    return [miss for _, miss in sorted(misses, key=lambda m: m[0])], notes


def miss_data(miss: Miss, names: Names | None) -> Data:
    """A miss with its conditions, each with its probability and, where it fails, with what it lacks itself."""
    candidate = miss.candidate
    return {
        "goal": text(candidate.goal, names),
        "rule": "" if candidate.rule is None else rule_text(candidate.rule, candidate.index, names),
        "failed": miss.failed,
        "probability": miss.probability,
        "conditions": [_condition(c, miss.chances, names) for c in candidate.conditions],
    }


def rule_text(rule: Rule, index: int, names: Names | None) -> str:
    """The rule as it was written, but for the names of its variables, and with the one head that matters."""
    body = body_goal(rule)
    head, label = rule.heads[index], rule.labels[index]
    order = dict.fromkeys(refs((label, head, body)))
    letters: Bindings = {v: (LETTERS[i] if i < len(LETTERS) else f"X{i}",) for i, v in enumerate(order)}
    shown = text(resolved(head, letters), names)
    chance = "" if label is None else f"{text(resolved(label, letters), names)}::"
    others = "; ..." if len(rule.heads) > 1 else ""
    return f"{chance}{shown}{others}" + ("" if body is None else f" :- {text(resolved(body, letters), names)}")


def _condition(condition: Condition, chances: dict[int, float], names: Names | None) -> Data:
    p = chances[id(condition)]
    if condition.is_open:
        return _node(text(condition.goal, names), "open", [])
    kind = "fails" if p <= 0 else "holds" if p >= 1 - CERTAIN else "possible"
    return _node(text(condition.goal, names), kind, _below(condition, chances, names) if p < TOLD_BELOW else [], p)


def _below(condition: Condition, chances: dict[int, float], names: Names | None) -> list[Data]:
    """What a failed condition lacks: the conditions of its nearest miss.

    Of a negation: what holds although it should not.
    """
    if not condition.below:
        return []
    order = [(lacking(c, lambda x: chances[id(x)]), i, c) for i, c in enumerate(condition.below)]
    told = [_condition(c, chances, names) for c in min(order, key=lambda o: o[:2])[2].conditions]
    return told if condition.is_negated or any(c["kind"] != "holds" for c in told) else []


def failure_data(goal: Small, misses: list[Miss], names: Names | None) -> Data:
    """The tree of what fails: of each of the nearest misses, the conditions that cannot hold."""
    near = [miss for miss in misses if miss.failed == misses[0].failed]
    children = [c for miss in near for c in miss_data(miss, names)["conditions"] if c["kind"] in ("fails", "open")]
    unique = list({c["goal"]: c for c in children}.values())
    return _node(text(goal, names), "fails", [_failing(c) for c in unique])


def _failing(node: Data) -> Data:
    if node["goal"].startswith("\\+"):
        return node
    return {**node, "children": [_failing(c) for c in node["children"] if c["kind"] in ("fails", "open")]}
