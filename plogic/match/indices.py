"""The search for a type, whichever kind it is: written by hand, or learned. The cycle asks nothing else of either."""

from __future__ import annotations

from math import log
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from plogic.base.clock import unhurried
from plogic.match.hand import generate as by_hand
from plogic.match.hand.coarse_pairs import MOST_PAIRS
from plogic.match.hand.type_index import TypeIndex, type_index
from plogic.match.judged.alike import distinct
from plogic.match.judged.evidence import evidence
from plogic.match.judged.settling import FEWEST
from plogic.match.learned import learned_poses as learned
from plogic.match.learned.learned_index import LearnedIndex, learned_index
from plogic.match.learned.learned_match import settle as settle_learned
from plogic.match.learned.learned_poses import NOBODY
from plogic.match.learned.lexicon import Lexicon, lexicon_of
from plogic.match.oriented.angle_refinement import Noise
from plogic.match.oriented.asked import Asked, chances_of
from plogic.match.oriented.oriented_match import settle as settle_oriented
from plogic.match.oriented.oriented_match import verified
from plogic.match.oriented.oriented_search import Search
from plogic.match.oriented.ready import ready
from plogic.match.plain import quadruples
from plogic.match.plain import softposit_poses as softposit

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.oriented.pair_index import PairIndex

Index: TypeAlias = TypeIndex | LearnedIndex
PLAIN = {"quadruples": quadruples.proposals, "softposit": softposit.proposals}
"""The plain generators of poses of a type written by hand: slow, and what the fast search is tested against."""
FAST = "index"
"""The generator of every day: the search by view cells and votes, which goes over all types at once where angles
count."""
GENERATORS = FAST, *PLAIN
"""Who may propose poses of types written by hand; learned types have their own."""
SURE = 5.0
"""Logarithm of the odds by which a type must explain its data better than clutter does, all its poses together: 150 to
1."""


def index_of(object_type: ObjectType, dv: Mapping[str, float], lexicon: Lexicon | None = None) -> Index:
    """The index of a type with at least one feature; a learned one without a ``lexicon`` has one of its own."""
    return learned_index(object_type, dv, lexicon) if object_type.learned is not None else type_index(object_type, dv)


def indices_of(
    kb: KnowledgeBase, dv: Mapping[str, float], folder: Path | None = None, generator: str = FAST
) -> tuple[dict[str, Index], PairIndex | None]:
    """The indices of all types that have features, of which the learned ones share one lexicon; and the index over those written by hand.

    Of these there is one where the angles of data say something, and the fast ``generator`` asks for it; ``folder``:
    where such are kept between runs.
    """
    types = sorted(kb.types, key=lambda t: t.name)  # of types that are equal in all but their names the first is found
    clouds = {t.name: t.learned for t in types if t.learned is not None and t.features}
    lexicon = lexicon_of(clouds, kb.words.centroids) if clouds and kb.words is not None else None
    by_hand = [t for t in types if t.learned is None and t.features]
    shared = ready(by_hand, dv, folder) if by_hand and kb.rates.sigma_angle is not None and generator == FAST else None
    known = {index.object_type.name: index for index in shared.indices} if shared is not None else {}
    return {t.name: known[t.name] if t.name in known else index_of(t, dv, lexicon) for t in types if t.features}, shared


def significant(posed: Hypothesis) -> float:
    """What a log-likelihood ratio must exceed, beyond what any pose has.

    Of a type written by hand the best of so many tries is good by luck: as many as there are pairs of appearances. Of a
    learned one, and where angles count, all poses are counted already.
    """
    return SURE if posed.object_type.learned is not None or posed.axes is not None else log(MOST_PAIRS)


