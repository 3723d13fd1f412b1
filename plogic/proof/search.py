"""Proofs of a goal, as trees down to facts and choices; and of its negation, as the choices that break every proof."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from plogic.errors import ProgramError
from plogic.proof.builtins import ARITHMETIC_TESTS, evaluate, holds
from plogic.proof.clauses import TRUE
from plogic.proof.selection import WIDEST, Choice, Selection, best, breaking, merged, probability
from plogic.proof.terms import Bindings, Small, is_ground, resolved, signature, unify

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.proof.clauses import Rule, Rules

DEEPEST = 400


@dataclass(frozen=True)
class Tree:
    """Why a goal holds, or fails: ``kind`` is rule, fact, choice, check, absent, or fails."""

    goal: Small
    kind: str
    children: tuple[Tree, ...] = ()


@dataclass(frozen=True)
class Proof:
    """One way to prove a goal: the goal with its variables bound, the choices that it rests on, the tree."""

    goal: Small
    selection: Selection
    tree: Tree


@dataclass
class Prover:
    """Proves goals over rules; remembers what it proved."""

    rules: Rules
    known: dict[Small, list[Proof]] = field(default_factory=dict)
    path: list[Small] = field(default_factory=list)
    cut: bool = False

    def prove(self, goal: Small) -> list[Proof]:
        """The most probable proofs of a goal, at most ``WIDEST`` for each way to bind its variables."""
        if goal in self.known:
            return self.known[goal]
        if goal in self.path or len(self.path) > DEEPEST:
            self.cut = True
            return []
        before, self.cut = self.cut, False
        self.path.append(goal)
        found = _thinned(list(self._ways(goal)))
        self.path.pop()
        if is_ground(goal) and not self.cut:
            self.known[goal] = found
        self.cut = before or self.cut
        return found

    def _ways(self, goal: Small) -> Iterator[Proof]:
        name = signature(goal)
        if name == (",", 2) or goal == TRUE:
            yield from (Proof(self._bound(goal, b), s, Tree(self._bound(goal, b), "rule", t)) for b, s, t in self.conjunction(goal, {}))
        elif name == (";", 2):
            yield from (Proof((goal[0], p.goal, p.goal), p.selection, p.tree) for side in goal[1:] for p in self.prove(side))
        elif name in (("\\+", 1), ("not", 1)):
            yield from self.refute(goal)
        elif name in ARITHMETIC_TESTS:
            bindings: Bindings = {}
            if holds(goal, bindings):
                yield Proof(resolved(goal, bindings), {}, Tree(resolved(goal, bindings), "check"))
        elif name not in self.rules.by_signature:
            raise ProgramError(f"explanations do not reach into {name[0]}/{name[1]}", file="explain")
        else:
            yield from self._by_rules(goal)

    def _by_rules(self, goal: Small) -> Iterator[Proof]:
        for rule, index in self.rules.matching(goal):
            fresh, bindings = rule.fresh(), Bindings()
            if unify(goal, fresh.heads[index], bindings):
                yield from self._by_rule(goal, fresh, index, bindings)

    def _by_rule(self, goal: Small, rule: Rule, index: int, bindings: Bindings) -> Iterator[Proof]:
        for bound, selection, children in self.conjunction(rule.body, bindings):
            done = resolved(goal, bound)
            if rule.labels[index] is None:
                yield Proof(done, selection, Tree(done, "fact" if rule.body == TRUE else "rule", children))
                continue
            choice = _choice(rule, bound)
            whole = merged(selection, {choice: index})
            if whole is not None and choice.probability(index) > 0:
                yield Proof(done, whole, Tree(done, "choice", children))

    def conjunction(self, goal: Small, bindings: Bindings) -> Iterator[tuple[Bindings, Selection, tuple[Tree, ...]]]:
        """Every way to prove a conjunction, from left to right."""
        if goal == TRUE:
            yield bindings, {}, ()
            return
        if signature(goal) == (",", 2):
            for bound, selection, trees in self.conjunction(goal[1], bindings):
                for further, more, others in self.conjunction(goal[2], bound):
                    whole = merged(selection, more)
                    if whole is not None:
                        yield further, whole, (*trees, *others)
            return
        wanted = resolved(goal, bindings)
        for proof in self.prove(wanted):
            bound = dict(bindings)
            if signature(wanted) == (";", 2) and not any(unify(side, proof.goal[1], bound) for side in wanted[1:]):
                continue
            if signature(wanted) == (";", 2) or unify(wanted, proof.goal, bound):
                yield bound, proof.selection, (proof.tree,)

    def refute(self, goal: Small) -> Iterator[Proof]:
        """Proofs of a negation: what breaks every proof of the goal under it."""
        proofs = self.prove(goal[1])
        for selection in breaking(proof.selection for proof in proofs):
            reasons = tuple(Tree(_taken(choice, taken), "choice") for choice, taken in selection.items())
            yield Proof(goal, selection, Tree(goal, "absent", reasons))

    @staticmethod
    def _bound(goal: Small, bindings: Bindings) -> Small:
        return resolved(goal, bindings)


def _choice(rule: Rule, bindings: Bindings) -> Choice:
    labels = tuple(1.0 if label is None else evaluate(resolved(label, bindings)) for label in rule.labels)
    heads = tuple(resolved(head, bindings) for head in rule.heads)
    return Choice(rule.number, tuple(resolved(v, bindings) for v in rule.variables), heads, labels, rule.body == TRUE)


def _taken(choice: Choice, taken: int) -> Small:
    """The head that is taken; where none is, the negation of all of them."""
    if taken >= 0:
        return choice.heads[taken]
    negations = [("\\+", head) for head in choice.heads]
    result: Small = negations[-1]
    for negation in reversed(negations[:-1]):
        result = (",", negation, result)
    return result


def literals(selection: Selection) -> list[Small]:
    """The choices of a selection as goals."""
    return [_taken(choice, taken) for choice, taken in selection.items()]


def _thinned(proofs: list[Proof]) -> list[Proof]:
    """For each instance of the goal the minimal, most probable proofs."""
    by_goal: dict[Small, list[Proof]] = {}
    for proof in proofs:
        by_goal.setdefault(proof.goal, []).append(proof)
    return [proof for same in by_goal.values() for proof in _minimal(same)]


def _minimal(proofs: list[Proof]) -> list[Proof]:
    if len(proofs) == 1:
        return proofs
    kept = best([proof.selection for proof in proofs])
    first = {frozenset(proof.selection.items()): proof for proof in reversed(proofs)}
    chosen = [first[frozenset(selection.items())] for selection in kept]
    return sorted(chosen, key=lambda proof: -probability(proof.selection))[:WIDEST]
