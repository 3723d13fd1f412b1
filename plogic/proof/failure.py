"""Why a goal fails: for each rule that could have proved it, the first condition that does not hold, down to what is missing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.proof.clauses import TRUE
from plogic.proof.search import Tree
from plogic.proof.terms import Bindings, Small, resolved, signature, unify

if TYPE_CHECKING:
    from plogic.proof.search import Prover

DEEPEST = 12
WIDEST = 5


def failure(prover: Prover, goal: Small, depth: int = 0) -> Tree:
    """The tree of a goal without proofs; a node without children has no fact or rule for it."""
    if depth > DEEPEST:
        return Tree(goal, "fails")
    if signature(goal) in ((",", 2), (";", 2)):
        return Tree(goal, "fails", _of_body(prover, goal, {}, depth))
    if signature(goal) in (("\\+", 1), ("not", 1)):
        return Tree(goal, "fails", tuple(proof.tree for proof in prover.prove(goal[1])[:1]))
    reasons: list[Tree] = []
    for rule, index in prover.rules.matching(goal):
        fresh, bindings = rule.fresh(), Bindings()
        if len(reasons) < WIDEST and unify(goal, fresh.heads[index], bindings) and fresh.body not in (TRUE, ("fail",)):
            reasons.extend(_of_body(prover, fresh.body, bindings, depth))
    return Tree(goal, "fails", tuple(reasons))


def _of_body(prover: Prover, body: Small, bindings: Bindings, depth: int) -> tuple[Tree, ...]:
    """The condition at which a body fails, having got as far as it can."""
    if signature(body) == (";", 2):
        return tuple(tree for side in body[1:] for tree in _of_body(prover, side, bindings, depth))
    if signature(body) != (",", 2):
        return (failure(prover, resolved(body, bindings), depth + 1),)
    ways = list(prover.conjunction(body[1], bindings))
    if not ways:
        return _of_body(prover, body[1], bindings, depth)
    return _of_body(prover, body[2], ways[0][0], depth)