def generate(
    index: Index,
    data: Data,
    kb: KnowledgeBase,
    covered: NDArray[np.bool_] | None = None,
    taken: NDArray[np.float64] = NOBODY,
    check: Callable[[], None] = unhurried,
    **most: int,
) -> list[tuple[float, Hypothesis]]:
    """The poses that Γ suggests, matched, best first, with their log-likelihood ratios; ``most``: ``refined``, ``verified``.

    ``covered`` (H, W): where accepted objects stand, which a type written by hand is told; ``taken`` (N, 4): their
    middles and inner radii, m, which a learned one is told. ``check`` is called between the stages of the search for one
    written by hand, and may raise to end it.
    """
    if isinstance(index, LearnedIndex):
        return learned.generate(index, data, kb, taken, **most)
    return by_hand.generate(index, data, kb, covered, **most, check=check)


def generate_plainly(
    generator: str,
    index: TypeIndex,
    data: Data,
    kb: KnowledgeBase,
    hidden_of: Callable[[Hypothesis], NDArray[np.bool_]],
    check: Callable[[], None] = unhurried,
) -> list[tuple[float, Hypothesis]]:
    """The poses that a plain ``generator`` (a key of ``PLAIN``) proposes of a type, verified by matching: as ``generate`` gives them.

    ``hidden_of`` tells (F,) which features of a hypothesis accepted objects hide. ``check`` is called between sets or
    starts, and before each pose is verified, and may raise to end the search.
    """
    found = []
    for pose in PLAIN[generator](index, data, kb, check):
        check()
        posed = settle(index, pose, data, kb, rounds=0)
        hidden = hidden_of(posed)
        posed = settle(index, pose if hidden.any() else posed, data, kb, hidden=hidden)
        if (posed.candidate & posed.detected & ~hidden).sum() >= FEWEST:
            found.append((evidence(posed, data, kb, hidden).ratio, posed))
    return distinct(sorted(found, key=lambda pair: -pair[0]), index.object_type)


def search_of(
    shared: PairIndex | None, data: Data, kb: KnowledgeBase, check: Callable[[], None] = unhurried
) -> Search | None:
    """The search for all types of an index in one Γ; None where there is no such index, or no datum has an angle.

    ``check`` is called between its stages, and may raise to end it.
    """
    if shared is None or kb.rates.sigma_angle is None or not np.isfinite(data.angle).any():
        return None
    return Search(
        Asked(shared, data, Noise(kb.rates.sigma, kb.rates.sigma_angle), chances_of(shared, kb.rates), check=check)
    )


def generate_together(
    search: Search,
    data: Data,
    kb: KnowledgeBase,
    hidden_of: Callable[[Hypothesis], NDArray[np.bool_]] | None = None,
    seen: Callable[[list[tuple[float, Hypothesis]]], None] | None = None,
) -> dict[str, list[tuple[float, Hypothesis]]]:
    """By type, the poses that some data of Γ suggest of all types at once, as ``generate`` gives them of one.

    ``hidden_of`` tells (F,) which features of a hypothesis accepted objects hide; ``seen`` is told each type's as soon
    as they are there, that of the best proposal first.
    """
    indices = search.index.indices
    poses: dict[int, list[NDArray[np.float64]]] = {}
    for proposal in search.proposals(data):
        poses.setdefault(proposal.kind, []).append(proposal.pose)
    result: dict[str, list[tuple[float, Hypothesis]]] = {index.object_type.name: [] for index in indices}
    for kind, some in poses.items():
        found = verified(indices[kind], some, data, kb, hidden_of, search.asked.check)
        result[indices[kind].object_type.name] = found
        if seen is not None:
            seen(found)
    return result


def settle(
    index: Index,
    pose: NDArray[np.float64] | Hypothesis,
    data: Data,
    kb: KnowledgeBase,
    *,
    free: NDArray[np.bool_] | None = None,
    hidden: NDArray[np.bool_] | None = None,
    rounds: int = 2,
) -> Hypothesis:
    """The type at a pose, or one that is matched there already: matched, refined, and matched again.

    ``free`` (A,) data that nobody else has claimed; ``hidden`` (F,) features that accepted opaque objects hide.
    """
    if isinstance(index, LearnedIndex):
        return settle_learned(index, pose, data, kb, free, hidden, rounds)
    written = settle_oriented if kb.rates.sigma_angle is not None else by_hand.settle
    return written(index, pose, data, kb, free, hidden, rounds)
