"""``findall/3``, ``all/3`` and ``all_or_none/3``: ProbLog's own, but what has too many lists is refused at once.

Where n answers may each hold or not, ProbLog writes 2^n lists. ``findall/3`` collects an answer once for each of its
proofs, so n is the number of proofs; ``all/3`` and ``all_or_none/3`` collect it once, so n is the number of answers.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from math import prod
from typing import Any

from problog import engine_builtin
from problog.engine_stack import SimpleProbabilisticBuiltIn
from problog.errors import GroundingError
from problog.formula import LogicFormula
from problog.logic import Term

from plogic.logic.safety.closest import COUNTED

MOST = 14
"""Of what may hold or not, in one list: 16,384 lists take some ten seconds; those of 16 do not fit into 2 GB."""
WAYS = 100_000
"""Proofs of one answer that are looked at, the certain ones too: a second."""
_LISTS, _PROOFS = engine_builtin._select_sublist, LogicFormula.enumerate_branches  # noqa: SLF001 - no other way in


class TooManyListsError(GroundingError):  # type: ignore[misc]
    """A goal collects so many answers, or proofs, that its lists cannot be written."""


class _TooManyError(Exception):
    """``number``: of proofs of one answer, or of answers."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def guard(engine: Any) -> None:  # noqa: ANN401 - an engine of ProbLog's
    """Give an engine these three, held to what can be written."""
    for name, kind in (("findall", "proofs"), ("all", "answers"), ("all_or_none", "answers")):
        collect = partial(_collected, getattr(engine_builtin, f"_builtin_{name}"), kind)
        engine.add_builtin(name, 3, SimpleProbabilisticBuiltIn(collect))


def _collected(
    collect: Callable[..., list[Any]],
    kind: str,
    pattern: Any,  # noqa: ANN401 - terms of ProbLog's
    goal: Any,  # noqa: ANN401
    result: Any,  # noqa: ANN401
    **options: Any,  # noqa: ANN401
) -> list[Any]:
    try:
        with _counted():
            return collect(pattern, goal, result, **options)
    except _TooManyError as error:
        raise _told(goal, error.number, kind, options) from None


@contextmanager
def _counted() -> Iterator[None]:
    """Within it ProbLog counts before it writes lists, and while it looks at proofs."""
    before = engine_builtin._select_sublist, LogicFormula.enumerate_branches  # noqa: SLF001
    engine_builtin._select_sublist, LogicFormula.enumerate_branches = _lists, _proofs  # noqa: SLF001
    try:
        yield
    finally:
        engine_builtin._select_sublist, LogicFormula.enumerate_branches = before  # noqa: SLF001


def _lists(found: list[tuple[Any, Any]], target: Any) -> Iterator[Any]:  # noqa: ANN401 - a formula of ProbLog's
    unsure = sum(node not in (target.TRUE, target.FALSE) for _, node in found)
    if unsure > MOST:
        raise _TooManyError(unsure)
    return iter(_LISTS(found, target))


def _proofs(formula: Any, node: Any, anc: tuple[Any, ...] = ()) -> Iterator[Any]:  # noqa: ANN401
    """The proofs of an answer, once they are counted; ``anc``: the nodes above it, by the name that ProbLog uses."""
    if not anc:
        every, certain = _ways(formula, node, {})
        if every - certain > MOST or every > WAYS:
            raise _TooManyError(every if every > WAYS else every - certain)
    return iter(_PROOFS(formula, node, anc=anc))


def _ways(formula: Any, node: Any, known: dict[int, tuple[int, int]]) -> tuple[int, int]:  # noqa: ANN401
    """How many proofs a node has, and how many that are certain; one that is being counted, on a cycle, has one."""
    if not node or node < 0:  # true, false or a negation, which is not looked into
        return 1, int(node == formula.TRUE)
    if node not in known:
        known[node] = 1, 0
        found = formula.get_node(node)
        kind = type(found).__name__
        if kind != "atom":
            combined = prod if kind == "conj" else sum
            every, certain = zip(*(_ways(formula, child, known) for child in found.children), strict=True)
            known[node] = combined(every), combined(certain)
    return known[node]


def _told(goal: Any, number: int, kind: str, options: dict[str, Any]) -> TooManyListsError:  # noqa: ANN401
    """What to say of so many."""
    what = f"{goal} has {number} {kind} that may each hold or not, which make 2^{number} lists; at most 2^{MOST} are written"
    if kind == "proofs":
        what = f"findall/3 collects an answer once for each proof: {what}; all_or_none/3 collects each answer once"
    if options["database"].find(Term("number_of_objects", None)) is not None:
        what += f"; {COUNTED}"
    origin = options.get("call_origin") or (None, None)
    return TooManyListsError(what, options["database"].lineno(origin[1]) if origin[1] is not None else None)
