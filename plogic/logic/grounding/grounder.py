"""Grounding of plain programs.

Calls are answered from a table, top down, and every answer has its literal in the ground formula.

It knows rules, negation, disjunction, comparison, arithmetic, probabilistic clauses and annotated disjunctions, as long
as no call depends on itself and answers are ground. Anything else raises UnsupportedError before anything is told: then
ProbLog's own engine grounds the program (``load``), which is the definition of what is right; what both ground, they
ground to the same probabilities. Being without messages between nodes of an evaluation stack, this is ten times faster
and more on the programs of scenes. The ``Formula`` grows: gates over choices, simplified and shared as they are made;
acyclic, since children come first.
"""

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field
from typing import Any

from problog.errors import ProbLogError
from problog.logic import And, Constant, Not, Or, Term, Var

from plogic.logic.grounding.ground_program import Choice, Gate, Literal, Node, negated
from plogic.logic.grounding.indexed_clauses import (
    Goal,
    Reader,
    Rule,
    Signature,
    Small,
    UnsupportedError,
    Variables,
    is_ground,
)


@dataclass
class Formula:
    """``nodes[i]`` is variable i + 1."""

    nodes: list[Node] = field(default_factory=list)
    index: dict[Hashable, int] = field(default_factory=dict)

    def choice(self, group: Hashable, number: int, share: float, name: Callable[[], Any]) -> int:
        """The variable of a choice; the same number of the same group is the same choice."""
        key = group, number
        if key not in self.index:
            self.nodes.append(Choice(share, group, name, number))
            self.index[key] = len(self.nodes)
        return self.index[key]

    def conjunction(self, literals: tuple[int, ...]) -> Literal:
        """And of literals, none of which is a constant; see ``fails``."""
        return None if fails(literals) else self._gate("and", tuple(dict.fromkeys(literals)))

    def disjunction(self, literals: tuple[Literal, ...]) -> Literal:
        """Or of literals and constants."""
        if 0 in literals:
            return 0
        return self._gate("or", tuple(dict.fromkeys(literal for literal in literals if literal is not None)))

    def _gate(self, kind: str, children: tuple[int, ...]) -> Literal:
        if len(children) < 2:
            return children[0] if children else 0 if kind == "and" else None
        if kind == "or" and len({abs(child) for child in children}) < len(children):
            return 0
        key = Gate(kind, children)
        if key not in self.index:
            self.nodes.append(key)
            self.index[key] = len(self.nodes)
        return self.index[key]


def fails(literals: tuple[int, ...]) -> bool:
    """Whether a conjunction is false where ProbLog sees that.

    Its last literal, and the last that differs from it, are opposites.

    Any other contradiction is a gate that never holds, so that an answer is listed with probability 0 where ProbLog
    lists it.
    """
    differing = next((literal for literal in reversed(literals) if literal != literals[-1]), None)
    return differing is not None and differing == -literals[-1]


Answers = list[tuple[tuple["Small", ...], "Literal"]]
Environment = list["Small | None"]


