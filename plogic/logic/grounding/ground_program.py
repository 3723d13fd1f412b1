"""The ground program as plain data: gates over choices, the alternatives, what is asked and what is observed.

ProbLog grounds; from here on nothing of ProbLog is needed. Vocabulary:

* a *variable* is a number from 1; a *literal* is a variable or its negative; ``TRUE`` and ``FALSE`` stand for constants
* ``Gate("and", (3, -5))``, one per derived variable
* ``Alternative((1, 2), (0.3, 0.5), rest=0.2)``: at most one of its variables is true, none of them with probability
  ``rest``
"""

import math
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

from problog.errors import InconsistentEvidenceError, InvalidValue, ProbLogError
from problog.formula import LogicDAG, LogicFormula
from problog.logic import Term

from plogic.base.bounds import SLACK
from plogic.base.walk import by_key
from plogic.logic.safety.labels import NOT_HERE, adding_up

TRUE = 0
FALSE = None
Literal = int | None
"""A variable (positive), its negation (negative), TRUE or FALSE: the keys of ProbLog's formulas."""


def negated(literal: Literal) -> Literal:
    """The literal that holds exactly where this one does not."""
    return TRUE if literal is FALSE else FALSE if literal == TRUE else -literal


class Gate(NamedTuple):
    """``kind`` is "and" or "or"; a "free" variable has no children and weighs 1 either way."""

    kind: str
    children: tuple[Literal, ...]

    def folded(self) -> tuple[int, ...] | Literal:
        """The children without constants, of which there is at least one; TRUE or FALSE where the gate is constant."""
        absorbing, neutral = (FALSE, TRUE) if self.kind == "and" else (TRUE, FALSE)
        if absorbing in self.children:
            return absorbing
        return tuple(child for child in self.children if child) or neutral


class Choice(NamedTuple):
    """A choice with its probability; of the alternative ``group``. ``name`` makes its head when it is wanted.

    ``number``: which of the heads that the clause has it is.
    """

    share: float
    group: Hashable
    name: Callable[[], Any]
    number: int = 0


Node = Gate | Choice


@dataclass(frozen=True)
class Alternative:
    """A set of mutually exclusive choices: ``variables[i]`` with ``shares[i]``, none of them with ``rest``.

    Σ shares + rest = 1.

    ``names[i]`` makes the name of a choice, its head. ``group`` and ``numbers[i]`` are the same whatever is asked of a
    program, as long as the same grounder grounds it.
    """

    variables: tuple[int, ...]
    shares: tuple[float, ...]
    rest: float
    names: tuple[Callable[[], Term], ...]
    group: Hashable = None
    numbers: tuple[int, ...] = ()


@dataclass(frozen=True)
class Ground:
    """A ground program.

    ``size``: number of variables; ``gates``: derived variable → its gate; ``asked``: name and literal of each query, in
    the order of the program; ``observed``: literals that the evidence makes true. Variables in neither ``gates`` nor
    ``alternatives`` are free: they weigh 1 either way. ``cyclic``: some gates depend on themselves, and
    mean the least fixed point; else children have smaller numbers than their parents.
    """

    size: int
    gates: dict[int, Gate]
    alternatives: tuple[Alternative, ...]
    asked: tuple[tuple[Term, Literal], ...]
    observed: tuple[int, ...]
    cyclic: bool = False


class NamedFormula(LogicFormula):  # type: ignore[misc]
    """A formula whose choices keep their names, whatever else they turn out to be.

    A rule's head that holds just where a choice does, a query.
    """

    def __init__(self, database: Any = None, **options: Any) -> None:  # noqa: ANN401 - a ClauseDB
        super().__init__(**options)
        self._database = database

    def add_name(self, name: Any, key: Any, label: Any = None, keep_name: bool = False) -> None:  # noqa: ANN401, FBT001, FBT002 - as ProbLog's
        """As ProbLog's."""
        named = key is not None and key != 0 and self.get_node(abs(key)).name is not None
        choice = named and type(self.get_node(abs(key))).__name__ == "atom"
        super().add_name(name, key, label, keep_name=keep_name or choice)


def ground_of(formula: LogicFormula, *, cyclic: bool = False) -> Ground:
    """What the queries and the evidence of ProbLog's formula depend on; its cycles are broken, unless ``cyclic``.

    Raises ProbLog's InconsistentEvidenceError where evidence is a constant that contradicts it, InvalidValue for labels
    that are no probabilities.
    """
    observed = [(name, key if sign > 0 else formula.negate(key)) for name, key, sign in formula.evidence_all() if sign]
    asked = [(name, key) for name, key, _ in formula.labeled()]
    found = ground_from(lambda i: _converted(formula, i), asked, observed, cyclic=cyclic)
    if found is None:
        dag = LogicDAG.create_from(formula)
        dag._database = formula.database  # noqa: SLF001 - it tells where labels stand
        return ground_of(dag)
    return found


