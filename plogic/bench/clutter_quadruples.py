"""A peer of ``plogic bench clutter``: the paper's sets of four with POSIT (formalism §6.1, §6.3), type by type."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.posit import posit
from kb.lobes import feature_in_lobe
from plogic.bench.clutter_pairs import FEWEST, different, ideal, refined, typed
from plogic.bench.processor import processor_seconds
from plogic.measures.distinctiveness import distinctiveness, instance_counts

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from kb.cloud import KnowledgeBase
    from plogic.bench.clutter_pairs import Answer, Typed
    from sensing.appearance import Gamma

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

DRAWN, POSED = 2000, 1000
"""Sets of four that are drawn a type and round, and those of them, of highest dv, that POSIT is asked about."""
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
    """Random sets of four co-visible features that are not coplanar, each with a datum that looks like it, and POSIT; the most inliers win.

    Rounds over all types, most pairs first, until the time is over; in each the sets of highest dv. It gets its best: inliers by the KB's
    tolerance, features and data counted once, and in the end the best pose is refined on them, for four noisy points fix none well.
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


def _round(pairs: Typed, dv: Mapping[str, float], gamma: Gamma, kb: KnowledgeBase, rng: np.random.Generator) -> _Best | None:
    """The best of a type's next sets, None where none has enough inliers."""
    feature, datum = _sets(pairs, dv, rng)
    uv, camera = ideal(gamma), gamma.camera
    found = posit(pairs.points[feature], camera.normalised(gamma.uv)[datum], noise=kb.rates.sigma / camera.f, max_turn=MOST_TURNED)
    poses = found.camera_from_object[found.ok]
    off = _off(poses, pairs, uv, camera)
    near = off <= kb.rates.match_tolerance
    rows = []
    for i in np.argsort(-near.sum(axis=1), kind="stable")[:COUNTED]:
        inlying = np.flatnonzero(near[i])
        count = different(pairs, inlying)
        if count >= FEWEST:
            rows.append(_Best(count, float(off[i, inlying].mean()), pairs, inlying, poses[i]))
    return max(rows, key=lambda row: (row.inliers, -row.off), default=None)


def _sets(pairs: Typed, dv: Mapping[str, float], rng: np.random.Generator) -> tuple[Indices, Indices]:
    """Features (N, 4) and data (N, 4) of sets, highest dv first."""
    count = np.bincount(pairs.feature, minlength=len(pairs.points))
    first = np.cumsum(count) - count
    views = rng.normal(size=(VIEWS, 3))
    seen = feature_in_lobe(pairs.kind.lobes, pairs.points.mean(axis=0) + FAR * views / np.linalg.norm(views, axis=1, keepdims=True)) & (count > 0)
    seen = seen[seen.sum(axis=1) >= FEWEST]
    if not len(seen):
        return np.zeros((0, 4), np.intp), np.zeros((0, 4), np.intp)
    lots = np.where(seen[rng.integers(len(seen), size=DRAWN)], rng.random((DRAWN, len(count))), -1.0)
    feature = np.argpartition(-lots, 3, axis=1)[:, :4]
    datum = pairs.datum[first[feature] + rng.integers(count[feature])]
    ordered = np.sort(datum, axis=1)
    apart = np.flatnonzero((ordered[:, 1:] != ordered[:, :-1]).all(axis=1))
    worth = np.array([dv[f.type] for f in pairs.kind.features])[feature[apart]].sum(axis=1)
    chosen = apart[np.argsort(-worth, kind="stable")[:POSED]]
    return feature[chosen], datum[chosen]


def _off(poses: Floats, pairs: Typed, uv: Floats, camera: Camera) -> Floats:
    """(N, P) pixels from where N poses show the pairs' features to their data; infinite behind the camera."""
    at = np.einsum("nij,fj->nfi", poses[:, :3, :3], pairs.points) + poses[:, None, :3, 3]
    depth = np.where(at[..., 2] > 0.0, at[..., 2], np.nan)
    shown = camera.to_pixels(at[..., :2] / depth[..., None])
    return np.nan_to_num(np.linalg.norm(shown[:, pairs.feature] - uv[pairs.datum], axis=2), nan=np.inf)