class Grounder:
    """Predicates, the growing formula, and a table of the answered calls (None while one is being answered)."""

    def __init__(self, reader: Reader | None = None) -> None:
        self.reader = reader or Reader()
        self.formula = Formula()
        self.table: dict[Any, Answers | None] = {}

    def node(self, variable: int) -> Node:
        """The gate or choice of a variable of the formula."""
        return self.formula.nodes[variable - 1]

    def instances(self, goal: Any, *, or_none: bool) -> list[tuple[Any, Literal]]:  # noqa: ANN401 - a term of ProbLog's
        """Each instance of a goal, a term of ProbLog's, with its literal.

        A ground goal without one is its own instance and false; with variables there is then none, which is unsupported
        unless ``or_none``.
        """
        if isinstance(goal, (Var, Constant, And, Or, Not)) or not isinstance(goal, Term):
            raise UnsupportedError
        variables = Variables()
        arguments = tuple(variables.number("_") if a is None else self.reader.small(a, variables) for a in goal.args)
        answers = self.solve((self.reader.spelled(goal.functor), goal.arity), _canonical(arguments))
        if not variables.count:
            return [(goal, answers[0][1] if answers else None)]
        fitting = [answer for answer in answers if _fits(arguments, answer[0], [None] * variables.count)]
        if not fitting and not or_none:
            raise UnsupportedError
        return [
            (goal.with_args(*(self.reader.problog_term(a) for a in answer)), literal) for answer, literal in fitting
        ]

    def solve(self, signature: Signature, arguments: tuple[Small, ...]) -> Answers:
        """Ground instances of a call, each with its literal, in the order of their first proofs, and maybe more.

        The caller compares.
        """
        key = (signature, arguments)
        found = self.table.get(key, self)
        if found is None:
            raise UnsupportedError  # the call depends on itself
        if found is not self:
            return found  # type: ignore[return-value]
        predicate = self.reader.predicates.get(signature)
        if predicate is None:
            raise UnsupportedError
        bound = tuple(i for i, argument in enumerate(arguments) if is_ground(argument))
        rules = predicate.matching(bound, tuple(arguments[i] for i in bound))
        if predicate.facts:
            answers: Answers = [(fact, 0) for fact in dict.fromkeys(rule.arguments for rule in rules)]
        else:
            self.table[key] = None
            answers = self._answers(rules, arguments)
        self.table[key] = answers
        return answers

    def _answers(self, rules: Any, arguments: tuple[Small, ...]) -> Answers:  # noqa: ANN401
        proofs: dict[tuple[Small, ...], list[Literal]] = {}
        for rule in rules:
            environment: Environment = [None] * rule.size
            if all(
                _meets(head, argument, environment) for head, argument in zip(rule.arguments, arguments, strict=True)
            ):
                for bound, literals in self.prove(rule.goals, environment, ()):
                    literal = self._chosen(rule, bound, literals)
                    proofs.setdefault(tuple(_ground(a, bound) for a in rule.arguments), []).append(literal)
        found = ((answer, self.formula.disjunction(tuple(literals))) for answer, literals in proofs.items())
        return [(answer, literal) for answer, literal in found if literal is not None]

    def _chosen(self, rule: Rule, environment: Environment, literals: tuple[int, ...]) -> Literal:
        """The proof's literal: its body's, and the choice's where the rule makes one."""
        if rule.label is not None:
            if any(value is None and i not in rule.loose for i, value in enumerate(environment)):
                raise UnsupportedError
            group = (rule.source, tuple(environment))
            share = self._share(applied(rule.label, environment))
            choice = self.formula.choice(group, rule.number, share, self._namer(rule, environment))
            return None if fails(literals) else self.formula.conjunction((*literals, choice))
        return self.formula.conjunction(literals)

    def _namer(self, rule: Rule, environment: Environment) -> Callable[[], Any]:
        """Makes the choice's name, its head, when it is wanted."""
        return lambda: Term(
            rule.functor,
            *(self.reader.problog_term(_ground(a, environment)) for a in rule.arguments),
            location=rule.place,
        )

    def prove(
        self, goals: tuple[Goal, ...], environment: Environment, literals: tuple[int, ...]
    ) -> Iterator[tuple[Environment, tuple[int, ...]]]:
        """Each way in which the goals hold: what their variables are bound to, and the literals that it takes."""
        if not goals:
            yield environment, literals
            return
        goal, rest = goals[0], goals[1:]
        if goal[0] == "call":
            wanted = tuple(applied(argument, environment) for argument in goal[2])
            for answer, literal in self.solve(goal[1], _canonical(wanted)):
                bound = environment.copy()
                if _fits(wanted, answer, bound):
                    yield from self.prove(rest, bound, (*literals, literal) if literal else literals)
        elif goal[0] == "or":
            for part in goal[1]:
                yield from self.prove((*part, *rest), environment, literals)
        elif goal[0] == "not":
            denials = self.prove(goal[1], environment.copy(), ())
            denied = negated(self.formula.disjunction(tuple(self.formula.conjunction(way) for _, way in denials)))
            if denied is not None:
                yield from self.prove(rest, environment, (*literals, denied) if denied else literals)
        else:
            for bound in self._tested(goal[1], goal[2], environment):
                yield from self.prove(rest, bound, literals)

    def _tested(self, functor: str, arguments: tuple[Small, ...], environment: Environment) -> Iterator[Environment]:
        """The environment, with what the test binds, if it holds.

        ProbLog decides what is compared before it is known.
        """
        left, right = (applied(argument, environment) for argument in arguments)
        if functor not in ("=", "is"):
            if self._holds(functor, left, right):
                yield environment
            return
        if functor == "is":
            right = self._value(right)
        elif not is_ground(right):
            left, right = right, left
        if not is_ground(right):
            raise UnsupportedError
        bound = environment.copy()
        if _fits((left,), (right,), bound):
            yield bound

    def _holds(self, functor: str, left: Small, right: Small) -> bool:
        if not (is_ground(left) and is_ground(right)):
            raise UnsupportedError
        if functor in ("\\=", "\\==", "=="):
            return bool((left == right) == (functor == "=="))
        return _compared(functor, self._value(left)[2], self._value(right)[2])

    def _value(self, term: Small) -> Small:
        """The constant that arithmetic comes to."""
        if not is_ground(term):
            raise UnsupportedError
        try:
            value = self.reader.problog_term(term).compute_value()
        except (ProbLogError, ArithmeticError, TypeError, ValueError):
            raise UnsupportedError from None
        if not isinstance(value, (int, float)):
            raise UnsupportedError
        return ("", str(value), value)

    def _share(self, label: Small) -> float:
        """A label's probability, as far as it is one without doubt; ProbLog tells what is wrong with any other."""
        share = float(self._value(label)[2])
        if not 0.0 <= share <= 1.0:
            raise UnsupportedError
        return share


