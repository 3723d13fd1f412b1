"""What a user may add to a program: rules, choices, evidence and constraints (§9.7), checked before anything runs.

* ``constraint(Name) :- Body.``: there is no world in which Body holds; Name is any term, ``too_near(X, Y)``
* ``P::constraint_may_fail(Name).``: with probability P the constraint may be violated

``LAW`` says so in ProbLog. ``mistakes`` are those that only such a text can make: ``check_added`` tells them together
with all others.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

from problog.logic import And, AnnotatedDisjunction, Clause, Constant, Or, Term, Var

from plogic.base.errors import NegativeCycleError, ProgramError
from plogic.logic.safety.allowlist import LOADERS, META, SPECIAL_HEADS
from plogic.logic.safety.atoms import Names
from plogic.logic.safety.check import Mistake, Source, check_source, glanced, heads, is_directive, with_place
from plogic.logic.safety.mapping import label_of, shown
from plogic.logic.safety.slips import DECLARED

LAW = r"""
% No world violates a constraint that may not fail in it.
constraint_may_fail(_) :- fail.
unlawful :- constraint(N), \+ constraint_may_fail(N).
evidence(\+ unlawful).
"""
CONSTRAINT, MAY_FAIL, UNLAWFUL = "constraint/1", "constraint_may_fail/1", "unlawful/0"
EVIDENCE = frozenset({"evidence/1", "evidence/2"})
OBSERVING = EVIDENCE | {CONSTRAINT}
"""Heads of clauses that leave out worlds."""
LAWFUL = frozenset({MAY_FAIL, UNLAWFUL})
"""What ``LAW`` defines."""


def check_added(source: Source, known: frozenset[str]) -> frozenset[str]:
    """The signatures that a text defines which is added to a program of ``known`` ones.

    Raises as ``check_source``. It adds to none of them, but for constraints of others who say the same by them.
    """
    shared = {CONSTRAINT, MAY_FAIL} if UNLAWFUL in known or CONSTRAINT not in known else set[str]()
    return check_source(source, known - {UNLAWFUL}, (known | {UNLAWFUL}) - shared - SPECIAL_HEADS, mistakes)


def lawful(source: Source, known: frozenset[str]) -> str:
    """The text with ``LAW``, where it has constraints and ``known`` does not say it already."""
    lacks = UNLAWFUL not in known and any(h.signature == CONSTRAINT for h in heads_of(source))
    return source.text + LAW if lacks else source.text


def heads_of(source: Source) -> Iterator[Any]:
    """The heads of all statements."""
    return (head for statement in source.statements for head in heads(statement))


@dataclass(frozen=True)
class Observation:
    """One clause of a text that observes or constrains: its number there, and what it says, with its place."""

    file: str
    number: int
    told: str


def observations(source: Source) -> list[Observation]:
    """Evidence and constraints, in the order of the text."""
    found = [(i, heads(s)[0]) for i, s in enumerate(source.statements) if _observes(s)]
    return [
        Observation(source.file, i, with_place(shown(head, Names({}, {})), source.place(head))) for i, head in found
    ]


def only(source: Source, some: Collection[Observation], *, free_of: frozenset[str] | None = None) -> str:
    """The text with some of its observations alone; of a constraint that is left out the body never holds.

    Where it is to be ``free_of`` a program, without all clauses that call what that defines, or call such clauses.
    """
    kept = {each.number for each in some if each.file == source.file}
    bound = set[int]() if free_of is None else _bound(source, free_of)
    texts = [
        str(s) if i in kept or not _observes(s) else f"{heads(s)[0]} :- ({s.body}), fail"
        for i, s in enumerate(source.statements)
        if i in kept - bound or (i not in bound and not heads_are(s, EVIDENCE))
    ]
    return "".join(f"{text}.\n" for text in texts)


def _observes(statement: Any) -> bool:  # noqa: ANN401 - a term of ProbLog's
    return heads_are(statement, OBSERVING)


def heads_are(statement: Any, signatures: frozenset[str]) -> bool:  # noqa: ANN401 - a term of ProbLog's
    """Whether a head of the statement has one of these signatures."""
    return any(head.signature in signatures for head in heads(statement))


def _bound(source: Source, program: frozenset[str]) -> set[int]:
    """The statements that say something of a program, maybe by way of others."""
    calls = [
        {atom.signature for goal in _goals(statement) for atom, _ in _calls(goal)} for statement in source.statements
    ]
    defines = [{head.signature for head in heads(statement)} for statement in source.statements]
    reached, bound = set(program), set[int]()
    while more := [i for i, some in enumerate(calls) if i not in bound and not some.isdisjoint(reached)]:
        bound.update(more)
        reached.update(*(defines[i] for i in more))
    return bound


def _goals(statement: Any) -> list[Any]:  # noqa: ANN401 - a term of ProbLog's
    """What a clause or evidence calls."""
    if isinstance(statement, (Clause, AnnotatedDisjunction)):
        return [statement.body]
    return [head.args[0] for head in heads(statement) if head.signature in EVIDENCE]


def mistakes(source: Source, known: frozenset[str]) -> Iterator[Mistake]:
    """Every mistake of a text that is added to a program, with its term."""
    for statement in source.statements:
        body = statement.body if isinstance(statement, (Clause, AnnotatedDisjunction)) else None
        if is_directive(statement) and statement.body.signature not in LOADERS | {"consult/1"}:
            yield ProgramError, f"a clause without a head does nothing: write constraint(name) :- {body}.", body
        found = heads(statement)
        for head in found:
            if head.signature == "query/1":
                yield ProgramError, "query/1: rules do not ask (ask with a goal: plogic query)", head
            elif head.signature.startswith("evidence/"):
                yield from ((ProgramError, reason, head) for reason in _of_evidence(head, body))
            elif head.signature == CONSTRAINT:
                yield from ((ProgramError, reason, head) for reason in _of_constraint(head.args[0], body))
    yield from _without_constraint(source, known)
    yield from _contradictory(source)
    yield from _negative_cycles(source)


def idle(text: str, file: str) -> list[str]:
    """What in a plain program looks like a constraint and excludes no world, with its place and what would exclude it.

    There a ``constraint/1`` is a predicate like any other, as in stock ProbLog, and a clause without a head is called
    once and forgotten. A text that cannot be read, or not quickly, is told of elsewhere.
    """
    source = glanced(text, file)
    if source is None or any(head.signature == UNLAWFUL for head in heads_of(source)):
        return []
    return [str(ProgramError(reason, **source.place(term))) for reason, term in _idle(source)]


def _idle(source: Source) -> Iterator[tuple[str, Any]]:
    for statement in source.statements:
        if is_directive(statement):
            name = str(statement.body.functor)
            if statement.body.signature not in LOADERS | {"consult/1"} and name not in DECLARED:
                remedy = f"write excluded :- {statement.body}. evidence(\\+ excluded)."
                yield f"a clause without a head excludes no world: {remedy}", statement.body
            continue
        for head in heads(statement):
            if head.signature == CONSTRAINT:
                remedy = "move it to a file of rules, --rules FILE, where it does"
                yield f"{head} excludes no world in a plain program: {remedy}", head


def _of_evidence(head: Any, body: Any) -> Iterator[str]:  # noqa: ANN401 - terms of ProbLog's
    if head.signature not in EVIDENCE:
        yield f"evidence takes one argument, or two, not {head.arity}: evidence(name)."
        return
    goal, value = head.args[0], str(head.args[-1]) if head.arity == 2 else "true"
    if body is not None:
        yield "evidence has no body: give its condition a name, name :- Body. evidence(name)."
    if head.probability is not None:
        yield "evidence has no probability: give it a name, P::name. evidence(name)."
    if isinstance(goal, (And, Or)):
        yield f"evidence is one literal: write name :- {goal}. evidence(name)."
    elif isinstance(goal, (Var, Constant)):
        yield "evidence is a literal, like evidence(wet) or evidence(\\+ wet)"
    elif value not in ("true", "false"):
        yield "the second argument of evidence/2 is true or false"
    elif value == "true" and goal.signature != "\\+/1" and not goal.is_ground():
        yield f"evidence with variables is said of every instance: for some instance write name :- {goal}. evidence(name)."


def _of_constraint(name: Any, body: Any) -> Iterator[str]:  # noqa: ANN401 - terms of ProbLog's
    if body is None:
        yield f"constraint({name}) without a body excludes every world: write constraint({name}) :- Body."
        return
    unbound = sorted(_variables(name) - set().union(*(_variables(atom) for atom, holds in _calls(body) if holds)))
    if unbound:
        yield f"{', '.join(unbound)} of the constraint's name is bound by nothing in its body"


def _variables(term: Any) -> set[str]:  # noqa: ANN401 - a term of ProbLog's
    if isinstance(term, Var):
        return {str(term.name)}
    arguments = term.args if isinstance(term, Term) else ()
    return set().union(*map(_variables, arguments))


def _without_constraint(source: Source, known: frozenset[str]) -> Iterator[Mistake]:
    """What softens a constraint that nobody states; in a text beside others, theirs are not looked at."""
    names = [head.args[0] for head in heads_of(source) if head.signature == CONSTRAINT]
    if CONSTRAINT in known:
        return
    for head in heads_of(source):
        if head.signature == MAY_FAIL and not any(_unify(head.args[0], name) for name in names):
            there = f"; there are {', '.join(dict.fromkeys(map(str, names)))}" if names else ", nor any other"
            yield ProgramError, f"there is no constraint({head.args[0]}) that may fail{there}", head


def _unify(one: Any, other: Any) -> bool:  # noqa: ANN401 - terms of ProbLog's
    """Whether two terms of different clauses may be the same, each of their variables looked at alone."""
    if isinstance(one, Var) or isinstance(other, Var):
        return True
    if getattr(one, "args", ()) or getattr(other, "args", ()):
        same = str(one.functor).strip("'") == str(other.functor).strip("'") and len(one.args) == len(other.args)
        return same and all(map(_unify, one.args, other.args))
    return bool(one == other) or (label_of(one) is not None and label_of(one) == label_of(other))


def _contradictory(source: Source) -> Iterator[Mistake]:
    """Evidence for a literal and against it."""
    said: dict[str, tuple[bool, Any]] = {}
    for head in heads_of(source):
        if head.signature in EVIDENCE:
            goal, holds = head.args[0], head.arity == 1 or str(head.args[1]) == "true"
            while getattr(goal, "signature", "") == "\\+/1":
                goal, holds = goal.args[0], not holds
            before, first = said.setdefault(str(goal), (holds, head))
            if before != holds:
                line = source.place(first).get("line")
                yield ProgramError, f"evidence for {goal} and against it (line {line}): no world satisfies both", head


def _calls(goal: Any, *, holds: bool = True) -> Iterator[tuple[Any, bool]]:  # noqa: ANN401 - a term of ProbLog's
    """The atoms of a body, each with whether it stands there without a negation or the like."""
    if isinstance(goal, (Var, Constant)) or not isinstance(goal, Term):
        return
    inner = META.get(goal.signature)
    if inner is None:
        yield goal, holds
    for position, _ in inner or ():
        plain = goal.signature in (",/2", ";/2", "once/1", "call/1")
        yield from _calls(goal.args[position], holds=holds and plain)


def _negative_cycles(source: Source) -> Iterator[Mistake]:
    r"""Predicates that depend on their own negation, of the same arguments: such rules have no single meaning.

    Whether a rule like ``clear(X) :- on(Y, X), \+ clear(Y)`` comes back to itself is for the scene to say.
    """
    follows: dict[tuple[str, ...], list[tuple[tuple[str, ...], bool, Any]]] = {}
    for statement in source.statements:
        if isinstance(statement, (Clause, AnnotatedDisjunction)):
            for head in heads(statement):
                steps = [(atom.signature, holds, atom) for atom, holds in _calls(statement.body) if _alike(head, atom)]
                follows.setdefault(head.signature, []).extend(steps)
    for start, steps in follows.items():
        for after, holds, atom in steps:
            if not holds and start in _reached(follows, after):
                reason = f"{start} depends on the negation of {after}, which depends on {start}: no single meaning"
                yield NegativeCycleError, reason, atom


def _alike(head: Any, atom: Any) -> bool:  # noqa: ANN401 - terms of ProbLog's
    return [str(a) for a in head.args] == [str(a) for a in atom.args]


def _reached(follows: dict[Any, list[tuple[Any, bool, Any]]], start: Any) -> set[Any]:  # noqa: ANN401
    seen, stack = set[Any](), [start]
    while stack:
        top = stack.pop()
        if top not in seen:
            seen.add(top)
            stack += [after for after, _, _ in follows.get(top, ())]
    return seen
