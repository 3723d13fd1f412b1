r"""Negations that are asked before their variables have values, as in ``safe(X) :- \+ risky(X), pump(X)``.

A body is asked from left to right. While X is open, ``\+ risky(X)`` says that nothing at all is risky, and ``X \= Y``
that no two things are alike, of which there are always some. ProbLog answers so without a word (it *flounders*).

Told is what is surely so: the variable is open when the negation is asked, and a goal behind it can bind it. A variable
of no such goal is meant to be open (nothing is risky). One of the head is open where some question or call leaves it
so: ``safe(X)`` does, ``safe(a)`` does not. Where a call leaves it so, and a goal behind the call can bind it, that goal
is named. The same is said of what is computed, ``X is Y + 1``, which ProbLog refuses.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from problog.logic import And, AnnotatedDisjunction, Clause, Constant, Not, Or, Term, Var

from plogic.base.errors import ProgramError
from plogic.logic.safety.allowlist import COMPARISON, META, SPECIAL_HEADS, TESTS
from plogic.logic.safety.check import Source, glanced, heads, is_directive

NEGATIONS = frozenset({"\\+/1", "not/1", "forall/2", "\\=/2", "\\==/2"})
"""What an open variable turns into another question."""
TESTED = COMPARISON - {"=/2"} | TESTS
"""Goals that bind nothing; of ``is/2`` the first argument alone is bound."""
AS_WRITTEN = frozenset({"call/1", "call_nc/1", "once/1"})
"""What calls its goal in its place: what stands behind it stands behind the goal."""
ARITHMETIC = frozenset({"is/2", "</2", ">/2", "=</2", ">=/2", "=:=/2", "=\\=/2"})
ROOTS = SPECIAL_HEADS | {"constraint/1"}
"""Heads that are asked with whatever is open in them."""


@dataclass(frozen=True)
class Rule:
    """One ``head`` and what it asks; without a head where it is asked itself."""

    head: Any
    body: Any

    @property
    def name(self) -> str:
        """The signature by which the rule is called; empty where it is asked itself."""
        return "" if self.head is None or self.head.signature in ROOTS else str(self.head.signature)

    def steps(self, opened: Mapping[int, Any]) -> "Iterator[Step]":
        """The goals that it asks where these arguments of its head are open; by number, with what binds it later."""
        given = list(enumerate(self.head.args)) if self.name else []
        bound = {name for i, argument in given if i not in opened for name in _names(argument)}
        late = {name: opened[i] for i, argument in given if opened.get(i) is not None for name in _names(argument)}
        return (replace(step, late=late, head=self.head) for step in _steps(self.body, bound, []))


@dataclass(frozen=True)
class Step:
    """A goal of a body, the variables that have values before it, and the goals ``after`` it."""

    goal: Any
    bound: frozenset[str]
    after: list[Any]
    late: Mapping[str, Any] = field(default_factory=dict)
    head: Any = None

    def opened(self) -> dict[int, Any]:
        """The arguments that have a variable without a value, each with a later goal that gives it one, or None."""
        lacking = {i: set(_all(a)) - self.bound for i, a in enumerate(self.goal.args) if isinstance(a, Term)}
        return {i: self._binder(names) for i, names in lacking.items() if names}

    def _binder(self, names: set[str]) -> Any | None:  # noqa: ANN401 - a term of ProbLog's
        binders = [goal for goal in self.after if not _binds(goal).isdisjoint(names)]
        return binders[-1] if binders else next((self.late[name] for name in names if name in self.late), None)

    def early(self) -> str:
        """What is to be said of a negation whose variables have no values yet; '' of anything else."""
        if self.goal.signature not in NEGATIONS:
            return ""
        lacks = [name for name in _names(self.goal) if name not in self.bound]
        binders = [goal for goal in self.after if not _binds(goal).isdisjoint(lacks)]
        called = [name for name in lacks if name in self.late]
        if binders:
            which, how = (
                [name for name in lacks if any(name in _binds(goal) for goal in binders)],
                f"it after {binders[-1]}",
            )
        elif called:
            which, how = called, f"the call of {self.head} after {self.late[called[0]]}"
        else:
            return ""
        return f"{_written(self.goal)} is asked before {_valued(which)}, of all values at once: write {how}"

    def computed(self) -> str:
        """What is to be said of arithmetic whose variables have no values yet; '' of anything else."""
        if self.goal.signature not in ARITHMETIC:
            return ""
        needed = _names(self.goal.args[1]) if self.goal.signature == "is/2" else _names(self.goal)
        lacks = [name for name in needed if name not in self.bound]
        if not lacks:
            return ""
        binder = self._binder(set(lacks))
        how = ", and no goal of this body gives it" if binder is None else f": write it after {binder}"
        return f"{self.goal} is computed before {_valued(lacks)}{how}"


def _valued(names: Sequence[str]) -> str:
    return f"{' and '.join(names)} {'has a value' if len(names) == 1 else 'have values'}"


def asked_too_early(text: str, file: str, goals: Sequence[str] = ()) -> list[str]:
    """A line, with its place, on each such negation; ``goals`` are asked beside the text's own queries.

    A text that cannot be read, or not quickly, is told of elsewhere.
    """
    source = glanced(text, file)
    if source is None:
        return []
    asked = [glanced(f"asked :- {goal.rstrip(' .')}.", "goal") for goal in goals]
    rules = [Rule(None, statement.body) for goal in asked if goal is not None for statement in goal.statements]
    rules += [rule for statement in source.statements if not is_directive(statement) for rule in _rules(statement)]
    own = {id(step.goal) for rule in rules if rule.head is not None for step in rule.steps({})}
    found = {id(step.goal): (said, step.goal) for step in _asked(rules) if (said := step.early())}
    return [str(ProgramError(said, **source.place(goal))) for key, (said, goal) in found.items() if key in own]


def goals_too_early(goals: Mapping[str, str]) -> list[str]:
    """As ``asked_too_early``, of the negations in goals and evidence themselves: what each is called → its text."""
    return [line for file, text in goals.items() for line in _goal_too_early(text, file)]


def _goal_too_early(text: str, file: str) -> list[str]:
    source = glanced(f"{text.rstrip().removesuffix('.')}\n.", file)
    if source is None:
        return []
    steps = [step for goal in source.statements for step in Rule(None, goal).steps({})]
    return [str(ProgramError(said, **source.place(step.goal))) for step in steps if (said := step.early())]


def computed_early(sources: Iterable[Source], place: Mapping[str, Any]) -> str:
    """What is to be said of the ``is``, or the comparison, at a place, that lacks a value; '' where nothing is seen."""
    for source in sources if place.get("line") else ():
        for statement in source.statements:
            asked = source.file.partition(" ")[0] in ("goal", "given")
            for rule in [Rule(None, statement)] if asked else _rules(statement):
                steps = [*rule.steps({}), *rule.steps(dict.fromkeys(range(getattr(rule.head, "arity", 0))))]
                found = [said for step in steps if source.place(step.goal) == place and (said := step.computed())]
                if found:
                    return found[0]
    return ""


def half_bound(goal: str) -> str:
    """The variables of a goal that only some of its alternatives give a value, in words; '' where there are none."""
    source = glanced(f"{goal.rstrip().removesuffix('.')}\n.", "goal")
    each = source.statements[0] if source is not None and source.statements else None
    sides = [part for part in _conjuncts(each) if isinstance(part, Or)]
    lacks = sorted({name for part in sides for side in part.to_list() for name in _names(side)} - _always(each))
    return f"; only some of its alternatives give {' and '.join(lacks)} a value" if lacks else ""


def _always(goal: Any) -> set[str]:  # noqa: ANN401 - a term of ProbLog's
    """The variables that a goal gives a value whichever of its alternatives holds."""
    if isinstance(goal, And):
        return _always(goal.op1) | _always(goal.op2)
    return set.intersection(*map(_always, goal.to_list())) if isinstance(goal, Or) else _binds(goal)


def never_bound(clause: str) -> list[str]:
    """The variables of a clause's head that no goal of its body can give a value: whoever calls it must."""
    source = glanced(clause, "clause")
    rules = [] if source is None else [rule for statement in source.statements for rule in _rules(statement)]
    return [
        name
        for rule in rules
        for name in _names(rule.head)
        if not any(name in _binds(goal) for goal in _conjuncts(rule.body))
    ]


