"""All that there is to say of one goal: P(goal | evidence), why, why not, and what was missing; as plain data."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from plogic.logic.proof.best_explanations import Search, rounded
from plogic.logic.proof.choices import ordered
from plogic.logic.proof.cone import Steps
from plogic.logic.proof.consequences import Truth
from plogic.logic.proof.mass import prior
from plogic.logic.proof.plain_trees import failure_data, miss_data, missed, tree_data
from plogic.logic.proof.proof_trees import Trees
from plogic.logic.proof.reasons import Tree, choice_literal, plain
from plogic.logic.proof.relevant_evidence import numbers_of
from plogic.logic.proof.terms import resolved
from plogic.logic.proof.written_terms import text

if TYPE_CHECKING:
    from plogic.logic.proof.choices import Selection
    from plogic.logic.proof.ground_proofs import Grounding, Key
    from plogic.logic.proof.relevant_evidence import Numbers
    from plogic.logic.proof.terms import Small
    from plogic.logic.safety.atoms import Names

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
    """``goal`` as it was written, ``ask`` its atom in the rewritten program, with its answers; ``any``: the node of "there is one"."""

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
    """Searches and tells, once the numbers are there: literals 0, 1, ... are the answers', the last one is that of any of them."""

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
        """How probable it is that one of the explanations listed is the case, and what is left for all others together."""
        low, high = self.numbers.mass.union([f.selection for f in found]) if found else (0.0, 0.0)
        left = max(0.0, total - low)
        return {"listed": [low, max(low, min(high, total))], "unlisted": left if left > 1e-12 else 0.0}


def account(ground: Grounding, ask: Small, goal: Small, options: Options) -> Data:
    """The reply of ``plogic.logic.served.prove``. Raises InconsistentError, LimitError, and what ProbLog raises."""
    instances = ground.ask(ask)
    asked = Asked(goal, ask, instances, ground.exists(ask))
    steps = Steps(options.steps)
    numbers = numbers_of(ground, [*(key for _, key in instances), asked.any], steps)
    *chances, total = numbers.probabilities(numbers.literals)
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
