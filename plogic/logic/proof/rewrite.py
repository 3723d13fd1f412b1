r"""The clauses of a program, ready for proofs (``Rules``), and the same program rewritten so that every proof can be read off its grounding.

A clause ``h :- b1, (b2 ; b3), \+ (b4, b5).`` becomes ``h :- 'plogic rule 7'(X, Y).`` with ``'plogic rule 7'(X, Y) :-
b1, 'plogic part 8'(X), \+ 'plogic part 9'(Y).``: an instance of a rule is then an atom of its own, whose arguments are
the values of the rule's variables. Choices keep their identity (one for each instance of a clause's variables), so the
meaning is the same. Vocabulary:

* ``Literal``, one condition of a body: ``Literal("not", goal=hidden(H, F), ask=hidden(H, F))``
* ``Rule``, ``heads[i]`` with ``labels[i]`` :- literals; a label of None is certain
* ``Rules``, all of them, by the signature of a head
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any
from typing import Literal as OneOf

from problog.logic import AggTerm, AnnotatedDisjunction, Clause, Term

from plogic.logic.proof.terms import Ref, Small, is_atom, problog_term, refs, signature, small
from plogic.logic.safety.allowlist import GOALS, LIBRARY_META, LISTS, META
from plogic.logic.safety.check import heads, is_directive

TRUE = ("true",)
RULE, PART = "plogic rule", "plogic part"
Kind = OneOf["atom", "not", "check", "part", "computed"]


@dataclass(frozen=True)
class Literal:
    """One condition: ``goal`` is what was written, ``ask`` what the rewritten program calls for it.

    ``atom``: defined by clauses; ``not``: its negation (``goal`` is what is negated); ``check``: a built-in test;
    ``part``: a disjunction, whose sides are rules of ``ask``; ``computed``: findall/3 and the like, which only
    ProbLog's engine can follow.
    """

    kind: Kind
    goal: Small
    ask: Small


@dataclass(frozen=True)
class Rule:
    """``number`` identifies the rule, ``variables`` what its choices and its instances are told apart by.

    ``ask`` is its instances' atom.
    """

    number: int
    heads: tuple[Small, ...]
    labels: tuple[Small | None, ...]
    literals: tuple[Literal, ...]
    variables: tuple[Ref, ...]

    @property
    def ask(self) -> Small:
        """``'plogic rule 7'(X, Y)``."""
        return (f"'{RULE} {self.number}'", *self.variables)

    @property
    def is_certain(self) -> bool:
        """Whether no choice belongs to it."""
        return self.labels[0] is None


@dataclass(frozen=True)
class Rules:
    """Signature → (rule, which of its heads), with an index on a ground first argument.

    ``by_number`` holds every rule.
    """

    by_number: dict[int, Rule] = field(default_factory=dict)
    by_signature: dict[tuple[str, int], list[tuple[Rule, int]]] = field(default_factory=dict)
    by_first: dict[tuple[tuple[str, int], Small], list[tuple[Rule, int]]] = field(default_factory=dict)
    opaque: set[tuple[str, int]] = field(default_factory=set)

    def matching(self, goal: Small) -> Iterator[tuple[Rule, int]]:
        """The rules whose head may unify with the goal."""
        key = signature(goal)
        first = goal[1] if len(goal) > 1 else None
        indexed = first is not None and is_atom(first)
        yield from self.by_first.get((key, first), ()) if indexed else self.by_signature.get(key, ())
        if indexed:
            yield from self.by_first.get((key, None), ())

    def add(self, rule: Rule) -> None:
        """One more rule."""
        self.by_number[rule.number] = rule
        for i, head in enumerate(rule.heads):
            key = signature(head)
            self.by_signature.setdefault(key, []).append((rule, i))
            first = head[1] if len(head) > 1 and is_atom(head[1]) else None
            self.by_first.setdefault((key, first), []).append((rule, i))


NEGATIONS = (("\\+", 1), ("not", 1))
LOCAL = {("findall", 3): (1, 2), ("all", 3): (1, 2), ("all_or_none", 3): (1, 2)}
"""Arguments whose variables ProbLog keeps to themselves."""
SPECIAL = (("query", 1), ("evidence", 1), ("evidence", 2))
NO = (("fail", 0), ("false", 0))


@dataclass
class Rewriter:
    """Collects rules; ``defined`` are the signatures that clauses define."""

    defined: set[tuple[str, int]]
    rules: Rules = field(default_factory=Rules)
    count: int = 0

    def statement(self, statement: Any) -> tuple[int, list[Any]]:  # noqa: ANN401 - a term of ProbLog's
        """The number of the statement's rule, and what the engine is given for it: the statement itself where there is nothing to follow."""
        self.count += 1
        number = self.count
        variables: dict[str, Ref] = {}
        found = heads(statement)
        written = tuple(small(head.with_probability(None), variables) for head in found)
        if is_directive(statement) or any(signature(head) in SPECIAL for head in written):
            return number, [statement]
        if any(isinstance(a, AggTerm) for head in found for a in head.args):
            self.rules.opaque.update(signature(head) for head in written)
            return number, [statement]
        labels = tuple(None if head.probability is None else small(head.probability, variables) for head in found)
        body = small(statement.body, variables) if isinstance(statement, (Clause, AnnotatedDisjunction)) else TRUE
        return number, self._rule(number, written, labels, body, statement)

    def goal(self, goal: Small, name: str, variables: Sequence[Ref]) -> tuple[Small, list[Any]]:
        """The head and the clauses of ``'plogic goal'(X) :- goal``."""
        self.count += 1
        head = (name, *variables)
        return head, self._rule(self.count, (head,), (None,), goal, Clause(Term(name), Term("true")))

    def evidence(self, i: int, goal: Small) -> tuple[int, list[Any]]:
        """The clauses of ``'plogic given 0' :- goal.`` and ``evidence('plogic given 0').``."""
        head, clauses = self.goal(goal, f"'plogic given {i}'", ())
        return self.count, [*clauses, Term("evidence", Term(head[0]))]

    def _rule(
        self,
        number: int,
        written: tuple[Small, ...],
        labels: tuple[Small | None, ...],
        body: Small,
        statement: Any,  # noqa: ANN401 - ProbLog's statements are untyped
    ) -> list[Any]:
        named = list(
            dict.fromkeys(v for pair in zip(written, labels, strict=True) for term in pair for v in refs(term))
        )
        literals, more = self._literals(body, set(named))
        used = [v for literal in literals for v in _own(literal)]
        variables = tuple(dict.fromkeys([*named, *(v for v in used)]))
        rule = Rule(number, written, labels, tuple(literals), variables)
        if literals and signature(literals[0].goal) in NO:
            return [statement]
        self.rules.add(rule)
        if literals:
            return [*_clauses(rule), *more]
        if rule.is_certain or len(labels) > 1:
            return [statement]
        return [Clause(statement.head if isinstance(statement, Clause) else statement, Term("true"))]

    def _literals(self, body: Small, outside: set[Ref]) -> tuple[list[Literal], list[Any]]:
        """The conditions of a body in their order, and the clauses of its parts.

        ``outside`` are variables that are used elsewhere too.
        """
        goals = [goal for goal in _sides(body, ",") if goal != TRUE]
        used = [list(refs(goal)) for goal in goals]
        found = [self._literal(goal, outside.union(*used[:i], *used[i + 1 :])) for i, goal in enumerate(goals)]
        return [literal for literal, _ in found], [clause for _, clauses in found for clause in clauses]

    def _literal(self, goal: Small, elsewhere: set[Ref]) -> tuple[Literal, list[Any]]:
        name = signature(goal)
        if name in NEGATIONS:
            inner = goal[1]
            if self._followed(inner):
                return Literal("not", inner, inner), []
            part, clauses = self._part(inner, elsewhere)
            return Literal("not", inner, part), clauses
        if name == (";", 2):
            part, clauses = self._part(goal, elsewhere)
            return Literal("part", goal, part), clauses
        if self._followed(goal):
            return Literal("atom", goal, goal), []
        written = f"{name[0]}/{name[1]}"
        if written in META or written in LIBRARY_META or written not in GOALS | LISTS:
            part, clauses = self._part(goal, elsewhere)
            return Literal("computed", goal, part), clauses
        return Literal("check", goal, goal), []

    def _followed(self, goal: Small) -> bool:
        return signature(goal) in self.defined and signature(goal) not in self.rules.opaque

    def _part(self, goal: Small, elsewhere: set[Ref]) -> tuple[Small, list[Any]]:
        """An atom of its own for a part of a body; each side of a disjunction is a rule of it."""
        self.count += 1
        own = set(_outward(goal))
        shared = tuple(v for v in refs(goal) if v in own or v in elsewhere)
        ask = (f"'{PART} {self.count}'", *shared)
        sides = list(_sides(goal, ";"))
        if len(sides) == 1 and not (signature(goal) == (",", 2) or signature(goal) in NEGATIONS):
            return ask, [Clause(*_terms(ask, goal))]
        clauses = []
        for side in sides:
            self.count += 1
            literals, more = self._literals(side, set(shared))
            variables = tuple(dict.fromkeys([*shared, *(v for literal in literals for v in _own(literal))]))
            rule = Rule(self.count, (ask,), (None,), tuple(literals), variables)
            self.rules.add(rule)
            clauses += [*_clauses(rule), *more]
        return ask, clauses


