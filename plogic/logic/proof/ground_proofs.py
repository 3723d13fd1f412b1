"""A rewritten program in ProbLog's engine.

Every goal that is asked comes back with its instances and its formula over choices.

Proofs are trees (``Tree``), and choices are shown as goals that can be read (``choice_literal``).
"""

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from problog.errors import ProbLogError
from problog.formula import LogicFormula
from problog.logic import Term

from plogic.base.errors import ProgramError
from plogic.base.walk import reached
from plogic.logic.grounding.ground_program import share_of
from plogic.logic.proof.cone import NONE_TAKEN, Choice
from plogic.logic.proof.rewrite import Rule, Rules
from plogic.logic.proof.terms import (
    Bindings,
    Ref,
    Small,
    canonical,
    fresh,
    is_ground,
    problog_term,
    refs,
    resolved,
    small,
    unify,
)

Key = int | None
"""A node of the formula: 0 is true, None is false, a negative number is a negation."""


@dataclass
class Grounding:
    """``formula`` grows with what is asked. ``starts[i]``: where in the database the rule ``numbers[i]`` begins."""

    engine: Any
    database: Any
    rules: Rules
    formula: Any = field(default_factory=LogicFormula)
    starts: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    asked: dict[Small, list[tuple[Small, Key]]] = field(default_factory=dict)
    made: dict[Any, Choice] = field(default_factory=dict)
    choices: dict[int, tuple[Choice, int] | None] = field(default_factory=dict)

    def add(self, number: int, statements: list[Any]) -> None:
        """Put a rule's statements into the database."""
        self.starts.append(len(self.database))
        self.numbers.append(number)
        for statement in statements:
            self.database.add_statement(statement)

    def prepare(self) -> None:
        """Run the program's directives, and ground its evidence."""
        self.database = self.engine.prepare(self.database)
        self.formula = self.engine.ground_all(self.database, self.formula, queries=[])

    def evidence(self) -> list[tuple[Any, int, int]]:
        """(name, node, sign) of each observation; a sign of 0 observes nothing."""
        return [(name, key, sign) for name, key, sign in self.formula.evidence_all() if sign]

    def under(self, keys: Iterable[Key]) -> set[int]:
        """The nodes that these depend on."""
        return set(
            reached(
                (abs(key) for key in keys if key),
                lambda node: [abs(child) for child in self.children(node) if child],
            )
        )

    def children(self, node: int) -> tuple[Key, ...]:
        """The children of a gate; an atom has none."""
        return tuple(getattr(self.formula.get_node(node), "children", ()))

    def ask(self, goal: Small) -> list[tuple[Small, Key]]:
        """Each instance of the goal that is true in some world, with its node; raises what ProbLog raises."""
        known = canonical(goal)
        if known not in self.asked:
            self.asked[known] = self._ask(goal)
        return self.asked[known]

    def _ask(self, goal: Small) -> list[tuple[Small, Key]]:
        query = Term(goal[0], *[problog_term(a) if is_ground(a) else None for a in goal[1:]])
        _, results = self.engine._ground(self.database, query, self.formula, silent_fail=False)  # noqa: SLF001 - the engine's only door to nodes
        found: dict[Small, list[Key]] = {}
        for values, key in results:
            instance = (goal[0], *(small(value, {}) for value in values))
            bound: Bindings = {}
            if key is not None and unify(goal, instance, bound):
                found.setdefault(resolved(instance, bound), []).append(key)
        return [(instance, self._either(keys)) for instance, keys in found.items()]

    def _either(self, keys: list[Key]) -> Key:
        key: Key = keys[0] if len(keys) == 1 else self.formula.add_or(keys)
        return key

    def exists(self, goal: Small) -> Key:
        """The node of "some instance of the goal is true"."""
        keys = [key for _, key in self.ask(goal)]
        return None if not keys else 0 if 0 in keys else self._either(keys)

    def tested(self, goal: Small) -> list[tuple[Small, Key]] | None:
        """As ``ask``; None where the engine cannot tell (a test of an unbound variable)."""
        try:
            return self.ask(goal)
        except ProbLogError:
            return None

    def choice(self, node: int) -> tuple[Choice, int] | None:
        """The choice that an atom of the formula belongs to, and which of its heads it is.

        None of the rest of a disjunction, and of a gate.
        """
        if node not in self.choices:
            content = self.formula.get_node(node)
            is_choice = type(content).__name__ == "atom" and not content.is_extra
            self.choices[node] = self.choice_of(content.identifier) if is_choice else None
        return self.choices[node]

    def choice_of(self, identifier: Any) -> tuple[Choice, int]:  # noqa: ANN401 - ProbLog's
        """From ProbLog's identity of a choice.

        (place of its clause in the database, values of the clause's variables, which head).
        """
        if not isinstance(identifier, tuple):
            raise ProgramError(
                "choices in a file that the program loads cannot be explained: put its clauses into the program itself"
            )
        place, values, head = identifier
        rule = self.rules.by_number[self.numbers[bisect_right(self.starts, int(place)) - 1]]
        known = tuple(small(value, {}) for value in values)
        key = (rule.number, tuple(canonical(v) for v in known))
        if key not in self.made:
            bound = dict(zip(rule.variables, known, strict=False))
            heads = tuple(resolved(head, bound) for head in rule.heads)
            labels = tuple(share_of(problog_term(resolved(label, bound))) for label in rule.labels)
            self.made[key] = Choice(*key, heads, labels)
        return self.made[key], int(head)


