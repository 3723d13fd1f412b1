r"""The clauses of a program, ready for proofs, and the same program rewritten so that every proof can be read off its grounding.

A clause ``h :- b1, (b2 ; b3), \+ (b4, b5).`` becomes ``h :- 'plogic rule 7'(X, Y).`` with ``'plogic rule 7'(X, Y) :-
b1, 'plogic part 8'(X), \+ 'plogic part 9'(Y).``: an instance of a rule is then an atom of its own, whose arguments are
what the rule's variables stand for. Choices keep their identity (one for each instance of a clause's variables), so the
meaning is the same. Vocabulary:

* ``Literal``, one condition of a body: ``Literal("not", goal=hidden(H, F), ask=hidden(H, F))``
* ``Rule``, ``heads[i]`` with ``labels[i]`` :- literals; a label of None is certain
* ``Rules``, all of them, by the signature of a head
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from typing import Literal as OneOf

from plogic.logic.proof.terms import Ref, Small, is_atom, signature

if TYPE_CHECKING:
    from collections.abc import Iterator

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
    """``number`` identifies the rule, ``variables`` what its choices and its instances are told apart by; ``ask`` is its instances' atom."""

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
    """Signature → (rule, which of its heads), with an index on a ground first argument; ``by_number`` holds every rule."""

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
