"""Trees and misses as plain data, numbers put to the conditions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from plogic.logic.proof.misses import Candidate, Condition, Looking, conditions, lacking
from plogic.logic.proof.reasons import body_goal
from plogic.logic.proof.relevant_evidence import numbers_of
from plogic.logic.proof.terms import Bindings, refs, resolved, signature
from plogic.logic.proof.written_terms import LETTERS, text

if TYPE_CHECKING:
    from plogic.logic.proof.cone import Steps
    from plogic.logic.proof.ground_proofs import Grounding
    from plogic.logic.proof.reasons import Tree
    from plogic.logic.proof.rule_base import Rule
    from plogic.logic.proof.terms import Small
    from plogic.logic.safety.atoms import Names

Data = dict[str, Any]
SURE = 1e-12
HALF = 0.5
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
    chances = {id(c): p for c, p in zip(listed, numbers.probabilities(numbers.literals), strict=True)}
    literal = {id(c): lit for c, lit in zip(listed, numbers.literals, strict=True)}
    joint = numbers.joint([[literal[id(x)] for x in c.conditions] for c in candidates])
    misses: list[tuple[int, float, float, int, Miss]] = []
    for candidate, p in zip(candidates, joint, strict=True):
        failed, product = lacking(candidate, lambda c: chances[id(c)])
        misses.append((failed, -p, product, len(misses), Miss(candidate, failed, p, chances)))
    notes = [f"{looking.skipped} further instances of rules were not looked at"] if looking.skipped else []
    return [miss for *_, miss in sorted(misses, key=lambda m: m[:4])], notes


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


def _kind(condition: Condition, p: float) -> str:
    if condition.is_open:
        return "open"
    return "fails" if p <= 0 else "holds" if p >= 1 - SURE else "possible"


def _condition(condition: Condition, chances: dict[int, float], names: Names | None) -> Data:
    p = chances[id(condition)]
    kind = _kind(condition, p)
    below = _below(condition, chances, names) if p < HALF and not condition.is_open else []
    return _node(text(condition.goal, names), kind, below, None if condition.is_open else p)


def _below(condition: Condition, chances: dict[int, float], names: Names | None) -> list[Data]:
    """What a failed condition lacks: the conditions of its nearest miss. Of a negation: what holds although it should not."""
    if not condition.below:
        return []
    order = [(lacking(c, lambda x: chances[id(x)]), i, c) for i, c in enumerate(condition.below)]
    nearest = min(order, key=lambda o: o[:2])[2]
    told = [_condition(c, chances, names) for c in nearest.conditions]
    return told if condition.is_negated or any(c["kind"] != "holds" for c in told) else []


def failure_data(goal: Small, misses: list[Miss], names: Names | None) -> Data:
    """The tree of what fails: of each of the nearest misses, the conditions that cannot hold."""
    least = misses[0].failed if misses else 0
    near = [miss for miss in misses if miss.failed == least]
    children = [c for miss in near for c in miss_data(miss, names)["conditions"] if c["kind"] in ("fails", "open")]
    unique = list({c["goal"]: c for c in children}.values())
    return _node(text(goal, names), "fails", [_failing(c) for c in unique])


def _failing(node: Data) -> Data:
    if node["goal"].startswith("\\+"):
        return node
    return {**node, "children": [_failing(c) for c in node["children"] if c["kind"] in ("fails", "open")]}