def _rules(statement: Any) -> Iterator[Rule]:  # noqa: ANN401 - a term of ProbLog's
    """One for each head; what a head asks comes after the condition of its clause."""
    body = statement.body if isinstance(statement, (Clause, AnnotatedDisjunction)) else Term("true")
    for head in heads(statement):
        yield Rule(head, And(body, head.args[0]) if head.signature in SPECIAL_HEADS else body)


def _asked(rules: list[Rule]) -> "Iterator[Step]":
    """Every goal that the questions lead to, with as few values as some call gives it."""
    of: dict[str, list[Rule]] = {}
    for rule in rules:
        of.setdefault(rule.name, []).append(rule)
    opened, waiting = {"": dict[int, Any]()}, [""]
    while waiting:
        name = waiting.pop()
        for step in (step for rule in of.get(name, ()) for step in rule.steps(opened[name])):
            called = step.goal.signature
            known = opened.get(called)
            new = {i: goal for i, goal in step.opened().items() if known is None or known.get(i) is None}
            if called in of and (known is None or any(goal is not None or i not in known for i, goal in new.items())):
                opened.setdefault(called, {}).update(new)
                waiting.append(called)
    return (step for name, places in opened.items() for rule in of.get(name, ()) for step in rule.steps(places))


def _steps(goal: Any, bound: set[str], after: list[Any]) -> Iterator[Step]:  # noqa: ANN401 - a term of ProbLog's
    """Each goal in a body, those included that it calls as they are written."""
    bound, goals = set(bound), _conjuncts(goal)
    for i, each in enumerate(goals):
        later = [*goals[i + 1 :], *after]
        if isinstance(each, Or):
            for side in each.to_list():
                yield from _steps(side, bound, later)
        elif isinstance(each, Term) and not isinstance(each, (Var, Constant)):
            yield Step(each, frozenset(bound), later)
            for place, added in META.get(each.signature, ()):
                if not added:
                    yield from _steps(each.args[place], bound, later if each.signature in AS_WRITTEN else [])
        if getattr(each, "signature", "") == "=/2" and not bound & set(_names(each)):
            bound |= _binds(each)
        elif getattr(each, "signature", "") not in NEGATIONS:
            bound |= set(_names(each))


