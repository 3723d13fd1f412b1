"""The most probable explanations of a goal, best first (§8): minimal sets of choices that entail it, ranked by P(choices | evidence).

A set of choices entails a goal if it contradicts every implicant of the goal's negation. So explanations are grown
choice by choice: take the most probable set so far; find a world in which it holds and the goal does not; from why the
goal fails there follow the choices of which an explanation must contain one. P(set | evidence) never rises when a
choice is added, so what comes first is the best, and nothing else needs to be enumerated; sets that contradict the
evidence have probability 0 and go at once. (An implicit hitting set search; the duality is Reiter's, 1987.)
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from plogic.logic.proof.choices import Allowed, Choice, Selection, contradicts, fixed, key_of
from plogic.logic.proof.cone import StoppedError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from plogic.logic.proof.cone import Cone

Entry = tuple[float, int, tuple[tuple[tuple[int, str], int], ...], float, Selection]


@dataclass
class Search:
    """``log_given`` weighs selections; ``wanted`` is the value of the cone's root that is to be explained.

    ``stopped`` says that the budget of steps was used up: ``bound`` is then the greatest P(choices | evidence) that a
    further explanation can have. ``pruned`` counts sets that contradict the evidence.
    """

    cone: Cone
    wanted: bool
    log_given: Callable[[list[Selection]], list[float]]
    stopped: bool = False
    bound: float = 0.0
    pruned: int = 0
    terms: list[Allowed] = field(default_factory=list)
    found: list[Selection] = field(default_factory=list)

    def explanations(self) -> Iterator[tuple[float, Selection]]:
        """(ln P(choices | evidence), choices), most probable first; ties by fewer choices, then as the program is written."""
        heap: list[Entry] = [(0.0, 0, (), 0.0, {})]
        seen: set[frozenset[tuple[Choice, int]]] = {frozenset()}
        while heap:
            entry = heapq.heappop(heap)
            _, _, _, p, selection = entry
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
        for known in self.terms:
            if not contradicts(selection, known):
                return known
        term = self.cone.counterexample(fixed(selection), not self.wanted)
        if term is not None:
            self.terms.append(term)
        return term

    def _is_minimal(self, selection: Selection) -> bool:
        for choice in selection:
            smaller = {c: taken for c, taken in selection.items() if c != choice}
            if self._open_term(smaller) is None:
                return False
        return True

    def _wider(self, selection: Selection, term: Allowed, seen: set[frozenset[tuple[Choice, int]]]) -> Iterator[Entry]:
        """The selection with each choice that contradicts the term."""
        made: list[Selection] = []
        for choice, allowed in sorted(term.items(), key=lambda item: item[0].order):
            if choice in selection:
                continue
            for head in sorted(choice.domain - allowed):
                wider = {**selection, choice: head}
                key = key_of(wider)
                if key not in seen:
                    seen.add(key)
                    made.append(wider)
        for wider, p in zip(made, self.log_given(made), strict=True):
            if p == -math.inf:
                self.pruned += 1
            else:
                order = tuple(sorted((choice.order, taken) for choice, taken in wider.items()))
                yield -rounded(p), len(wider), order, p, wider


def rounded(value: float) -> float:
    """To 11 digits: what differs by rounding only is a tie."""
    return float(f"{value:.11g}") if abs(value) > 1e-12 else 0.0
