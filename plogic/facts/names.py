"""The table of names of one situation: each label with its atom (contract, "Names"; ``plogic.logic.safety.atoms``).

Generated atoms are ``f1`` for a feature's path and ``n1`` for the rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.facts.pair_facts import both_ways
from plogic.logic.safety.atoms import Names, own_atom

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from plogic.facts.hypothesis import Hypothesis
    from plogic.facts.situation import Situation


def names_of(situation: Situation) -> Names:
    """The table of one situation: deterministic, in the order in which the names appear there."""
    wanted = list(_labels(situation))
    taken = {label for label, _ in wanted if own_atom(label)}
    atoms: dict[str, str] = {}
    counters = {"f": 0, "n": 0}
    for label, kind in wanted:
        if label not in atoms:
            atoms[label] = label if own_atom(label) else _fresh(kind, counters, taken)
    return Names(atoms, {atom: label for label, atom in atoms.items()})


def _fresh(kind: str, counters: dict[str, int], taken: set[str]) -> str:
    while True:
        counters[kind] += 1
        atom = f"{kind}{counters[kind]}"
        if atom not in taken:
            return atom


def _labels(situation: Situation) -> Iterator[tuple[str, str]]:
    for hypothesis in situation.hypotheses:
        yield from ((label, "n") for label in (hypothesis.id, hypothesis.type, hypothesis.group))
        yield from _inner_labels(hypothesis)
    for appearance in situation.appearances:
        yield from ((label, "n") for label in (appearance.id, appearance.type))
    for table in (situation.dv, situation.rank, situation.priors):
        yield from ((label, "n") for label in table)
    for fact in (*situation.relations, *situation.part_relations):
        yield from _each((fact.relation, *both_ways(fact)))


def _inner_labels(hypothesis: Hypothesis) -> Iterator[tuple[str, str]]:
    for part in hypothesis.parts:
        yield part.id, "f"
        yield part.type, "n"
    for feature in hypothesis.features:
        yield feature.id, "f"
        yield feature.type, "n"


def _each(labels: Iterable[str]) -> Iterator[tuple[str, str]]:
    yield from ((label, "n") for label in labels)
