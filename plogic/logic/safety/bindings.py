"""Bindings of a goal's variables in one of its answers: ``bindings("object(H, T)", "object(h1, 'big box')")`` → ``{"H": "h1", "T": "big box"}``."""

from __future__ import annotations

from typing import Any

from plogic.base.errors import ProgramError

Value = str | int | float
"""A constant: a name without its quotes, or a number; any other term is given as its text."""


def bindings(goal: str, answer: str) -> dict[str, Value]:
    """Return the value of each named variable of ``goal``, in the order in which they appear.

    None where ``answer`` is no instance of it.
    """
    from plogic.logic.safety.author import load_problog

    load_problog()
    from plogic.logic.safety.check import parse

    try:
        (asked,), (found,) = (parse(f"{text.strip().removesuffix('.')}.").statements for text in (goal, answer))
    except (ProgramError, ValueError):
        return {}
    return _matched(asked, found)


def _matched(asked: Any, found: Any) -> dict[str, Value]:  # noqa: ANN401 - terms of ProbLog's
    """Match two terms from the outside in; the first place of a variable decides."""
    from problog.logic import Constant, Term, Var

    if isinstance(asked, Var):
        return {} if asked.name.startswith("_") or isinstance(found, Var) else {asked.name: _value(found)}
    if not isinstance(asked, Term) or isinstance(asked, Constant) or not isinstance(found, Term):
        return {}
    if asked.arity != found.arity:
        return {}
    result: dict[str, Value] = {}
    for one, other in zip(asked.args, found.args, strict=True):
        result = _matched(one, other) | result if not result else result | _new(_matched(one, other), result)
    return result


def _new(some: dict[str, Value], known: dict[str, Value]) -> dict[str, Value]:
    return {name: value for name, value in some.items() if name not in known}


def _value(term: Any) -> Value:  # noqa: ANN401 - a term of ProbLog's
    from problog.logic import Constant

    from plogic.logic.safety.mapping import label_of

    label = label_of(term)
    if label is not None:
        return label
    if isinstance(term, Constant) and isinstance(term.functor, (int, float)):
        return term.functor
    return str(term)
