"""Lobes: from where a detector can see a feature's appearance (§2.7), and the vector pencils that they bound.

Vocabulary: ``LobeTable``, all L lobes of one type as arrays in the object's frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

GRAIN = 1e-9
"""Slack of the cone's and the range's bounds, so that a viewpoint on a bound is inside."""


def freeze(holder: object, **shapes: tuple[int, ...]) -> None:
    """Turn the named fields into read-only float arrays of the given shapes."""
    for name, shape in shapes.items():
        array = np.array(getattr(holder, name), dtype=float).reshape(shape)
        array.setflags(write=False)
        object.__setattr__(holder, name, array)


@dataclass(frozen=True, eq=False)
class Lobe:
    """What the detector can see of an appearance (§2.7): unit ``axis`` (3,) in the feature's frame, ``half_angle`` rad, range in m.

    ``size``: how wide it is that the detector reports, m, by which a datum's ``scale`` tells the distance; NaN where
    nobody said.
    """

    axis: NDArray[np.float64]
    half_angle: float
    r_min: float
    r_max: float
    size: float = float("nan")

    def __post_init__(self) -> None:
        freeze(self, axis=(3,))


@dataclass(frozen=True, eq=False)
class FeatureAppearance:
    """One appearance of a feature: what detectors report, and its viewpoints (the second slot of Φ, §2.1)."""

    type: str
    lobe: Lobe


@dataclass(frozen=True, eq=False)
class Feature:
    """One feature.

    ``at`` (3,) m and ``rotation`` (3, 3) = object_from_feature, object frame; ``name`` is its path in the tree.

    ``arms`` (K, 3): unit directions, object frame, of the surface's edges that meet here. ``parts`` names the features
    of a compound.
    """

    name: str
    type: str
    at: NDArray[np.float64]
    rotation: NDArray[np.float64]
    appearances: tuple[FeatureAppearance, ...]
    arms: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    parts: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, at=(3,), rotation=(3, 3), arms=(-1, 3))


@dataclass(frozen=True, eq=False)
class LobeTable:
    """``feature`` (L,) index of the feature; ``types`` (L,) appearance types.

    ``at`` (L, 3) m and unit ``axis`` (L, 3), object frame;
    ``cos_half`` (L,); ``r_min``, ``r_max`` (L,) m at the reference focal length; ``features``, their number F; ``size``
    (L,) m, NaN where unknown.
    """

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
