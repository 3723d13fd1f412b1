r"""Spells out the cycle that makes a program's negation depend on itself: ``a :- \+ b (u.pl:3), b :- a (u.pl:4)``.

Found among the clauses as they are written: an edge leads from a clause's head to each goal of its body, and the
shortest way back from a negated goal to its head is the cycle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from problog.logic import And, AnnotatedDisjunction, Clause, Constant, Not, Or, Term, Var

from plogic.logic.safety.allowlist import LIBRARY_META, META
from plogic.logic.safety.check import heads, is_directive

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from plogic.logic.safety.check import Source

NEGATED = frozenset({"\\+/1", "not/1", "forall/2"})
COLLECTED = frozenset({"findall/3", "all/3", "all_or_none/3", "aggregate/5"})


@dataclass(frozen=True)
class Edge:
    """``head :- literal (file:line)``: signatures of both, what the goal stands under, and how it is written."""

    head: str
    goal: str
    under: frozenset[str]
    text: str
    line: tuple[str, int | None]


def spelt_cycle(sources: Iterable[Source], place: dict[str, Any], through: frozenset[str]) -> str:
    """The shortest cycle with an edge under one of ``through``, at best one at ``place``; empty where the text shows none."""
    edges = list(_edges(sources))
    wanted = (place.get("file"), place.get("line"))
    marked = sorted((edge for edge in edges if edge.under & through), key=lambda edge: edge.line != wanted)
    ways: list[list[Edge]] = [[edge, *way] for edge in marked if (way := _way(edges, edge.goal, edge.head)) is not None]
    if not ways:
        return ""
    here = [way for way in ways if way[0].line == wanted]
    return ", ".join(edge.text for edge in min(here or ways, key=len))


def _way(edges: list[Edge], start: str, end: str) -> list[Edge] | None:
    """The shortest way from one predicate to another; the empty one from a predicate to itself."""
    ways: dict[str, list[Edge]] = {start: []}
    queue = [start]
    for here in queue:
        if here == end:
            return ways[here]
        for edge in edges:
            if edge.head == here and edge.goal not in ways:
                ways[edge.goal] = [*ways[here], edge]
                queue.append(edge.goal)
    return None


def _edges(sources: Iterable[Source]) -> Iterator[Edge]:
    for source in sources:
        for statement in source.statements:
            if isinstance(statement, (Clause, AnnotatedDisjunction)) and not is_directive(statement):
                for goal, under, written in _goals(statement.body, frozenset(), None):
                    place = source.place(goal)
                    line = (source.file, place.get("line"))
                    at = source.file if line[1] is None else f"{source.file}:{line[1]}"
                    for head in heads(statement):
                        yield Edge(
                            head.signature,
                            goal.signature,
                            under,
                            f"{head.with_probability()} :- {_written(written)} ({at})",
                            line,
                        )


def _goals(goal: Any, under: frozenset[str], outer: Any) -> Iterator[tuple[Any, frozenset[str], Any]]:  # noqa: ANN401 - terms of ProbLog's
    """Each goal of a body, what it stands under, and the literal that shows it (with its negation)."""
    if isinstance(goal, (Var, Constant)) or not isinstance(goal, Term):
        return
    positions = META.get(goal.signature, LIBRARY_META.get(goal.signature, ()))
    if isinstance(goal, (And, Or, Not)) or any(added == 0 for _, added in positions):
        inner = under if isinstance(goal, (And, Or)) else under | {"\\+/1" if isinstance(goal, Not) else goal.signature}
        shown = outer if isinstance(goal, (And, Or)) else outer or goal
        for position, _ in positions or [(i, 0) for i in range(len(goal.args))]:
            yield from _goals(goal.args[position], inner, shown)
    else:
        yield goal, under, outer if under & (NEGATED | COLLECTED) and outer is not None else goal


def _written(literal: Any) -> str:  # noqa: ANN401 - a term of ProbLog's
    if not isinstance(literal, Not):
        return str(literal)
    inner = literal.args[0]
    return f"{literal.functor} ({inner})" if isinstance(inner, (And, Or)) else f"{literal.functor} {inner}"