def bound_values(rule_variables: tuple[Ref, ...], instance: Small) -> dict[Ref, Small]:
    """What a rule's variables stand for in one of its instances."""
    return dict(zip(rule_variables, instance[1:], strict=True))


INTERNAL = "'plogic "
"""How the names of the rewritten program's own atoms begin."""


@dataclass(frozen=True)
class Tree:
    """One node of a proof.

    ``kind``: rule, fact, choice, check (a built-in test), absent (a negation that holds), computed (by the engine:
    findall/3 and the like), cases (no single proof is certain, but in every world one of these ways is open to it),
    case (one of them, and what it needs).
    """

    goal: Small
    kind: str
    children: "tuple[Tree, ...]" = ()


def choice_literal(ground: Grounding, choice: Choice, taken: int) -> Small:
    """The head that is taken; where none is, the negation of all of them.

    A clause with conditions is shown with them.
    """
    rule = ground.rules.by_number[choice.rule]
    body = body_goal(rule)
    if body is not None:
        body = resolved(body, dict(zip(rule.variables, choice.values, strict=False)))
    if taken != NONE_TAKEN:
        return (
            choice.heads[taken] if body is None or _tells(ground, choice, taken) else (":-", choice.heads[taken], body)
        )
    if all(_tells(ground, choice, i) for i in range(len(rule.heads))):
        body = None
    either = joined(";", list(choice.heads))
    if body is not None:
        return ("\\+", (":-", either, body))
    return joined(",", [("\\+", head) for head in choice.heads])


def _tells(ground: Grounding, choice: Choice, head: int) -> bool:
    """Whether the head alone tells the choice.

    No other rule gives it, and it names all that the rule's instances differ in; numbers that labels are computed from
    it need not name, where no other instance has the same head.
    """
    rule = ground.rules.by_number[choice.rule]
    named = set(refs(rule.heads[head]))
    if not all(v in named or isinstance(x, (int, float)) for v, x in zip(rule.variables, choice.values, strict=True)):
        return False
    if sum(choice.heads[head] in other.heads for other in ground.made.values() if other.rule == choice.rule) > 1:
        return False
    wanted = fresh(rule.heads[head])
    return sum(unify(other.heads[i], wanted, {}) for other, i in ground.rules.matching(wanted)) == 1


def body_goal(rule: Rule) -> Small | None:
    """The conditions of a rule as one goal; None of a fact."""
    goals = [("\\+", x.goal) if x.kind == "not" else x.goal for x in rule.literals]
    return joined(",", goals) if goals else None


def joined(mark: str, goals: list[Small]) -> Small:
    """``a, b, c`` as one goal."""
    result = goals[-1]
    for goal in reversed(goals[:-1]):
        result = (mark, goal, result)
    return result


def plain(tree: Tree, goal: Small) -> Tree:
    """A tree without the rewritten program's own atoms.

    The goal's wrapper gives way to what it wraps, or is named after it.
    """
    children = tuple(plain(child, goal) for child in tree.children)
    if not str(tree.goal[0]).startswith(INTERNAL):
        return Tree(tree.goal, tree.kind, children)
    return children[0] if len(children) == 1 and tree.kind == "rule" else Tree(goal, tree.kind, children)
