"""The account of one goal: P(goal | evidence), why, why not, and the nearest misses; as plain data.

The most probable explanations of a goal come best first (§8): minimal sets of choices that entail it, ranked by
P(choices | evidence). A set of choices entails a goal if it contradicts every implicant of the goal's negation. So
explanations are grown choice by choice: take the most probable set so far; find a world in which it holds and the goal
does not; from why the goal fails there follow the choices of which an explanation must contain one. P(set | evidence)
never rises when a choice is added, so the first is the best, and nothing else needs to be enumerated; sets that
contradict the evidence have probability 0 and go at once. (An implicit hitting set search; the duality is Reiter's,
1987.)
"""

import heapq
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import reduce
from itertools import islice
from operator import or_
from typing import Any

from plogic.logic.proof.cone import (
    Allowed,
    Choice,
    Cone,
    Selection,
    Steps,
    StoppedError,
    fixed,
    key_of,
    ordered,
)
from plogic.logic.proof.ground_proofs import Grounding, Key, Tree, choice_literal, plain
from plogic.logic.proof.plain_trees import failure_data, miss_data, missed, tree_data
from plogic.logic.proof.proof_trees import Trees, Truth
from plogic.logic.proof.relevant_evidence import Numbers, numbers_of, prior
from plogic.logic.proof.terms import Small, resolved, text
from plogic.logic.safety.atoms import Names

Entry = tuple[float, int, tuple[tuple[tuple[int, str], int], ...], float, Selection]


@dataclass
class Search:
    """``log_given`` weighs selections; ``wanted`` is the value of the cone's root that is to be explained.

    ``stopped`` says that the budget of steps was used up: ``bound`` is then the greatest P(choices | evidence) that a
    further explanation can have. ``pruned`` counts sets that contradict the evidence. ``against``: the ``terms`` that
    a choice contradicts, as bits.
    """

    cone: Cone
    wanted: bool
    log_given: Callable[[list[Selection]], list[float]]
    stopped: bool = False
    bound: float = 0.0
    pruned: int = 0
    terms: list[Allowed] = field(default_factory=list)
    against: dict[tuple[Choice, int], int] = field(default_factory=dict)
    found: list[Selection] = field(default_factory=list)

    def explanations(self) -> Iterator[tuple[float, Selection]]:
        """(ln P(choices | evidence), choices), most probable first.

        Ties by fewer choices, then as the program is written.
        """
        heap: list[Entry] = [(0.0, 0, (), 0.0, {})]
        seen: set[frozenset[tuple[Choice, int]]] = {frozenset()}
        while heap:
            _, _, _, p, selection = heapq.heappop(heap)
            self.bound = math.exp(p)
            if any(smaller.items() <= selection.items() for smaller in self.found):
                continue
            try:
                term = self._open_term(selection)
                is_minimal = term is not None or self._is_minimal(selection)
            except StoppedError:
                self.stopped = True
                return
            if term is not None:
                for following in self._wider(selection, term, seen):
                    heapq.heappush(heap, following)
            elif is_minimal:
                self.found.append(selection)
                yield p, selection
        self.bound = 0.0

    def _open_term(self, selection: Selection) -> Allowed | None:
        """An implicant of the opposite that the selection does not contradict; None if it entails what is wanted."""
        contradicted = reduce(or_, (self.against.get(item, 0) for item in selection.items()), 0)
        first = (~contradicted & (contradicted + 1)).bit_length() - 1  # the lowest bit that is not set
        if first < len(self.terms):
            return self.terms[first]
        term = self.cone.counterexample(fixed(selection), not self.wanted)
        if term is not None:
            for item in ((choice, head) for choice, allowed in term.items() for head in choice.domain - allowed):
                self.against[item] = self.against.get(item, 0) | 1 << len(self.terms)
            self.terms.append(term)
        return term

    def _is_minimal(self, selection: Selection) -> bool:
        smaller = ({c: taken for c, taken in selection.items() if c != choice} for choice in selection)
        return all(self._open_term(less) is not None for less in smaller)

    def _wider(self, selection: Selection, term: Allowed, seen: set[frozenset[tuple[Choice, int]]]) -> Iterator[Entry]:
        """The selection with each choice that contradicts the term."""
        wider_ones = [
            {**selection, choice: head}
            for choice, allowed in sorted(term.items(), key=lambda item: item[0].order)
            if choice not in selection
            for head in sorted(choice.domain - allowed)
        ]
        made = [wider for wider in wider_ones if key_of(wider) not in seen]
        seen.update(map(key_of, made))
        for wider, p in zip(made, self.log_given(made), strict=True):
            if p == -math.inf:
                self.pruned += 1
            else:
                order = tuple(sorted((choice.order, taken) for choice, taken in wider.items()))
                yield -rounded(p), len(wider), order, p, wider


def rounded(value: float) -> float:
    """To 11 digits: what differs by rounding only is a tie."""
    return float(f"{value:.11g}") if abs(value) > 1e-12 else 0.0


Data = dict[str, Any]
IMPROBABLE = 0.5
"""A goal less probable than this is asked why not."""


@dataclass(frozen=True)
class Options:
    """``most`` explanations of each kind; ``steps``: nodes of the formula that one search may look at."""

    most: int
    steps: int
    names: Names | None


