"""The search for a type, whichever kind it is: written by hand, or learnt. The cycle asks nothing else of either."""

from __future__ import annotations

from math import log
from typing import TYPE_CHECKING, TypeAlias

from plogic.search import generate as by_hand
from plogic.search.learnt import generate as learnt
from plogic.search.learnt.index import LearntIndex, learnt_index
from plogic.search.learnt.pairs import SEEDS
from plogic.search.learnt.settle import settle as settle_learnt
from plogic.search.pairs import MOST_PAIRS
from plogic.search.type_index import TypeIndex, type_index

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from kb.cloud import KnowledgeBase, ObjectType
    from plogic.expectation import Posed
    from plogic.search.data import Data

Index: TypeAlias = TypeIndex | LearntIndex
TYPES = 20.0
"""Learnt types that an image is searched for, about."""


def index_of(object_type: ObjectType, dv: Mapping[str, float]) -> Index:
    """The index of a type with at least one feature."""
    return learnt_index(object_type, dv) if object_type.learnt is not None else type_index(object_type, dv)


def significant(index: Index) -> float:
    """What a log-likelihood ratio must exceed, beyond what fixes a pose: the best of so many tries is good by luck.

    Tries: the pairs of appearances; or, of a learnt type, any three of its pairs, which fix a pose.
    """
    return log(TYPES * SEEDS**3) if isinstance(index, LearntIndex) else log(MOST_PAIRS)


def generate(index: Index, data: Data, kb: KnowledgeBase, covered: NDArray[np.bool_] | None = None, **most: int) -> list[tuple[float, Posed]]:
    """The poses that Γ suggests, matched, best first, with their log-likelihood ratios; ``most``: ``refined``, ``verified``.

    ``covered`` (H, W): where accepted objects stand. A learnt type needs no telling: what they claim is not in ``data``.
    """
    if isinstance(index, LearntIndex):
        return learnt.generate(index, data, kb, **most)
    return by_hand.generate(index, data, kb, covered, **most)


def settle(
    index: Index,
    pose: NDArray[np.float64],
    data: Data,
    kb: KnowledgeBase,
    *,
    free: NDArray[np.bool_] | None = None,
    hidden: NDArray[np.bool_] | None = None,
    rounds: int = 2,
) -> Posed:
    """The type at a pose: matched, refined, and matched again.

    ``free`` (A,) data that nobody else has claimed; ``hidden`` (F,) features that accepted opaque objects hide.
    """
    if isinstance(index, LearntIndex):
        return settle_learnt(index, pose, data, kb, free, hidden, rounds)
    return by_hand.settle(index, pose, data, kb, free, hidden, rounds)
