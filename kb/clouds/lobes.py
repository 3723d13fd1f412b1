"""Lobes: from where a detector can see a feature's appearance (§2.7), and the vector pencils that they bound.

Vocabulary: ``LobeTable``, all L lobes of one type as arrays in the object's frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from kb.clouds.cloud import Feature

GRAIN = 1e-9
"""Slack of the cone's and the range's bounds, so that a viewpoint on a bound is inside."""


@dataclass(frozen=True, eq=False)
class LobeTable:
    """``feature`` (L,) index of the feature; ``types`` (L,) appearance types; ``at`` (L, 3) m and unit ``axis`` (L, 3), object frame;
    ``cos_half`` (L,); ``r_min``, ``r_max`` (L,) m at the reference focal length; ``features``, their number F; ``size`` (L,) m, NaN where unknown.
    """  # noqa: D205 - one table, one sentence

    feature: NDArray[np.intp]
    types: tuple[str, ...]
    at: NDArray[np.float64]
    axis: NDArray[np.float64]
    cos_half: NDArray[np.float64]
    r_min: NDArray[np.float64]
    r_max: NDArray[np.float64]
    features: int
    size: NDArray[np.float64]


def lobe_table(features: Sequence[Feature]) -> LobeTable:
    """Collect the lobes of all appearances of ``features``."""
    rows = [(f, feature, appearance) for f, feature in enumerate(features) for appearance in feature.appearances]
    lobes = [appearance.lobe for _, _, appearance in rows]
    axis = [feature.rotation @ appearance.lobe.axis for _, feature, appearance in rows]
    return LobeTable(
        feature=_frozen([f for f, _, _ in rows]).astype(np.intp),
        types=tuple(appearance.type for _, _, appearance in rows),
        at=_frozen([feature.at for _, feature, _ in rows]).reshape(-1, 3),
        axis=_frozen(axis).reshape(-1, 3),
        cos_half=_frozen([np.cos(lobe.half_angle) for lobe in lobes]),
        r_min=_frozen([lobe.r_min for lobe in lobes]),
        r_max=_frozen([lobe.r_max for lobe in lobes]),
        features=len(features),
        size=_frozen([lobe.size for lobe in lobes]),
    )


def _frozen(values: ArrayLike) -> NDArray[np.float64]:
    array: NDArray[np.float64] = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def in_lobe(table: LobeTable, viewpoints: ArrayLike, granularity: float | None = None) -> NDArray[np.bool_]:
    """(V, L): r_min ≤ |v−p| ≤ r_max and angle(v−p, axis) ≤ half-angle (§2.7).

    ``viewpoints`` (V, 3) m, object frame. ``granularity`` = f / f_ref scales the ranges: a longer lens sees as much
    from farther; None asks for the direction alone. A viewpoint at the feature itself is in no lobe.
    """
    view = np.asarray(viewpoints, dtype=float).reshape(-1, 1, 3) - table.at[None]
    distance = np.linalg.norm(view, axis=2)
    along = np.einsum("vli,li->vl", view, table.axis)
    inside = (along >= table.cos_half * distance - GRAIN) & (distance > GRAIN)
    if granularity is not None:
        inside &= (distance >= table.r_min * granularity - GRAIN) & (distance <= table.r_max * granularity + GRAIN)
    return np.asarray(inside)


def feature_in_lobe(table: LobeTable, viewpoints: ArrayLike, granularity: float | None = None) -> NDArray[np.bool_]:
    """(V, F): v is in one of the feature's lobes."""
    held = in_lobe(table, viewpoints, granularity)
    result = np.zeros((len(held), table.features), dtype=bool)
    for lobe, feature in enumerate(table.feature):
        result[:, feature] |= held[:, lobe]
    return result


def converge(
    table: LobeTable, features: Sequence[int], viewpoints: ArrayLike, granularity: float | None = None
) -> NDArray[np.bool_]:
    """(V,) which viewpoints lie in a lobe of every one of ``features``: the set is co-visible from there (*convergence*, §6.3)."""
    return np.asarray(feature_in_lobe(table, viewpoints, granularity)[:, list(features)].all(axis=1))


def vector_pencil(feature: Feature, viewpoints: ArrayLike) -> NDArray[np.float64]:
    """Lines of sight (N, 3) m, object frame, from the feature to those of ``viewpoints`` (V, 3) that lie in one of its lobes (§2.7)."""
    places = np.asarray(viewpoints, dtype=float).reshape(-1, 3)
    seen = feature_in_lobe(lobe_table([feature]), places, 1.0)[:, 0]
    return np.asarray(places[seen] - feature.at)