@dataclass(frozen=True)
class Asked:
    """``goal`` as it was written, ``ask`` its atom in the rewritten program, with its answers.

    ``any``: the node of "there is one".
    """

    goal: Small
    ask: Small
    instances: list[tuple[Small, Key]]
    any: Key

    def answer(self, i: int) -> Small:
        """The goal with the values of its i-th answer."""
        return resolved(self.goal, dict(zip(self.ask[1:], self.instances[i][0][1:], strict=True)))


@dataclass(frozen=True)
class Found:
    """One explanation of an answer; of the negated goal where ``answer`` is None."""

    log_given: float
    selection: Selection
    answer: int | None


@dataclass(frozen=True)
class Accountant:
    """Searches and tells, once the numbers are there.

    Literals 0, 1, ... are the answers', the last one is that of any of them.
    """

    ground: Grounding
    asked: Asked
    numbers: Numbers
    options: Options

    def why(self, chances: list[float]) -> tuple[list[Found], bool]:
        """The best explanations over all answers, and whether the search was stopped.

        Those of a less probable answer are looked for as long as they can be among the best.
        """
        best: list[Found] = []
        stopped = False
        for i in sorted(range(len(chances)), key=lambda i: (-rounded(chances[i]), i)):
            enough = len(best) >= self.options.most
            if chances[i] <= 0 or (enough and math.log(chances[i]) < best[self.options.most - 1].log_given - 1e-9):
                break
            more, cut = self.search(i, wanted=True)
            best, stopped = sorted([*best, *more], key=lambda f: -rounded(f.log_given)), stopped or cut
        return best[: self.options.most], stopped

    def search(self, answer: int | None, *, wanted: bool) -> tuple[list[Found], bool]:
        """Of one answer, or of none of them being true."""
        literal = self.numbers.literals[-1 if answer is None else answer]
        if not literal:
            return ([Found(0.0, {}, answer)] if (literal is not None) == wanted else []), False
        search = Search(self.numbers.cone(literal, Steps(self.options.steps)), wanted, self.numbers.mass.log_given)
        found = [Found(p, selection, answer) for p, selection in islice(search.explanations(), self.options.most)]
        return found, search.stopped

    def data(self, found: Found) -> Data:
        """An explanation with its tree."""
        names = self.options.names
        goal, tree = self._tree(found)
        return {
            "goal": text(goal, names),
            "probability": prior(found.selection),
            "given_evidence": math.exp(found.log_given),
            "choices": [
                text(choice_literal(self.ground, choice, taken), names) for choice, taken in ordered(found.selection)
            ],
            "tree": tree_data(tree, names),
        }

    def _tree(self, found: Found) -> tuple[Small, Tree]:
        trees = Trees(self.ground, Truth(self.ground, found.selection))
        if found.answer is None:
            denied = ("\\+", self.asked.goal)
            return denied, plain(trees.against(self.asked.goal, self.asked.any), denied)
        goal = self.asked.answer(found.answer)
        return goal, plain(trees.of(*self.asked.instances[found.answer]), goal)

    def covered(self, found: list[Found], total: float) -> Data:
        """How probable it is that one of the listed explanations is the case, and what is left for all others."""
        low, high = self.numbers.mass.union([f.selection for f in found]) if found else (0.0, 0.0)
        left = max(0.0, total - low)
        return {"listed": [low, max(low, min(high, total))], "unlisted": left if left > 1e-12 else 0.0}


def account(ground: Grounding, ask: Small, goal: Small, options: Options) -> Data:
    """The reply of ``plogic.logic.served.prove``. Raises InconsistentError, LimitError, and what ProbLog raises."""
    instances = ground.ask(ask)
    asked = Asked(goal, ask, instances, ground.exists(ask))
    numbers = numbers_of(ground, [*(key for _, key in instances), asked.any], Steps(options.steps))
    *chances, total = numbers.compiled.probabilities(numbers.literals)
    teller = Accountant(ground, asked, numbers, options)
    (why, cut), (why_not, cut_not) = teller.why(chances), teller.search(None, wanted=False)
    reply: Data = {
        "probability": max(chances, default=0.0),
        "answers": len(instances),
        "for": [teller.data(f) for f in why],
        "against": [teller.data(f) for f in why_not],
        "covered_for": {**teller.covered(why, total), "stopped": cut},
        "covered_against": {**teller.covered(why_not, 1.0 - total), "stopped": cut_not},
        "misses": [],
        "failure": None,
        "notes": [],
    }
    return reply if total >= IMPROBABLE else reply | _missing(ground, asked, options, possible=total > 0)


def _missing(ground: Grounding, asked: Asked, options: Options, *, possible: bool) -> Data:
    """The nearest misses of an improbable goal; of an impossible one, the condition that fails."""
    misses, notes = missed(ground, asked.goal, asked.ask, Steps(options.steps))
    told = [miss_data(miss, options.names) for miss in misses[: max(1, options.most)]]
    if len(misses) > len(told):
        notes.append(f"{len(misses) - len(told)} more distant misses are not listed")
    failure = None if possible else failure_data(asked.goal, misses, options.names)
    return {"misses": told, "failure": failure, "notes": notes}
