"""Clauses made ready for grounding: small terms, numbered variables, facts in an index.

A small term is an atom (text), a variable (an int, its number in the clause), a constant ``("", text, value)``, or
``(functor, *arguments)``.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from problog.logic import And, AnnotatedDisjunction, Clause, Constant, Not, Or, Term, Var

Small = Any
"""str | int | tuple[str | Small, ...]"""
Signature = tuple[str, int]
Goal = tuple[Any, ...]
"""("call", signature, arguments, arguments are simple) | ("not", goals) | ("or", (goals, ...)) | ("test", functor,
arguments)"""

TESTED = frozenset(
    {
        ("=", 2),
        ("\\=", 2),
        ("==", 2),
        ("\\==", 2),
        ("<", 2),
        (">", 2),
        ("=<", 2),
        (">=", 2),
        ("=:=", 2),
        ("=\\=", 2),
        ("is", 2),
    }
)


class UnsupportedError(Exception):
    """Something that only ProbLog's own engine knows how to ground."""


@dataclass(frozen=True)
class Rule:
    """One head of a clause. ``label``: its probability, a number or arithmetic; None for a definite clause.

    ``source`` marks the clause that several heads share, ``number`` the head's place in it; ``size``: number of
    variables; ``place``: where the head stands; ``loose``: those that occur in negations only, and may stay unbound.
    """

    functor: str
    arguments: tuple[Small, ...]
    goals: tuple[Goal, ...]
    size: int
    label: Small
    source: int
    number: int
    loose: frozenset[int]
    place: Any = None


@dataclass
class Predicate:
    """Its rules, by the ground arguments of their heads.

    ``facts``: whether it is ground facts without probability and nothing else.
    """

    rules: list[Rule] = field(default_factory=list)
    facts: bool = True
    indexes: dict[tuple[int, ...], dict[tuple[Small, ...], list[Rule]]] = field(default_factory=dict)

    def add(self, rule: Rule) -> None:
        """Add a rule; only before the first call of ``matching``."""
        plain = rule.label is None and not rule.goals and all(is_ground(argument) for argument in rule.arguments)
        self.facts = self.facts and plain
        self.rules.append(rule)

    def matching(self, bound: tuple[int, ...], key: tuple[Small, ...]) -> Sequence[Rule]:
        """The rules whose heads are ``key`` at the places ``bound``, or have variables there, in program order."""
        if not bound:
            return self.rules
        index = self.indexes.get(bound)
        if index is None:
            index = self.indexes[bound] = self._index(bound)
        return index.get(key, index[()])

    def _index(self, bound: tuple[int, ...]) -> dict[tuple[Small, ...], list[Rule]]:
        index: dict[tuple[Small, ...], list[Rule]] = {(): []}
        for rule in self.rules:
            key = tuple(rule.arguments[i] for i in bound)
            if all(is_ground(k) for k in key):
                if key not in index:
                    index[key] = list(index[()])
                index[key].append(rule)
            else:
                for rules in index.values():
                    rules.append(rule)
        return index


def is_ground(term: Small) -> bool:
    """Whether a small term has no variable."""
    if isinstance(term, tuple):
        return term[0] == "" or all(is_ground(argument) for argument in term[1:])
    return not isinstance(term, int)


