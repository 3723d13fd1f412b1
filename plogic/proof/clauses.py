"""The clauses of a program, ready for proofs: heads, probabilities, body, by the signature of a head."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from problog.logic import AnnotatedDisjunction, Clause, Term

from plogic.proof.terms import Ref, Small, renamed, signature, small
from plogic.safety.check import heads, is_directive

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

TRUE = ("true",)


@dataclass(frozen=True)
class Rule:
    """``heads[i]`` with ``labels[i]`` :- body; a label of None is certain. ``number`` identifies the rule, ``variables`` its choices."""

    number: int
    heads: tuple[Small, ...]
    labels: tuple[Small | None, ...]
    body: Small
    variables: tuple[Ref, ...]

    def fresh(self) -> Rule:
        """The rule with new variables."""
        new: dict[Ref, Ref] = {}
        labels = tuple(None if label is None else renamed(label, new) for label in self.labels)
        parts = tuple(renamed(head, new) for head in self.heads), labels, renamed(self.body, new)
        return Rule(self.number, *parts, tuple(new.get(v, v) for v in self.variables))


@dataclass(frozen=True)
class Rules:
    """Signature → (rule, which of its heads), with an index on a ground first argument."""

    by_signature: dict[tuple[str, int], list[tuple[Rule, int]]]
    by_first: dict[tuple[tuple[str, int], Small], list[tuple[Rule, int]]]

    def matching(self, goal: Small) -> Iterator[tuple[Rule, int]]:
        """The rules whose head may unify with the goal."""
        key = signature(goal)
        first = goal[1] if len(goal) > 1 else None
        indexed = first is not None and _is_atom(first)
        yield from self.by_first.get((key, first), ()) if indexed else self.by_signature.get(key, ())
        if indexed:
            yield from self.by_first.get((key, None), ())


def rules_of(statements: Iterable[Any]) -> Rules:
    """The rules of ProbLog's statements; directives are left out, and so are queries and evidence."""
    result = Rules({}, {})
    for number, statement in enumerate(statements):
        if not is_directive(statement):
            _add(result, _rule(number, statement))
    return result


def _rule(number: int, statement: Any) -> Rule:  # noqa: ANN401 - a term of ProbLog's
    variables: dict[str, Ref] = {}
    found = heads(statement)
    body = statement.body if isinstance(statement, (Clause, AnnotatedDisjunction)) else Term("true")
    written = tuple(small(head.with_probability(None), variables) for head in found)
    labels = tuple(None if head.probability is None else small(head.probability, variables) for head in found)
    return Rule(number, written, labels, small(body, variables), tuple(variables.values()))


def _add(rules: Rules, rule: Rule) -> None:
    for i, head in enumerate(rule.heads):
        key = signature(head)
        rules.by_signature.setdefault(key, []).append((rule, i))
        first = head[1] if len(head) > 1 and _is_atom(head[1]) else None
        rules.by_first.setdefault((key, first), []).append((rule, i))


def _is_atom(term: Small) -> bool:
    return not isinstance(term, Ref) and (not isinstance(term, tuple) or len(term) == 1)