def defined_by(statements: Sequence[Any]) -> set[tuple[str, int]]:
    """The signatures of all heads."""
    return {signature(small(head, {})) for statement in statements for head in heads(statement)}


def _clauses(rule: Rule) -> Iterator[Any]:
    """Two clauses: ``heads :- 'plogic rule 7'(..).`` and ``'plogic rule 7'(..) :- conditions.``."""
    names = {v: f"X{i}" for i, v in enumerate(rule.variables)}
    calls = [("\\+", x.ask) if x.kind == "not" else x.ask for x in rule.literals]
    body = calls[-1]
    for call in reversed(calls[:-1]):
        body = (",", call, body)
    for literal in rule.literals:
        for v in refs((literal.goal, literal.ask)):
            names.setdefault(v, f"Y{len(names)}")
    written = [problog_term(head, names) for head in rule.heads]
    certain = [None if label is None else problog_term(label, names) for label in rule.labels]
    labelled = [head if p is None else head.with_probability(p) for head, p in zip(written, certain, strict=True)]
    ask = problog_term(rule.ask, names)
    yield Clause(labelled[0], ask) if len(labelled) == 1 else AnnotatedDisjunction(labelled, ask)
    yield Clause(ask, problog_term(body, names))


def _terms(ask: Small, goal: Small) -> tuple[Term, Any]:
    names = {v: f"X{i}" for i, v in enumerate(refs((ask, goal)))}
    return problog_term(ask, names), problog_term(goal, names)


def _sides(goal: Small, mark: str) -> Iterator[Small]:
    """What stands on either side of each of these marks."""
    if signature(goal) == (mark, 2):
        yield from _sides(goal[1], mark)
        yield from _sides(goal[2], mark)
    else:
        yield goal


def _own(literal: Literal) -> Iterator[Ref]:
    """The variables of a condition that its rule knows: those of a negation, or inside findall/3, only if the rule names them elsewhere."""
    if literal.kind != "not":
        yield from _outward(literal.goal)


def _outward(goal: Small) -> Iterator[Ref]:
    name = signature(goal)
    if name in NEGATIONS:
        return
    if name in ((",", 2), (";", 2)):
        yield from _outward(goal[1])
        yield from _outward(goal[2])
        return
    kept = LOCAL.get(name, ())
    for i, argument in enumerate(goal[1:], 1):
        if i not in kept:
            yield from refs(argument)
