"""A peer of ``plogic bench clutter``: the paper's sets of four with POSIT (formalism §6.1, §6.3), type by type.

Sets, POSIT and what is near are those of the plain generator; who is asked for how long, and who wins, is the bench's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.clutter.pairs import different, ideal, refined, typed
from benchmarks.shared.processor import processor_seconds
from kb.clouds.lobes import feature_in_lobe
from plogic.match.judged.expectation import FEWEST
from plogic.match.plain.quadruples import drawn, off, posed
from plogic.measures.distinctiveness import distinctiveness, instance_counts

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from benchmarks.clutter.pairs import Answer
    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.plain.quadruples import Typed
    from sensing.appearance import Gamma

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

VIEWS = 64
"""Viewpoints that are drawn a type and round; a set is of features that one of them sees."""
FAR = 10.0
"""Metres from the object to a viewpoint."""
MOST_TURNED = 0.5
"""Radians by which the noise may turn a set's pose: POSIT's own bound leaves few sets."""
COUNTED = 5
"""Poses a round whose inliers are counted one by one: those with the most pairs."""


class _Best(NamedTuple):
    inliers: int
    off: float  # pixels, their mean distance
    pairs: Typed
    inlying: Indices
    pose: Floats


def quadruples(kb: KnowledgeBase, gamma: Gamma, budget_seconds: float) -> Answer | None:
    """Random sets of four co-visible features that are not coplanar, each with a datum that looks like it, and POSIT.

    The most inliers win.

    Rounds over all types, most pairs first, until the time is over; in each the sets of highest dv. It gets its best:
    inliers by the KB's tolerance, features and data counted once, and in the end the best pose is refined on them, for
    four noisy points fix none well.
    """
    end = processor_seconds() + budget_seconds
    kinds, dv, rng = typed(kb, gamma), distinctiveness(instance_counts(kb.types)), np.random.default_rng(0)
    best: _Best | None = None
    while kinds and processor_seconds() <= end:
        for pairs in kinds:
            if processor_seconds() > end:
                break
            found = _round(pairs, dv, gamma, kb, rng)
            if found is not None and (best is None or (found.inliers, -found.off) > (best.inliers, -best.off)):
                best = found
    if best is None:
        return None
    feature, datum = best.pairs.feature[best.inlying], best.pairs.datum[best.inlying]
    return best.pairs.kind.name, refined(best.pose, best.pairs.points[feature], datum, gamma, kb)


def _round(
    pairs: Typed, dv: Mapping[str, float], gamma: Gamma, kb: KnowledgeBase, rng: np.random.Generator
) -> _Best | None:
    """The best of a type's next sets, None where none has enough inliers."""
    worth = np.array([dv[f.type] for f in pairs.kind.features])
    feature, datum = drawn(pairs, _seen(pairs, rng), worth, rng)
    uv, camera = ideal(gamma), gamma.camera
    poses = posed(pairs, camera.normalised(gamma.uv), feature, datum, kb.rates.sigma / camera.f, MOST_TURNED)
    apart = off(poses, pairs, uv, camera)
    near = apart <= kb.rates.match_tolerance
    rows = []
    for i in np.argsort(-near.sum(axis=1), kind="stable")[:COUNTED]:
        inlying = np.flatnonzero(near[i])
        count = different(pairs, inlying)
        if count >= FEWEST:
            rows.append(_Best(count, float(apart[i, inlying].mean()), pairs, inlying, poses[i]))
    return max(rows, key=lambda row: (row.inliers, -row.off), default=None)


def _seen(pairs: Typed, rng: np.random.Generator) -> NDArray[np.bool_]:
    """(``VIEWS``, F) what lobes show from random viewpoints all around."""
    views = rng.normal(size=(VIEWS, 3))
    return feature_in_lobe(
        pairs.kind.lobes, pairs.points.mean(axis=0) + FAR * views / np.linalg.norm(views, axis=1, keepdims=True)
    )
