"""The few built-ins that explanations follow: tests and arithmetic."""

from __future__ import annotations

import math
import operator
from typing import TYPE_CHECKING

from plogic.errors import ProgramError
from plogic.proof.terms import Bindings, Ref, Small, resolved, signature, unify

if TYPE_CHECKING:
    from collections.abc import Callable

BINARY: dict[str, Callable[[float, float], float]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "//": operator.floordiv, "mod": operator.mod,
    "min": min, "max": max, "^": operator.pow, "**": operator.pow,
}  # fmt: skip
UNARY: dict[str, Callable[[float], float]] = {
    "-": operator.neg, "+": operator.pos, "abs": abs, "sqrt": math.sqrt, "exp": math.exp, "log": math.log, "sin": math.sin, "cos": math.cos,
}  # fmt: skip
COMPARE: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt, ">": operator.gt, "=<": operator.le, ">=": operator.ge, "=:=": operator.eq, "=\\=": operator.ne,
}  # fmt: skip
ARITHMETIC_TESTS = frozenset(
    {*((name, 2) for name in COMPARE), ("=", 2), ("\\=", 2), ("==", 2), ("\\==", 2), ("is", 2), ("fail", 0), ("false", 0)}
)


def evaluate(term: Small) -> float:
    """The value of an arithmetic term; raises ProgramError for what is none."""
    name, arity = signature(term)
    try:
        if arity == 2 and name in BINARY:
            return BINARY[name](evaluate(term[1]), evaluate(term[2]))
        if arity == 1 and name in UNARY:
            return UNARY[name](evaluate(term[1]))
    except (ArithmeticError, ValueError) as error:
        raise ProgramError(f"arithmetic: {error}", file="explain") from None
    if isinstance(term, (tuple, Ref)):
        raise ProgramError(f"explanations cannot compute {name}/{arity}", file="explain")
    return float(term) if not isinstance(term, int) else term


def holds(goal: Small, bindings: Bindings) -> bool:
    """Whether a test holds; = and is/2 bind."""
    name, _ = signature(goal)
    if name in COMPARE:
        return COMPARE[name](evaluate(goal[1]), evaluate(goal[2]))
    if name in ("fail", "false"):
        return False
    if name in ("=", "\\="):
        return unify(goal[1], goal[2], bindings) == (name == "=")
    if name == "is":
        return unify(goal[1], evaluate(goal[2]), bindings)
    return (resolved(goal[1], bindings) == resolved(goal[2], bindings)) == (name == "==")