def _conjuncts(goal: Any) -> list[Any]:  # noqa: ANN401 - a term of ProbLog's
    found = []
    while isinstance(goal, And):
        found += _conjuncts(goal.op1)
        goal = goal.op2
    return [*found, goal]


def _binds(goal: Any) -> set[str]:  # noqa: ANN401 - a term of ProbLog's
    """The variables that a goal can give a value."""
    signature = getattr(goal, "signature", "")
    if isinstance(goal, (And, Or)):
        return set().union(*map(_binds, goal.args))
    if signature == "is/2":
        return set(_names(goal.args[0]))
    if signature == "=/2" and all(isinstance(side, Var) for side in goal.args):
        return set()  # two that have no values are the same afterwards, without one
    return set() if isinstance(goal, Var) or signature in NEGATIONS | TESTED else set(_names(goal))


def _all(term: Any) -> list[str]:  # noqa: ANN401 - a term of ProbLog's
    return [str(name) for name in term.variables()] if isinstance(term, Term) else []


def _names(term: Any) -> list[str]:  # noqa: ANN401 - a term of ProbLog's
    """The variables that have a name, in the order of the text."""
    return [name for name in _all(term) if name != "_"]


def _written(negation: Any) -> str:  # noqa: ANN401 - a term of ProbLog's
    if not isinstance(negation, Not):
        return str(negation)
    inner = negation.args[0]
    return f"{negation.functor} ({inner})" if isinstance(inner, (And, Or)) else f"{negation.functor} {inner}"