class Reader:
    """ProbLog's statements as predicates; raises UnsupportedError for what is not plain rules and choices.

    It may go on from where another one ended, which nothing is added to any more: they share their predicates.
    """

    def __init__(self, before: "Reader | None" = None) -> None:
        self.predicates: dict[Signature, Predicate] = dict(before.predicates if before else {})
        self.spelling: dict[str, str] = dict(before.spelling if before else {})
        self.sources: int = before.sources if before else 0
        self.operators: dict[tuple[str, int], dict[str, Any]] = dict(before.operators if before else {})
        self.shared: set[Signature] = set(self.predicates)

    def add(self, statement: Any) -> None:  # noqa: ANN401 - a term of ProbLog's
        """Read one statement."""
        self.sources += 1
        if isinstance(statement, Or):
            self._rules(statement.to_list(), None)
        elif isinstance(statement, AnnotatedDisjunction):
            self._rules(statement.heads, statement.body)
        elif isinstance(statement, Clause):
            if isinstance(statement.head, Or) or statement.head.functor == "_directive":
                raise UnsupportedError
            self._rules([statement.head], statement.body)
        elif type(statement) is Term:
            self._rules([statement], None)
        else:
            raise UnsupportedError

    def _rules(self, heads: list[Any], body: Any) -> None:  # noqa: ANN401
        if len(heads) > 1 and any(head.probability is None for head in heads):
            raise UnsupportedError
        variables = Variables()
        arguments = [tuple(self.small(argument, variables) for argument in head.args) for head in heads]
        labels = [None if head.probability is None else self.small(head.probability, variables) for head in heads]
        goals = () if body is None else self.goals(body, variables)
        loose = frozenset(range(variables.count)) - variables.firm
        for number, head in enumerate(heads):
            functor = self.spelled(head.functor)
            rule = Rule(
                functor,
                arguments[number],
                goals,
                variables.count,
                labels[number],
                self.sources,
                number,
                loose,
                head.location,
            )
            self._own((functor, len(head.args))).add(rule)

    def _own(self, signature: Signature) -> Predicate:
        """The predicate, to be added to."""
        if signature in self.shared:
            self.shared.remove(signature)
            other = self.predicates[signature]
            self.predicates[signature] = Predicate(list(other.rules), other.facts)
        return self.predicates.setdefault(signature, Predicate())

    def goals(self, body: Any, variables: "Variables") -> tuple[Goal, ...]:  # noqa: ANN401
        """A body as a sequence of goals."""
        return tuple(self._goals(body, variables))

    def _goals(self, body: Any, variables: "Variables") -> Iterator[Goal]:  # noqa: ANN401
        while isinstance(body, And):
            yield from self._goals(body.args[0], variables)
            body = body.args[1]
        if isinstance(body, Or):
            yield ("or", tuple(self.goals(part, variables) for part in body.args))
        elif isinstance(body, Not) or (isinstance(body, Term) and body.signature == "not/1"):
            variables.depth += 1
            denied = self.goals(body.args[0], variables)
            variables.depth -= 1
            yield ("not", denied)
        elif isinstance(body, Term) and not isinstance(body, (Var, Constant)):
            yield from self._call(body, variables)
        else:
            raise UnsupportedError

    def _call(self, body: Any, variables: "Variables") -> Iterator[Goal]:  # noqa: ANN401
        functor = self.spelled(body.functor)
        arguments = tuple(self.small(argument, variables) for argument in body.args)
        bare = functor.strip("'")
        if (bare, len(arguments)) in TESTED:
            yield ("test", bare, arguments)
        elif (functor, len(arguments)) in (("fail", 0), ("false", 0)):
            yield ("or", ())
        elif (functor, len(arguments)) != ("true", 0):
            yield (
                "call",
                (functor, len(arguments)),
                arguments,
                not any(isinstance(a, tuple) and not is_ground(a) for a in arguments),
            )

    def small(self, term: Any, variables: "Variables") -> Small:  # noqa: ANN401
        """A term of ProbLog's as a small one."""
        if isinstance(term, Var):
            return variables.number(term.name)
        if isinstance(term, Constant):
            return ("", str(term.functor), term.functor)
        if not isinstance(term, Term) or isinstance(term, (And, Or, Not, Clause, AnnotatedDisjunction)):
            raise UnsupportedError
        functor = self.spelled(term.functor)
        if term.op_priority is not None:
            self.operators[functor, len(term.args)] = {"priority": term.op_priority, "opspec": term.op_spec}
        return (functor, *(self.small(argument, variables) for argument in term.args)) if term.args else functor

    def problog_term(self, term: Small) -> Any:  # noqa: ANN401
        """A ground small term as ProbLog's, with the operators that the text wrote it with."""
        if isinstance(term, str):
            return Term(term)
        if term[0] == "":
            return Constant(term[2])
        arguments = [self.problog_term(argument) for argument in term[1:]]
        return Term(term[0], *arguments, **self.operators.get((term[0], len(arguments)), {}))

    def spelled(self, functor: Any) -> str:  # noqa: ANN401
        """The functor.

        ProbLog takes 'a' and a for the same in some places and not in others, so a text that has both is left to it.
        """
        text = str(functor)
        if self.spelling.setdefault(text.strip("'"), text) != text:
            raise UnsupportedError
        return text


class Variables:
    """The variables of one clause, by name.

    ``depth``: negations around what is being read; ``firm``: variables that occur outside any.
    """

    def __init__(self) -> None:
        self.names: dict[str, int] = {}
        self.firm: set[int] = set()
        self.count = 0
        self.depth = 0

    def number(self, name: str) -> int:
        """The variable's number; every underscore is a new one."""
        found = self.names.get(name, self.count)
        self.count = max(self.count, found + 1)
        if name != "_":
            self.names[name] = found
        if not self.depth:
            self.firm.add(found)
        return found