def ground_from(
    node: Callable[[int], Node],
    asked: Iterable[tuple[Term, Literal]],
    observed: Iterable[tuple[Any, Literal]],
    *,
    cyclic: bool = False,
) -> Ground | None:
    """The nodes under what is asked and observed, numbered anew, children before parents.

    None if they are cyclic and may not be.
    """
    asked, observed = list(asked), list(observed)
    impossible = next((name for name, literal in observed if literal is FALSE), None)
    if impossible is not None:
        raise InconsistentEvidenceError(source=f"evidence({impossible})")
    nodes, cycles = _children_first(node, [abs(literal) for _, literal in (*asked, *observed) if literal])
    if cycles and not cyclic:
        return None
    number = {old: new for new, old in enumerate(nodes, start=1)}

    def literal_of(key: Literal) -> Literal:
        return key if not key else number[key] if key > 0 else -number[-key]

    gates = {
        number[i]: Gate(n.kind, tuple(literal_of(c) for c in n.children))
        for i, n in nodes.items()
        if isinstance(n, Gate) and n.kind != "free"
    }
    choices = [(number[i], n) for i, n in nodes.items() if isinstance(n, Choice)]
    evidence = tuple(dict.fromkeys(lit for lit in (literal_of(key) for _, key in observed) if lit))
    return Ground(
        len(nodes),
        gates,
        _alternatives(choices),
        tuple((name, literal_of(key)) for name, key in asked),
        evidence,
        cycles,
    )


def _children_first(node: Callable[[int], Node], roots: Iterable[int]) -> tuple[dict[int, Node], bool]:
    """The nodes under the roots, children first, ties in the order of the roots; and whether they are cyclic."""
    cyclic = False
    done: dict[int, Node] = {}
    open_: dict[int, Node] = {}
    for root in roots:
        stack = [root]
        while stack:
            top = stack[-1]
            if top in done:
                stack.pop()
            elif top in open_:
                stack.pop()
                done[top] = open_.pop(top)
            else:
                content = open_[top] = node(top)
                children = [abs(c) for c in content.children if c] if isinstance(content, Gate) else []
                cyclic = cyclic or any(child in open_ for child in children)
                stack.extend(child for child in reversed(children) if child not in done and child not in open_)
    return done, cyclic


def gate_of(content: Any) -> Gate | None:  # noqa: ANN401 - a node of ProbLog's
    """The gate that a node of ProbLog's formula is; None of an atom with a probability: a choice."""
    kind = type(content).__name__
    if kind != "atom":
        return Gate("and" if kind == "conj" else "or", tuple(content.children))
    return Gate("free", ()) if content.is_extra or content.probability is True else None


def _converted(formula: LogicFormula, i: int) -> Node:
    content = formula.get_node(i)
    gate = gate_of(content)
    if gate is not None:
        return gate
    name = content.name
    head = (
        name.args[2]
        if name is not None and name.functor == "choice" and len(name.args) > 2
        else _placed(name, content, formula.database)
    )
    group, number = ("fact", content.identifier), 0
    if content.group is not None:
        group, number = ("group", content.group), int(content.identifier[-1])
    return Choice(share_of(content.probability, head), group, lambda: head, number)


def _placed(name: Any, content: Any, database: Any) -> Any:  # noqa: ANN401 - ProbLog's
    """The name of a fact with the place where it stands."""
    number = content.identifier
    if (
        name is None
        or database is None
        or name.location is not None
        or not isinstance(number, int)
        or not 0 <= number < len(database)
    ):
        return name
    return Term(name.functor, *name.args, location=getattr(database.get_node(number), "location", None))


def _alternatives(choices: list[tuple[int, Choice]]) -> tuple[Alternative, ...]:
    return tuple(map(_alternative, by_key((choice.group, (variable, choice)) for variable, choice in choices).values()))


def _alternative(members: list[tuple[int, Choice]]) -> Alternative:
    shares = tuple(choice.share for _, choice in members)
    rest = 1.0 - math.fsum(shares)
    if rest < -1e-12:
        place = next(
            (name.location for name in (choice.name() for _, choice in members) if getattr(name, "location", None)),
            None,
        )
        raise InvalidValue(adding_up(math.fsum(shares)), location=place)
    if len(members) > 1 and rest < SLACK:
        rest = 0.0
    return Alternative(
        tuple(variable for variable, _ in members),
        shares,
        max(rest, 0.0),
        tuple(choice.name for _, choice in members),
        members[0][1].group,
        tuple(choice.number for _, choice in members),
    )


def share_of(label: Any, head: Any = None) -> float:  # noqa: ANN401 - terms of ProbLog's
    """The label of a head as a probability; what ProbLog accepts around 0 and 1 is rounded to them."""
    own, location = getattr(label, "location", None), getattr(head, "location", None)
    location = own if own and (not location or own[0] == location[0]) else location  # a fact of another file is right
    try:
        value = float(label)
    except (ProbLogError, ArithmeticError, TypeError, ValueError):
        why = NOT_HERE.get(str(getattr(label, "functor", "")), "it is no number")
        raise InvalidValue(f"{label} is not a probability: {why}", location=location) from None
    if not -1e-9 <= value <= 1.0 + 1e-9:
        raise InvalidValue(f"{label} is not a probability: it must be from 0 to 1", location=location)
    return min(max(value, 0.0), 1.0)
