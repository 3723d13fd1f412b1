"""The peer of ``plogic bench many``.

Poselib's LO-RANSAC on the typed correspondences of every type, the most inliers first, data used once.

It gets its best: pairs that share a feature or a datum counted once, the tolerance of the KB, a type asked again when
another took data of its best pose, and the least number of inliers that is best over all scenes, chosen with the truth
known. It knows no lobes and nothing of A4.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.pairs import by_type, correspondences, different, ideal
from benchmarks.clutter.ransac import estimated
from benchmarks.recognition.peer import Candidate
from benchmarks.recognition.score import Found
from benchmarks.shared.processor import processor_seconds
from plogic.match.judged.expectation import FEWEST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.plain.quadruples import Typed
    from sensing.appearance import Gamma

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

ITERATIONS = 2000
"""Of RANSAC a type, at most: with one pair in six right it has drawn three right ones nine times by then."""
LEAST_INLIERS = tuple(range(FEWEST, 31))
"""Numbers of inliers at which an object may be accepted; all are tried."""


@dataclass(frozen=True, eq=False)
class _Best:
    candidate: Candidate
    data: Indices  # whose they are


def greedy(kb: KnowledgeBase, gamma: Gamma, limit: float) -> list[Candidate]:
    """The best pose of all types, then the best on the data that it leaves, and so on.

    What is not found within ``limit`` seconds is left out.
    """
    end = processor_seconds() + limit
    uv, data, free = ideal(gamma), by_type(gamma), np.ones(len(gamma.appearances), bool)
    pairs = [correspondences(kind, data) for kind in kb.types]
    best = [_best(some, uv, free, gamma, kb) for some in pairs]
    answer: list[Candidate] = []
    while processor_seconds() < end:
        which = max(range(len(best)), key=lambda i: _inliers(best[i]))
        top = best[which]
        if top is None:
            break
        answer.append(top.candidate)
        free[top.data] = False
        for i, other in enumerate(best):
            if other is not None and not free[other.data].all():
                best[i] = _best(pairs[i], uv, free, gamma, kb)
    return answer


def kept(candidates: Sequence[Candidate], least: int) -> list[Found]:
    """Those before the first with fewer than so many inliers: there it would have stopped."""
    few = next((i for i, candidate in enumerate(candidates) if candidate.inliers < least), len(candidates))
    return [candidate.found for candidate in candidates[:few]]


def _inliers(best: _Best | None) -> int:
    return 0 if best is None else best.candidate.inliers


def _best(pairs: Typed, uv: Floats, free: NDArray[np.bool_], gamma: Gamma, kb: KnowledgeBase) -> _Best | None:
    """The pose of most inliers among a type's pairs of free data; None where there are fewer than ``FEWEST``."""
    some = free[pairs.datum]
    left = pairs._replace(feature=pairs.feature[some], datum=pairs.datum[some])
    if len(np.unique(left.feature)) < FEWEST or len(np.unique(left.datum)) < FEWEST:
        return None
    pose, inlying, _ = estimated(left, uv, gamma.camera, kb, ITERATIONS)
    count = different(left, inlying)
    if count < FEWEST:
        return None
    return _Best(Candidate(Found(pairs.kind.name, pose), count), np.unique(left.datum[inlying]))
