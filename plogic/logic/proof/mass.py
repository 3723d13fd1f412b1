"""P(choices | evidence), exactly, from the compiled circuit; a column for each set of choices."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from plogic.logic.dnnf.compiled import Compiled
    from plogic.logic.grounding.ground_program import Literal
    from plogic.logic.proof.choices import Choice, Selection

COLUMNS = 256
"""Evaluations that the circuit does at once."""
MOST_PARTS = 4096
"""Disjoint parts into which a union of explanations is cut; where that does not suffice, its probability is an
interval."""


@dataclass
class Mass:
    """``heads[choice][i]``: the circuit's variable of the choice's i-th head, for those heads that anything asked depends on."""

    compiled: Compiled
    heads: Mapping[Choice, Mapping[int, int]]
    log_evidence: float = field(init=False)

    def __post_init__(self) -> None:
        self.log_evidence = float(self.compiled.log_mass([()])[0])

    def log_given(self, selections: Sequence[Selection]) -> list[float]:
        """Ln P(all these choices | evidence) of each selection; −inf where they contradict the evidence."""
        return self._log_given([self._condition(list(selection.items()), ()) for selection in selections])

    def _log_given(self, conditions: Sequence[tuple[list[Literal], float]]) -> list[float]:
        found: list[float] = []
        for start in range(0, len(conditions), COLUMNS):
            part = conditions[start : start + COLUMNS]
            masses = self.compiled.log_mass([literals for literals, _ in part]).tolist()
            found += [min(0.0, m + factor - self.log_evidence) for m, (_, factor) in zip(masses, part, strict=True)]
        return found

    def _condition(self, taken: list[tuple[Choice, int]], excluded: Sequence[int]) -> tuple[list[Literal], float]:
        """Literals, and the logarithm of the share that a head has of what the circuit does not tell apart."""
        literals: list[Literal] = [-v for v in excluded]
        factor = 0.0
        for choice, head in taken:
            known = self.heads[choice]
            if head in known:
                literals.append(known[head])
            else:
                literals += [-v for v in known.values()]
                factor += math.log(choice.probability(head)) - math.log(self._unknown(choice))
        return literals, factor

    def _unknown(self, choice: Choice) -> float:
        """P(none of the heads that the circuit knows)."""
        return math.fsum(choice.probability(i) for i in choice.domain if i not in self.heads[choice])

    def union(self, selections: Sequence[Selection]) -> tuple[float, float]:
        """P(at least one of these sets of choices | evidence), as an interval of one point unless it takes too many parts."""
        conditions: list[tuple[list[Literal], float]] = []
        done = self._parts([dict(s) for s in selections], [], [], conditions)
        if done:
            total = math.fsum(map(math.exp, self._log_given(conditions)))
            return min(1.0, total), min(1.0, total)
        each = [math.exp(p) for p in self.log_given(selections)]
        return max(each, default=0.0), min(1.0, math.fsum(each))

    def _parts(
        self,
        left: list[Selection],
        taken: list[tuple[Choice, int]],
        out: list[int],
        conditions: list[tuple[list[Literal], float]],
    ) -> bool:
        """Cut the union into disjoint conjunctions: along one choice, each head that some selection takes, and what is left."""
        if not left or len(conditions) > MOST_PARTS:
            return len(conditions) <= MOST_PARTS
        if any(not selection for selection in left):
            conditions.append(self._condition(taken, out))
            return True
        choice = max(_counts(left).items(), key=lambda item: (item[1], item[0].order))[0]
        others = [s for s in left if choice not in s]
        known = self.heads[choice]
        named = sorted({s[choice] for s in left if choice in s})
        if others and any(head not in known for head in named):
            named = sorted(choice.domain)
        for head in named:
            rest = [{c: i for c, i in s.items() if c != choice} for s in left if s.get(choice, head) == head]
            if not self._parts(rest, [*taken, (choice, head)], out, conditions):
                return False
        remaining = others if set(named) < choice.domain else []
        return self._parts(remaining, taken, [*out, *(known[h] for h in named if h in known)], conditions)


def _counts(selections: list[Selection]) -> dict[Choice, int]:
    counts: dict[Choice, int] = {}
    for selection in selections:
        for choice in selection:
            counts[choice] = counts.get(choice, 0) + 1
    return counts


def prior(selection: Selection) -> float:
    """The product of its choices' probabilities (ICL)."""
    return math.prod(choice.probability(taken) for choice, taken in selection.items())
