"""What would be right, where a goal names a predicate or a constant that the program does not know."""

from __future__ import annotations

from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

from problog.logic import Term

from plogic.logic.proof.terms import Small, is_atom, signature
from plogic.logic.proof.written_terms import text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.logic.proof.rule_base import Rules
    from plogic.logic.safety.atoms import Names

LISTED = 8


def unknown_predicate(goal: Any, defined: set[tuple[str, int]]) -> str:  # noqa: ANN401 - a term of ProbLog's
    """``; present/1 is known``, or the closest names."""
    wanted = next((s for s in _called(goal) if s not in defined), None)
    if wanted is None:
        return ""
    arities = sorted(arity for name, arity in defined if name == wanted[0])
    if arities:
        return f"; {', '.join(f'{wanted[0]}/{arity}' for arity in arities)} is known"
    public = sorted({name for name, _ in defined if not name.startswith("_")})
    close = get_close_matches(wanted[0], public, n=3, cutoff=0.6)
    names = [f"{name}/{arity}" for name in close for known, arity in sorted(defined) if known == name]
    return f"; the closest that is known: {', '.join(names)}" if names else ""


def _called(goal: Any) -> Iterator[tuple[str, int]]:  # noqa: ANN401 - a term of ProbLog's
    if not isinstance(goal, Term):
        return
    if goal.signature in (",/2", ";/2", "\\+/1", "not/1"):
        for argument in goal.args:
            yield from _called(argument)
    else:
        yield str(goal.functor).strip("'"), goal.arity


def unknown_names(goal: Small, rules: Rules, names: Names | None) -> list[str]:
    """One sentence for each constant of the goal that occurs nowhere at its place, though the program has others there.

    A hypothesis is no unknown name, though no fact at this place speaks of it.
    """
    notes = []
    hypotheses = _at(rules, ("hypothesis", 2), 1)
    for atom in _atoms(goal):
        for i, argument in enumerate(atom[1:], 1):
            known = _at(rules, signature(atom), i)
            if is_atom(argument) and isinstance(argument, tuple) and known and argument not in known | hypotheses:
                notes.append(_note(atom, i, argument, sorted(text(k, names) for k in known), names))
    return notes


def _note(atom: Small, place: int, argument: Small, known: list[str], names: Names | None) -> str:
    said = text(argument, names)
    close = get_close_matches(said, known, n=3, cutoff=0.5)
    listed = close or known[:LISTED]
    more = "" if close or len(known) <= LISTED else f", ... ({len(known)} in all)"
    name, arity = signature(atom)
    which = "closest are" if close else "there are"
    return f"{said} is unknown as argument {place} of {name}/{arity}; {which} {', '.join(listed)}{more}"


def _at(rules: Rules, wanted: tuple[str, int], place: int) -> set[Small]:
    """The constants at a place of a predicate's heads; nothing if some head has a variable there and its rule gives no hint."""
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