def applied(term: Small, environment: Environment) -> Small:
    """The term with its variables' values put in; what is unbound stays a variable."""
    if isinstance(term, int):
        value = environment[term]
        return term if value is None else value
    if isinstance(term, tuple) and term[0]:
        return (term[0], *(applied(argument, environment) for argument in term[1:]))
    return term


def _ground(term: Small, environment: Environment) -> Small:
    value = applied(term, environment)
    if not is_ground(value):
        raise UnsupportedError
    return value


def _canonical(arguments: tuple[Small, ...]) -> tuple[Small, ...]:
    """The same call with its variables numbered in the order in which they occur, so that the table knows it again."""
    if all(isinstance(argument, str) or is_ground(argument) for argument in arguments):
        return arguments
    numbers: dict[int, int] = {}

    def renamed(term: Small) -> Small:
        if isinstance(term, int):
            return numbers.setdefault(term, len(numbers))
        return (term[0], *(renamed(a) for a in term[1:])) if isinstance(term, tuple) and term[0] else term

    return tuple(renamed(argument) for argument in arguments)


def _meets(head: Small, argument: Small, environment: Environment) -> bool:
    """Whether a call may meet a head.

    Binds the head's variables to what is ground of the call (the caller compares the rest).
    """
    if isinstance(head, int):
        if not is_ground(argument):
            return True
        if environment[head] is None:
            environment[head] = argument
        return bool(environment[head] == argument)
    if isinstance(argument, int):
        return True
    if isinstance(head, tuple) and head[0] and isinstance(argument, tuple) and len(head) == len(argument):
        return bool(head[0] == argument[0]) and all(
            _meets(h, a, environment) for h, a in zip(head[1:], argument[1:], strict=True)
        )
    return bool(head == argument)


def _fits(pattern: Small, answer: Small, environment: Environment) -> bool:
    """Whether a ground answer is an instance of the pattern; binds its variables."""
    for wanted, given in zip(pattern, answer, strict=True):
        if isinstance(wanted, int):
            if environment[wanted] is None:
                environment[wanted] = given
            elif environment[wanted] != given:
                return False
        elif wanted != given and (
            not (
                isinstance(wanted, tuple)
                and isinstance(given, tuple)
                and wanted[0]
                and len(wanted) == len(given)
                and wanted[0] == given[0]
            )
            or not _fits(wanted[1:], given[1:], environment)
        ):
            return False
    return True


def _compared(functor: str, left: float, right: float) -> bool:
    if functor in ("=:=", "=\\="):
        return (left == right) == (functor == "=:=")
    return {"<": left < right, ">": left > right, "=<": left <= right, ">=": left >= right}[functor]
