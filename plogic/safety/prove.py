"""One request for explanations, served in the child process: proofs of a goal, of its negation, and why it fails."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from problog.logic import Not

from plogic.program.mapping import mapped, shown
from plogic.proof.clauses import rules_of
from plogic.proof.failure import failure
from plogic.proof.search import Proof, Prover, Tree, literals
from plogic.proof.selection import probability
from plogic.proof.terms import problog_term, small, unify
from plogic.safety.check import check_goal, check_source, parse

if TYPE_CHECKING:
    from plogic.names import Names
    from plogic.proof.terms import Small


def prove(request: dict[str, Any], names: Names | None) -> dict[str, Any]:
    """``{"for": [...], "against": [...], "failure": tree | null}``; each explanation has probability, choices, evidence goal and tree."""
    known: frozenset[str] = frozenset()
    statements: list[Any] = []
    for i, item in enumerate(request["texts"]):
        source = parse(item["text"], item["file"])
        known |= check_source(source, known=known, protected=known)
        statements += [mapped(s, names) if names is not None and i else s for s in source.statements]
    goal = check_goal(parse(request["goals"][0].rstrip().removesuffix(".") + "\n.", "goal"), known)
    wanted = goal if names is None else mapped(goal, names)
    prover = Prover(rules_of(statements))
    why = _explanations(prover, small(wanted, {}), request["most"], names)
    why_not = _explanations(prover, small(Not("\\+", wanted), {}), request["most"], names)
    fails = None if why else _tree(failure(prover, small(wanted, {})), names)
    return {"for": why, "against": why_not, "failure": fails}


def _explanations(prover: Prover, goal: Small, most: int, names: Names | None) -> list[dict[str, Any]]:
    proofs = sorted(prover.prove(goal), key=lambda proof: (-probability(proof.selection), str(proof.goal)))
    return [_explanation(prover, proof, names) for proof in proofs[:most]]


def _explanation(prover: Prover, proof: Proof, names: Names | None) -> dict[str, Any]:
    choices = [shown(problog_term(literal), names) for literal in literals(proof.selection)]
    askable = all(choice.is_fact and all(_only_way(prover, head) for head in choice.heads) for choice in proof.selection)
    return {
        "goal": shown(problog_term(proof.goal), names),
        "probability": probability(proof.selection),
        "choices": choices,
        "askable": askable and bool(choices),
        "tree": _tree(proof.tree, names),
    }


def _only_way(prover: Prover, head: Small) -> bool:
    """Whether the choice's head can come from this choice alone, so that asking for it asks for the choice."""
    ways = [rule for rule, i in prover.rules.matching(head) if rule.body != ("fail",) and unify(rule.heads[i], head, {})]
    return len(ways) == 1


def _tree(tree: Tree, names: Names | None) -> dict[str, Any]:
    return {"goal": shown(problog_term(tree.goal), names), "kind": tree.kind, "children": [_tree(child, names) for child in tree.children]}
