"""One request for explanations, served in the child process: why a goal holds, why not, and what was missing.

Where a goal names a predicate or a constant that the program does not know, the closest known ones are told.
"""

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from problog.errors import ProbLogError

from plogic.base.errors import UnknownPredicateError
from plogic.logic.answers.answer import answers_to
from plogic.logic.grounding.load import goal_in, parsed, read
from plogic.logic.grounding.load import variables as variables_of
from plogic.logic.proof.goal_account import Options, account
from plogic.logic.proof.ground_proofs import Grounding
from plogic.logic.proof.rewrite import Rewriter, Rules, defined_by
from plogic.logic.proof.terms import Ref, Small, is_atom, signature, small, text
from plogic.logic.safety.atoms import Names
from plogic.logic.safety.guarded_engine import engine_for, told

MOST_LISTED = 8


def unknown_predicate(goal: Any, defined: set[tuple[str, int]]) -> str:  # noqa: ANN401 - a term of ProbLog's
    """``; present/1 is known``, or the closest names."""
    wanted = next((s for s in map(signature, _atoms(small(goal, {}))) if s not in defined), None)
    if wanted is None:
        return ""
    arities = sorted(arity for name, arity in defined if name == wanted[0])
    if arities:
        return f"; {', '.join(f'{wanted[0]}/{arity}' for arity in arities)} is known"
    public = sorted({name for name, _ in defined if not name.startswith("_")})
    close = get_close_matches(wanted[0], public, n=3, cutoff=0.6)
    names = [f"{name}/{arity}" for name in close for known, arity in sorted(defined) if known == name]
    return f"; the closest that is known: {', '.join(names)}" if names else ""


def unknown_names(goal: Small, rules: Rules, names: Names | None) -> list[str]:
    """One sentence for each constant of the goal that occurs nowhere at its place, though the program has others there.

    A hypothesis is no unknown name, though no fact at this place speaks of it.
    """
    hypotheses = _at(rules, ("hypothesis", 2), 1)
    places = (
        (atom, i, argument, _at(rules, signature(atom), i))
        for atom in _atoms(goal)
        for i, argument in enumerate(atom[1:], 1)
        if is_atom(argument) and isinstance(argument, tuple)
    )
    return [
        _note(atom, i, argument, sorted(text(k, names) for k in known), names)
        for atom, i, argument, known in places
        if known and argument not in known | hypotheses
    ]


def _note(atom: Small, place: int, argument: Small, known: list[str], names: Names | None) -> str:
    said = text(argument, names)
    close = get_close_matches(said, known, n=3, cutoff=0.5)
    listed = close or known[:MOST_LISTED]
    more = "" if close or len(known) <= MOST_LISTED else f", ... ({len(known)} in all)"
    name, arity = signature(atom)
    which = "closest are" if close else "there are"
    return f"{said} is unknown as argument {place} of {name}/{arity}; {which} {', '.join(listed)}{more}"


def _at(rules: Rules, wanted: tuple[str, int], place: int) -> set[Small]:
    """The constants at a place of a predicate's heads.

    Nothing if some head has a variable there and its rule gives no hint.
    """
    found: set[Small] = set()
    for rule, index in rules.by_signature.get(wanted, ()):
        argument = rule.heads[index][place]
        if is_atom(argument):
            found.add(argument)
        elif not isinstance(argument, tuple):
            found |= _bound(rules, rule, argument, wanted)
    return found


def _bound(rules: Rules, rule: Any, variable: Small, wanted: tuple[str, int]) -> set[Small]:  # noqa: ANN401 - a Rule
    """What facts may bind a head's variable to: those of the first condition that mentions it."""
    for literal in rule.literals:
        if literal.kind == "atom" and signature(literal.goal) != wanted:
            for i, argument in enumerate(literal.goal[1:], 1):
                if argument is variable:
                    heads = [r.heads[k] for r, k in rules.by_signature.get(signature(literal.goal), ())]
                    return {head[i] for head in heads if is_atom(head[i])}
    return set()


def _atoms(goal: Small) -> Iterator[Small]:
    if signature(goal) in ((",", 2), (";", 2), ("\\+", 1), ("not", 1)):
        for side in goal[1:]:
            yield from _atoms(side)
    elif isinstance(goal, tuple):
        yield goal


GOAL = "'plogic goal'"
SEARCH_STEPS = 5_000_000
"""Nodes of the formula that one search may look at: some seconds."""


def prove(request: dict[str, Any]) -> dict[str, Any]:
    """The account of ``plogic.scene.asking.explanations``, as plain data."""
    trust, atoms = bool(request.get("trust")), request["names"]
    names = None if atoms is None else Names.of(atoms)
    _, statements, known = read(request["texts"], names, trust=trust, marked=False)
    goal = _goal(request["goals"][0], "goal", known, statements, names, trust=trust)
    given = [_goal(text, "given", known, statements, names, trust=trust) for text in request["given"]]
    try:
        ground, ask, shown_goal = _ground(statements, goal, given, trust=trust, folder=request.get("folder", "."))
        reply = account(ground, ask, shown_goal, Options(request.get("most", 5), SEARCH_STEPS, names))
    except ProbLogError as error:
        answers_to(request)  # raises the error with file and line, where the program as it was written gives it
        told(error, request["texts"])
    if reply["probability"] == 0.0:
        reply["notes"] += unknown_names(small(goal, {}), ground.rules, names)
    return reply


def _goal(
    text: str, file: str, known: frozenset[str], statements: list[Any], names: Names | None, *, trust: bool
) -> Any:  # noqa: ANN401
    """The goal as ProbLog's term, labels mapped.

    A predicate that nobody defines is answered with what would be right.
    """
    source = parsed(text, file)
    try:
        return goal_in(source, names, known, trust=trust)
    except UnknownPredicateError as error:
        hint = unknown_predicate(source.statements[0], defined_by(statements))
        raise UnknownPredicateError(
            f"{error.reason}{hint}", file=error.file, line=error.line, column=error.column
        ) from None


def _ground(
    statements: list[Any],
    goal: Any,  # noqa: ANN401 - ProbLog's terms are untyped
    given: list[Any],
    *,
    trust: bool,
    folder: str = ".",
) -> tuple[Grounding, Small, Small]:
    """The rewritten program in an engine, with its evidence; the atom to ask for, and the goal."""
    engine, database = engine_for(trust=trust, folder=folder)
    rewriter = Rewriter(defined_by(statements))
    ground = Grounding(engine, database, rewriter.rules)
    for statement in statements:
        number, clauses = rewriter.statement(statement)
        ground.add(number, clauses)
    for i, condition in enumerate(given):
        ground.add(*rewriter.evidence(i, small(condition, {})))
    variables: dict[str, Ref] = {}
    wanted = small(goal, variables)
    ask, clauses = rewriter.goal(wanted, GOAL, [variables[name] for name in variables_of(goal)])
    ground.add(rewriter.count, clauses)
    ground.prepare()
    return ground, ask, wanted
