"""A proof as a tree, and choices as goals that can be read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from plogic.logic.proof.choices import NONE
from plogic.logic.proof.terms import Small, fresh, refs, resolved, unify

if TYPE_CHECKING:
    from plogic.logic.proof.choices import Choice
    from plogic.logic.proof.ground_proofs import Grounding
    from plogic.logic.proof.rule_base import Rule

INTERNAL = "'plogic "
"""How the names of the rewritten program's own atoms begin."""


@dataclass(frozen=True)
class Tree:
    """One node of a proof.

    ``kind``: rule, fact, choice, check (a built-in test), absent (a negation that holds), computed (by the engine:
    findall/3 and the like), cases (no single proof is certain, but in every world one of these ways is open to it),
    case (one of them, and what it needs).
    """

    goal: Small
    kind: str
    children: tuple[Tree, ...] = ()


def choice_literal(ground: Grounding, choice: Choice, taken: int) -> Small:
    """The head that is taken; where none is, the negation of all of them. A clause with conditions is shown with them."""
    rule = ground.rules.by_number[choice.rule]
    body = _shown_body(rule, choice)
    if taken != NONE:
        return choice.heads[taken] if body is None or _tells(ground, rule, taken) else (":-", choice.heads[taken], body)
    if all(_tells(ground, rule, i) for i in range(len(rule.heads))):
        body = None
    either = joined(";", list(choice.heads))
    if body is not None:
        return ("\\+", (":-", either, body))
    return joined(",", [("\\+", head) for head in choice.heads])


def _tells(ground: Grounding, rule: Rule, head: int) -> bool:
    """Whether the head alone tells the choice: no other rule gives it, and it names all that the rule's instances differ in."""
    if not set(rule.variables) <= set(refs(rule.heads[head])):
        return False
    wanted = fresh(rule.heads[head])
    return sum(unify(other.heads[i], wanted, {}) for other, i in ground.rules.matching(wanted)) == 1


def _shown_body(rule: Rule, choice: Choice) -> Small | None:
    body = body_goal(rule)
    return None if body is None else resolved(body, dict(zip(rule.variables, choice.values, strict=False)))


def body_goal(rule: Rule) -> Small | None:
    """The conditions of a rule as one goal; None of a fact."""
    goals = [("\\+", x.goal) if x.kind == "not" else x.goal for x in rule.literals]
    return joined(",", goals) if goals else None


def joined(mark: str, goals: list[Small]) -> Small:
    """``a, b, c`` as one goal."""
    result = goals[-1]
    for goal in reversed(goals[:-1]):
        result = (mark, goal, result)
    return result


def plain(tree: Tree, goal: Small) -> Tree:
    """A tree without the rewritten program's own atoms: the goal's wrapper gives way to what it wraps, or is named after it."""
    children = tuple(plain(child, goal) for child in tree.children)
    if not str(tree.goal[0]).startswith(INTERNAL):
        return Tree(tree.goal, tree.kind, children)
    return children[0] if len(children) == 1 and tree.kind == "rule" else Tree(goal, tree.kind, children)
