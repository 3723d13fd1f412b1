"""``findall/3``, ``all/3`` and ``all_or_none/3``: as ProbLog's, but what has too many lists is refused at once.

Where n answers may each hold or not, ProbLog writes 2^n lists. ``findall/3`` collects an answer once for each of its
proofs, so n is the number of proofs; ``all/3`` and ``all_or_none/3`` collect it once, so n is the number of answers.
"""

from collections.abc import Iterator
from math import prod
from typing import Any

from problog.engine_builtin import IndirectCallCycleError, _select_sublist, check_mode
from problog.engine_stack import SimpleProbabilisticBuiltIn
from problog.engine_unify import UnifyError, substitute_simple, unify_value
from problog.errors import GroundingError
from problog.logic import Clause, Term, list2term

from plogic.logic.safety.closest import COUNTED

MOST = 14
"""Of what may hold or not, in one list: 16,384 lists take some ten seconds; those of 16 do not fit into 2 GB."""
WAYS = 100_000
"""Proofs that are written out, the certain ones too: a second."""


class TooManyListsError(GroundingError):  # type: ignore[misc]
    """A goal collects so many answers, or proofs, that its lists cannot be written."""


def guard(engine: Any) -> None:  # noqa: ANN401 - an engine of ProbLog's
    """Give an engine these three in place of its own."""
    for name, collect in (("findall", _findall), ("all", _all), ("all_or_none", _all_or_none)):
        engine.add_builtin(name, 3, SimpleProbabilisticBuiltIn(collect))


def _findall(pattern: Any, goal: Any, result: Any, **options: Any) -> list[Any]:  # noqa: ANN401 - ProbLog's calls
    """Collect an answer once for each proof, in the order of ProbLog's."""
    target = options["target"]
    proofs = target.__class__(keep_order=True, keep_all=True, keep_duplicates=True)
    mode = _mode(pattern, goal, result, options)
    try:
        found = _called(pattern, goal, {**options, "target": proofs})
    except RuntimeError:
        origin = options.get("call_origin") or (None, None)
        raise IndirectCallCycleError(options["database"].lineno(origin[1])) from None
    ways: dict[int, int] = {}
    total = sum(_ways(proofs, node, ways) for _, node in found)
    if total > WAYS:
        raise _too_many(goal, total, "proofs", options)
    keep_all, target.keep_all = target.keep_all, False
    made: dict[int, Any] = {}
    rows = [(place, answer, key) for answer, node in found for place, key in _copied(proofs, node, target, made)]
    target.keep_all = keep_all
    collected = [(answer, key) for _, answer, key in sorted(rows, key=lambda row: row[0])]
    return _lists(collected, (pattern, goal, result), "proofs", mode, options)


def _all(pattern: Any, goal: Any, result: Any, **options: Any) -> list[Any]:  # noqa: ANN401 - ProbLog's calls
    """Collect each answer once; without any, fail."""
    return [row for row in _all_or_none(pattern, goal, result, **options) if str(row[0][2]) != "[]"]


def _all_or_none(pattern: Any, goal: Any, result: Any, **options: Any) -> list[Any]:  # noqa: ANN401 - ProbLog's calls
    mode = _mode(pattern, goal, result, options)
    return _lists(_called(pattern, goal, options), (pattern, goal, result), "answers", mode, options)


def _mode(pattern: Any, goal: Any, result: Any, options: dict[str, Any]) -> int:  # noqa: ANN401 - terms of ProbLog's
    """0 where the result is a variable; raises where the call has no such mode."""
    rest = {key: value for key, value in options.items() if key not in ("target", "engine", "context")}
    return int(check_mode((pattern, goal, result), ["*cv", "*cl"], **rest))


