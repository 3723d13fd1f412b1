"""Random ground programs, and their meaning by brute force.

Every total choice, and its least model stratum by stratum.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

from hypothesis import strategies as st

ATOMS = 5
LABELS = ((0.3,), (0.6,), (0.2, 0.5), (0.4, 0.6), (0.1, 0.2, 0.3))


@dataclass(frozen=True)
class Clause:
    """``labels[i]::heads[i] :- body``; no labels: certain. ``body``: (atom, whether it is to be true)."""

    heads: tuple[int, ...]
    labels: tuple[float, ...]
    body: tuple[tuple[int, bool], ...]

    def text(self):
        """The clause as ProbLog reads it."""
        heads = (
            "; ".join(f"{p}::a{h}" for p, h in zip(self.labels, self.heads, strict=True))
            if self.labels
            else f"a{self.heads[0]}"
        )
        body = ", ".join(f"a{b}" if positive else f"\\+ a{b}" for b, positive in self.body)
        return f"{heads} :- {body}." if body else f"{heads}."


@st.composite
def programs(draw, most=6):
    """Up to ``most`` clauses; strata are pairs of atoms, a negation looks at lower ones only; cycles are positive."""
    clauses = []
    for _ in range(draw(st.integers(2, most))):
        labels = draw(st.one_of(st.just(()), st.sampled_from(LABELS)))
        heads = tuple(
            draw(
                st.lists(
                    st.integers(0, ATOMS - 1), min_size=max(1, len(labels)), max_size=max(1, len(labels)), unique=True
                )
            )
        )
        body = tuple(
            draw(st.lists(st.tuples(st.integers(0, ATOMS - 1), st.booleans()), max_size=3, unique_by=lambda b: b[0]))
        )
        clauses.append(Clause(heads, labels, tuple(b for b in body if _stratified(heads, b))))
    return tuple(clauses) + tuple(Clause((a,), (), ((a, True),)) for a in range(ATOMS))


def _stratified(heads, literal):
    atom, positive = literal
    return all(atom // 2 <= h // 2 if positive else atom // 2 < h // 2 for h in heads)


def model(clauses, taken):
    """The atoms that are true where clause i takes its ``taken[i]``-th head, −1 for none; strata are pairs of atoms."""
    true = set()
    for stratum in range(math.ceil(ATOMS / 2)):
        grown = True
        while grown:
            grown = False
            for clause, head in zip(clauses, taken, strict=True):
                if head < 0 or clause.heads[head] // 2 != stratum or clause.heads[head] in true:
                    continue
                if all((a in true) == positive for a, positive in clause.body):
                    true.add(clause.heads[head])
                    grown = True
    return frozenset(true)


def worlds(clauses):
    """(probability, taken, model) of every total choice of positive probability."""
    options = []
    for clause in clauses:
        if not clause.labels:
            options.append([(0, 1.0)])
            continue
        rest = 1.0 - sum(clause.labels)
        options.append([*enumerate(clause.labels), *([(-1, rest)] if rest > 1e-10 else [])])
    for combination in itertools.product(*options):
        taken = tuple(t for t, _ in combination)
        yield math.prod(p for _, p in combination), taken, model(clauses, taken)


def explanations(clauses, goal, *, wanted, evidence):
    """All minimal sets of choices that entail goal = wanted, with P(choices | evidence).

    Those of probability 0 are left out.
    """
    all_worlds = list(worlds(clauses))
    total = math.fsum(p for p, _, m in all_worlds if _agrees(m, evidence))
    choosing = [i for i, clause in enumerate(clauses) if clause.labels]
    domains = [sorted({taken[i] for _, taken, _ in all_worlds}) for i in choosing]
    found = []
    for size in range(len(choosing) + 1):
        for subset in itertools.combinations(range(len(choosing)), size):
            for values in itertools.product(*(domains[k] for k in subset)):
                selection = {choosing[k]: v for k, v in zip(subset, values, strict=True)}
                if any(smaller.items() <= selection.items() for smaller in found):
                    continue
                inside = [(p, m) for p, taken, m in all_worlds if all(taken[i] == v for i, v in selection.items())]
                if all((goal in m) == wanted for _, m in inside):
                    found.append(selection)
    return {frozenset(s.items()): _given(all_worlds, s, evidence) / total for s in found} if total > 0 else None


def _given(all_worlds, selection, evidence):
    return math.fsum(
        p for p, taken, m in all_worlds if _agrees(m, evidence) and all(taken[i] == v for i, v in selection.items())
    )


def _agrees(true, evidence):
    return all((atom in true) == value for atom, value in evidence)
