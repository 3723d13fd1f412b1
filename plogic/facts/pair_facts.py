"""A relation of ROC-20 as the facts of a situation: in the vocabulary of queries, of the ordered pair that it is said of (§3.6, §3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry.visibility.roc import ROC20, coarse, coarse_converse, converse
from plogic.facts.situation import PairFact

if TYPE_CHECKING:
    from geometry.visibility.roc import Roc

_FINE = {name: name for name in ROC20}


def pair_facts(relation: Roc, x: str, y: str, parts: tuple[str, str] = ("", "")) -> list[PairFact]:
    """A relation in the vocabulary of queries: ``x`` occluded by ``y`` is said of (y, x).

    What is its own converse when coarse, of both.
    """
    word, there, back = coarse(relation), (x, y, relation, parts), (y, x, converse(relation), parts[::-1])
    if word == coarse_converse(word):
        return [PairFact(word, *there), PairFact(word, *back)]
    if word.endswith("_occluded_by"):
        return [PairFact(coarse_converse(word), *back)]
    return [PairFact(word, *there)]


def both_ways(fact: PairFact) -> tuple[str, ...]:
    """The relation of ROC-20 of (x, y); and of (y, x), where no other fact tells it.

    None where the fact does not tell it.
    """
    if fact.roc not in _FINE:
        return ()
    other = converse(_FINE[fact.roc])
    return (fact.roc,) if coarse(other) == fact.relation else (fact.roc, other)
