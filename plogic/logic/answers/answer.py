"""Answers of a program, in this process: P(query | evidence) of each query, counted the cheapest way.

For programs of strangers use ``plogic.scene.asking.query.answers``: it works in a process of its own, with limits.
"""

from __future__ import annotations

import json
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from problog.logic import And, Constant, Not, Or, Term, Var

from plogic.logic.answers.ways import counted
from plogic.logic.grounding.load import Request, ground, request_from, variables, with_something_asked
from plogic.logic.safety.mapping import shown
from sensing.uncollected import uncollected

if TYPE_CHECKING:
    from collections.abc import Iterable

    from plogic.logic.dnnf.compiled import Compiled
    from plogic.logic.grounding.ground_program import Ground
    from plogic.logic.safety.atoms import Names


def answers_of_text(text: str) -> dict[str, float]:
    """P(query | evidence) of each of the program's own query/1, by its text; raises ProgramError, InconsistentError.

    In this process and without limits of time and memory: for benchmarks and tests, of programs known to end.
    """
    document = {"texts": [{"text": text, "file": "program"}]}
    return {goal: p for goals in answers_to(document) for goal, p in goals}


def answers_to(document: dict[str, Any]) -> list[list[tuple[str, float]]]:
    """One list of ``(goal, probability)`` per goal of a request; without goals, one for the program's own query/1."""
    return grouped(*_answered(_asked(document)))


@lru_cache(maxsize=4)
def _answered(text: str) -> tuple[Request, Ground, list[float]]:
    with uncollected():
        request = request_from(json.loads(text))
        return request, *counted(request)


def prepared(document: dict[str, Any], *, ask_something: bool = False) -> tuple[Request, Compiled]:
    """The request with its program compiled; the last few are remembered, for processes that are asked the same again.

    With ``ask_something`` a program that asks nothing is asked for all that it gives a probability.
    """
    return _prepared(_asked(document), ask_something)


def _asked(document: dict[str, Any]) -> str:
    """What a request asks, as a cache's key."""
    keys = ("texts", "goals", "given", "names", "trust", "folder")
    return json.dumps({key: document[key] for key in keys if key in document}, sort_keys=True)


@lru_cache(maxsize=4)
def _prepared(text: str, ask_something: bool) -> tuple[Request, Compiled]:  # noqa: FBT001 - a cache's key
    from plogic.logic.dnnf.compiled import compiled

    with uncollected():
        request = request_from(json.loads(text))
        request = with_something_asked(request) if ask_something else request
        return request, compiled(ground(request))


def grouped(request: Request, found: Ground, values: Iterable[Any]) -> list[list[tuple[str, Any]]]:
    """What was found for each query, by goal and as users write it.

    A goal with variables is answered where it can hold.
    """
    results = {name: (value, literal) for (name, literal), value in zip(found.asked, values, strict=True)}
    if not request.goals:
        return [[(shown(term, request.names), value) for term, (value, _) in results.items()]]
    return [_answers(results, head, goal, request.names) for head, goal in request.goals]


def _answers(results: dict[Term, tuple[Any, Any]], head: Term, goal: Any, names: Names | None) -> list[tuple[str, Any]]:  # noqa: ANN401
    """Each substitution of the goal with its value; a ground goal has exactly one."""
    named = variables(goal)
    found = [
        (term, value)
        for term, (value, literal) in results.items()
        if term.functor == head.functor and (not named or literal is not None)
    ]
    if named:
        found = [
            (term, value)
            for term, value in found
            if value != 0 and not any(a is None or isinstance(a, int) for a in term.args)
        ]
    return [(shown(_bound(goal, dict(zip(named, term.args, strict=True))), names), value) for term, value in found]


def _bound(goal: Any, values: dict[str, Any]) -> Any:  # noqa: ANN401 - terms of ProbLog's
    if isinstance(goal, Var):
        return values.get(goal.name, goal)
    if isinstance(goal, Constant) or not isinstance(goal, Term):
        return goal
    arguments = [_bound(argument, values) for argument in goal.args]
    if isinstance(goal, (And, Or)):
        return type(goal)(*arguments)
    return Not(goal.functor, arguments[0]) if isinstance(goal, Not) else goal.with_args(*arguments)