def _called(pattern: Any, goal: Any, options: dict[str, Any]) -> list[tuple[Any, Any]]:  # noqa: ANN401 - terms
    """The answers to a goal, each as the pattern has it and with its node."""
    engine, database = options["engine"], options["database"].extend()
    head = Term(engine.get_non_cache_functor(), pattern, *goal.variables())
    database += Clause(head, goal)
    rest = {key: value for key, value in options.items() if key not in ("database", "engine", "context")}
    return [
        (answer[0], node)
        for answer, node in engine.call(substitute_simple(head, _Open()), subcall=True, database=database, **rest)
    ]


class _Open:
    """Leaves every variable open."""

    def __getitem__(self, _: Any) -> None:  # noqa: ANN401 - a variable of ProbLog's
        return None


def _lists(
    found: list[tuple[Any, Any]],
    call: tuple[Any, Any, Any],
    kind: str,
    mode: int,
    options: dict[str, Any],
) -> list[Any]:
    """Each list that may come about, as arguments of the call, and its node."""
    pattern, goal, result = call
    target = options["target"]
    unsure = sum(node not in (target.TRUE, target.FALSE) for _, node in found)
    if unsure > MOST:
        raise _too_many(goal, unsure, kind, options)
    rows = []
    for answers, nodes in _select_sublist(found, target):
        node = target.add_and(nodes)
        made = list2term(list(answers))
        if node is not None and (mode == 0 or (made := _unified(made, result)) is not None):
            rows.append(((pattern, goal, made), node))
    return rows


def _unified(made: Any, result: Any) -> Any | None:  # noqa: ANN401 - terms of ProbLog's
    try:
        return unify_value(made, result, {})
    except UnifyError:
        return None


def _copied(proofs: Any, node: Any, target: Any, made: dict[int, Any]) -> Iterator[tuple[int, Any]]:  # noqa: ANN401 - ProbLog's formulas
    """Each proof of a node: its place in the order of proofs, and its key in the formula of the program."""
    for place, leaves in proofs.enumerate_branches(node):
        keys = [_copy(proofs, leaf, target, made) for leaf in leaves]
        yield place, target.add_and(keys) if keys else target.FALSE


def _copy(proofs: Any, key: Any, target: Any, made: dict[int, Any]) -> Any:  # noqa: ANN401 - ProbLog's formulas
    """As ProbLog's ``copy_node``, but what many nodes share is copied once."""
    if not key:
        return key
    if abs(key) not in made:
        node = proofs.get_node(abs(key))
        kind = type(node).__name__
        if kind == "atom":
            made[abs(key)] = target.add_atom(*node)
        else:
            children = [_copy(proofs, child, target, made) for child in node.children]
            made[abs(key)] = target.add_and(children) if kind == "conj" else target.add_or(children)
    return made[abs(key)] if key > 0 else target.negate(made[abs(key)])


def _ways(proofs: Any, key: Any, known: dict[int, int]) -> int:  # noqa: ANN401 - a formula of ProbLog's
    """How many proofs ``enumerate_branches`` writes out; a node that is counted already, on a cycle, has one."""
    if not key or key < 0:
        return 1
    if key not in known:
        known[key] = 1
        node = proofs.get_node(key)
        if type(node).__name__ != "atom":
            of = [_ways(proofs, child, known) for child in node.children]
            known[key] = prod(of) if type(node).__name__ == "conj" else sum(of)
    return known[key]


def _too_many(goal: Any, number: int, kind: str, options: dict[str, Any]) -> TooManyListsError:  # noqa: ANN401
    what = f"{goal} has {number} {kind} that may each hold or not, which make 2^{number} lists; at most 2^{MOST} are written"
    if kind == "proofs":
        what = f"findall/3 collects an answer once for each proof: {what}; all_or_none/3 collects each answer once"
    if options["database"].find(Term("number_of_objects", None)) is not None:
        what += f"; {COUNTED}"
    origin = options.get("call_origin") or (None, None)
    return TooManyListsError(what, options["database"].lineno(origin[1]) if origin[1] is not None else None)
