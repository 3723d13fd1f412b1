"""Which predicates of a program may call themselves without end: what is said beside a limit that a run came to.

Of some it is certain before any run (``surely_endless``): the clause takes any arguments, and calls itself with a
larger or smaller one before any condition could stop it.

Nobody knows whether a recursion ends. One is suspected where the call that leads back has an argument that grows: a
term around a variable, or a number that the clause has computed. Calls whose arguments only move about are answered
from a table and end.

* ``surely_endless("n(N) :- M is N - 1, n(M).", "u.pl")``: a line on that call
* ``endless(texts, goals)``: ``"recursion without end? count/1 calls itself: count(N1) (u.pl:3:24)"``
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from problog.logic import And, AnnotatedDisjunction, Clause, Constant, Term, Var

from plogic.base.errors import ProgramError
from plogic.logic.safety.check import Source, glanced, heads, is_directive
from plogic.logic.safety.guarded_engine import goals_under

SHOWN = 3
"""Calls that are named; the rest is counted."""


class Call(NamedTuple):
    """``head`` calls ``goal``, signatures both, as ``text`` at ``place``; ``grows``: with a larger argument."""

    head: str
    goal: str
    text: str
    place: str
    grows: bool


def endless(texts: Sequence[dict[str, str]], goals: Sequence[str], *, grown: bool = True) -> str:
    """A sentence on the calls that may lead to themselves without end, of those that the goals reach; '' of none.

    Without ``grown`` those are told, too, whose arguments do not grow. Without goals it is the program's ``query/1``.
    Of texts that cannot be read, or not quickly, nothing is said.
    """
    sources = [glanced(item["text"], item["file"]) for item in texts]
    questions = [glanced(f"asked :- {goal.rstrip(' .')}.", "goal") for goal in goals]
    if None in sources or None in questions:
        return ""
    calls = [call for source in sources if source is not None for call in _calls(source)]
    asked = {head.signature for source in questions if source is not None for head in _atoms(source)}
    calls_of: dict[str, list[Call]] = {}
    for call in calls:
        calls_of.setdefault(call.head, []).append(call)
    start = asked or {call.goal for call in calls if call.head in ("query/1", "evidence/1", "evidence/2")}
    within = _reached(calls_of, start or set(calls_of))
    back = [call for call in calls if call.head in within and call.head in _reached(calls_of, {call.goal})]
    found = [call for call in back if call.grows] or ([] if grown else back)
    if not found:
        return ""
    told = [f"{call.head} {_how(call)}: {call.text} ({call.place})" for call in found[:SHOWN]]
    more = f"; and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return f"recursion without end? {'; '.join(told)}{more}"


def surely_endless(text: str, file: str) -> list[str]:
    """A line, with its place, on each call of a clause to itself that no run of it can end.

    A text that cannot be read, or not quickly, is told of elsewhere.
    """
    source = glanced(text, file)
    if source is None:
        return []
    clauses = [s for s in source.statements if isinstance(s, (Clause, AnnotatedDisjunction)) and not is_directive(s)]
    found = [(head, call) for clause in clauses for head in heads(clause) for call in _unstopped(head, clause.body)]
    return [
        f"{ProgramError(f'{head.signature} calls itself without end, whatever it is asked: {call}', **source.place(call))}"
        "; a condition before the call ends it, such as N > 0"
        for head, call in found
    ]


def _unstopped(head: Any, body: Any) -> Iterator[Any]:  # noqa: ANN401 - terms of ProbLog's
    """The call of a clause to itself before which nothing can fail, with an argument that never comes back."""
    places = {str(argument): i for i, argument in enumerate(head.args)}
    if len(places) < len(head.args) or not all(isinstance(argument, Var) for argument in head.args):
        return
    steps = dict[str, str]()
    while body is not None:
        goal, body = (body.op1, body.op2) if isinstance(body, And) else (body, None)
        if isinstance(goal, (Var, Constant)):
            return
        if goal.signature == head.signature:
            if any(_beyond(argument, i, places, steps) for i, argument in enumerate(goal.args)):
                yield goal
            return
        if goal.signature != "is/2" or not isinstance(goal.args[0], Var):
            return
        steps[str(goal.args[0])] = _stepped(goal.args[1])


def _stepped(value: Any) -> str:  # noqa: ANN401 - a term of ProbLog's
    """``N`` of ``N + 1``, ``1 + N`` and ``N - 1``: what a number other than 0 is added to; else ''."""
    if isinstance(value, (Var, Constant)) or value.signature not in ("'+'/2", "'-'/2", "+/2", "-/2"):
        return ""
    one, other = value.args if isinstance(value.args[0], Var) or "-" in value.signature else reversed(value.args)
    return str(one) if isinstance(one, Var) and isinstance(other, Constant) and other.compute_value() else ""


def _beyond(argument: Any, place: int, places: dict[str, int], steps: dict[str, str]) -> bool:  # noqa: ANN401 - a term
    """Whether an argument of the call is that of the head with something added, or a term around it."""
    if isinstance(argument, Var):
        return places.get(steps.get(str(argument), "")) == place
    return _around(argument) and any(places.get(str(variable)) == place for variable in argument.variables())


def _how(call: Call) -> str:
    return "calls itself" if call.goal == call.head else f"calls itself by way of {call.goal}"


def _reached(calls_of: dict[str, list[Call]], start: set[str]) -> set[str]:
    seen, stack = set[str](), sorted(start)
    while stack:
        top = stack.pop()
        if top not in seen:
            seen.add(top)
            stack += [call.goal for call in calls_of.get(top, ())]
    return seen


def _atoms(source: Source) -> Iterator[Any]:
    for statement in source.statements:
        yield from (goal for goal, _, _ in goals_under(statement.body, frozenset(), None))


def _calls(source: Source) -> Iterator[Call]:
    for statement in source.statements:
        if is_directive(statement):
            continue
        if isinstance(statement, (Clause, AnnotatedDisjunction)):
            body = [goal for goal, _, _ in goals_under(statement.body, frozenset(), None)]
            computed = {str(goal.args[0]) for goal in body if goal.signature == "is/2"}
            yield from (_call(source, head, goal, computed) for head in heads(statement) for goal in body)
        else:
            asked = [head for head in heads(statement) if head.signature in ("query/1", "evidence/1", "evidence/2")]
            for head in asked:
                goals = (goal for goal, _, _ in goals_under(head.args[0], frozenset(), None))
                yield from (_call(source, head, goal, set()) for goal in goals)


def _call(source: Source, head: Any, goal: Any, computed: set[str]) -> Call:  # noqa: ANN401 - terms of ProbLog's
    place = source.place(goal)
    at = ":".join(str(place[key]) for key in ("file", "line", "column") if place.get(key) is not None)
    known = {str(argument) for argument in head.args}
    grows = any(str(a) in computed or (_around(a) and str(a) not in known) for a in goal.args)
    return Call(head.signature, goal.signature, str(goal), at, grows)


def _around(argument: Any) -> bool:  # noqa: ANN401 - a term of ProbLog's
    """Whether a term is built around a variable."""
    if isinstance(argument, (Var, Constant)) or not isinstance(argument, Term):
        return False
    return bool(argument.variables())
