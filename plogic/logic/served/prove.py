"""One request for explanations, served in the child process: why a goal holds, why not, and what was missing.

Where a goal names a predicate or a constant that the program does not know, the closest known ones are told.
"""

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from problog.errors import ProbLogError

from plogic.logic.answers.answer import answers_to
from plogic.logic.grounding.load import goal_in, parsed, read
from plogic.logic.grounding.load import variables as variables_of
from plogic.logic.proof.goal_account import Options, account
from plogic.logic.proof.ground_proofs import Grounding
from plogic.logic.proof.rewrite import Rewriter, Rule, Rules, defined_by
from plogic.logic.proof.terms import Ref, Small, is_atom, signature, small, text
from plogic.logic.safety.atoms import Names
from plogic.logic.safety.guarded_engine import engine_for, told

MOST_LISTED, DEEP = 8, 20
Above = frozenset[tuple[tuple[str, int], int]]


def unknown_names(goal: Small, rules: Rules, names: Names | None) -> list[str]:
    """One sentence for each constant of the goal that occurs nowhere at its place, though the program has others there.

    A hypothesis is no unknown name, though no fact at this place speaks of it.
    """
    hypotheses = _at(rules, ("hypothesis", 2), 1) or set()
    places = (
        (atom, i, argument, _known(rules, signature(atom), i, argument))
        for atom in _atoms(goal)
        for i, argument in enumerate(atom[1:], 1)
        if isinstance(argument, tuple) and (is_atom(argument) or signature(argument) == ("/", 2))
    )
    return [
        _note(atom, i, argument, sorted(text(k, names) for k in known), names)
        for atom, i, argument, known in places
        if known and argument not in known | hypotheses
    ]


def _known(rules: Rules, wanted: tuple[str, int], place: int, argument: Small) -> set[Small] | None:
    """What may stand at a place: by facts; of a name that stands nowhere else in the program, by rules too."""
    near = _at(rules, wanted, place)
    found = [head for rule in rules.by_number.values() for head in rule.heads]
    if near is not None or any(argument in head[1:] for head in found):
        return near
    return _at(rules, wanted, place, DEEP)


def _note(atom: Small, place: int, argument: Small, known: list[str], names: Names | None) -> str:
    said = text(argument, names)
    if not is_atom(argument) and f"'{said}'" in known:
        return f"{said} is no name: one with a / is written in quotes, '{said}'"
    close = get_close_matches(said, known, n=3, cutoff=0.5)
    listed = close or known[:MOST_LISTED]
    more = "" if close or len(known) <= MOST_LISTED else f", ... ({len(known)} in all)"
    name, arity = signature(atom)
    which = "closest are" if close else "there are"
    return f"{said} is unknown as argument {place} of {name}/{arity}; {which} {', '.join(listed)}{more}"


def _at(
    rules: Rules, wanted: tuple[str, int], place: int, levels: int = 0, above: Above = frozenset()
) -> set[Small] | None:
    """The constants that may stand at a place of a predicate's heads; None if some head has anything there.

    ``above``: the places that are looked at already, ``levels`` of them at most.
    """
    found: set[Small] = set()
    if wanted in rules.opaque:
        return None
    for rule, index in rules.by_signature.get(wanted, ()):
        argument = rule.heads[index][place]
        if is_atom(argument):
            found.add(argument)
        elif not isinstance(argument, tuple):
            here = above | {(wanted, place)}
            bound = _bound(rules, rule, argument, levels, here) if len(here) <= levels else None
            if bound is None:
                return None
            found |= bound
    return found


def _bound(rules: Rules, rule: Rule, variable: Small, levels: int, above: Above) -> set[Small] | None:
    """What the first condition that says it may bind a head's variable to."""
    for literal in rule.literals:
        for i, argument in enumerate(literal.ask[1:], 1):
            if literal.kind in ("atom", "part") and argument is variable:
                if (signature(literal.ask), i) in above:
                    return set()
                if (found := _at(rules, signature(literal.ask), i, levels, above)) is not None:
                    return found
    return None


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
    goal = goal_in(parsed(request["goals"][0], "goal"), names, known, trust=trust)
    given = [goal_in(parsed(text, "given"), names, known, trust=trust) for text in request["given"]]
    try:
        ground, ask, shown_goal = _ground(statements, goal, given, trust=trust, folder=request.get("folder", "."))
        reply = account(ground, ask, shown_goal, Options(request.get("most", 5), SEARCH_STEPS, names))
    except ProbLogError as error:
        answers_to(request)  # raises the error with file and line, where the program as it was written gives it
        told(error, request["texts"])
    if reply["probability"] == 0.0:
        reply["notes"] += unknown_names(small(goal, {}), ground.rules, names)
    return reply


def notes(request: dict[str, Any]) -> dict[str, Any]:
    """``{"notes": [...]}``: the unknown names of a goal, of a program that is read and not run."""
    trust, atoms = bool(request.get("trust")), request["names"]
    names = None if atoms is None else Names.of(atoms)
    _, statements, known = read(request["texts"], names, trust=trust, marked=False)
    rewriter = Rewriter(defined_by(statements))
    for statement in statements:
        rewriter.statement(statement)
    goal = goal_in(parsed(request["goals"][0], "goal"), names, known, trust=trust)
    return {"notes": unknown_names(small(goal, {}), rewriter.rules, names)}


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
