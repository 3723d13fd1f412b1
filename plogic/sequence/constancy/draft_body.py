"""The body of a draft: the convex hull of its features, as far as what was seen allows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kb.surfaces.surface import Surface

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.sequence.constancy.sightings import SeenFeature

    Floats = NDArray[np.float64]

SIZES = (1.0, 0.95, 0.9, 0.85, 0.8, 0.7, 0.6, 0.5)
"""Of the hull, about its middle: the largest is taken that hides no feature from a place from which it was seen."""
ASTRAY = 0.05
"""Share of the sightings that it may hide all the same: of features that noise put deep inside."""
FLAT = 0.05
"""Least thickness of features that span a volume, as a share of their length."""
SLACK = 0.004
"""Share of the diameter within which a surface does not hide its own features, as in the engine."""


def draft_body(features: Sequence[SeenFeature], centroid: Floats) -> Surface | None:
    """The body in the draft's frame; None where the features span no volume, or no hull of half the size lets all be seen that was.

    A hull is too small where sides were not looked at, and too large where the body is hollow; features are known to
    some millimetres only, so that the hull itself would hide those that seem to lie a little inside.
    """
    at = np.array([feature.at for feature in features]) - centroid
    if len(at) < 4 or _thickness(at) < FLAT:
        return None
    hull = _hull(at)
    middle = hull.vertices.mean(axis=0)
    for size in SIZES:
        body = Surface(middle + size * (hull.vertices - middle), hull.triangles)
        if _keeps_to_what_was_seen(body, features, centroid):
            return body
    return None


def _thickness(at: Floats) -> float:
    """The extent (N, 3) along the thinnest axis, as a share of that along the longest."""
    axes = np.linalg.svd(at - at.mean(axis=0), full_matrices=False)[2]
    extents = np.ptp(at @ axes.T, axis=0)
    return float(extents.min() / max(extents.max(), 1e-12))


def _hull(at: Floats) -> Surface:
    import trimesh

    hull = trimesh.convex.convex_hull(at)
    return Surface(np.asarray(hull.vertices), np.asarray(hull.faces))


def _keeps_to_what_was_seen(body: Surface, features: Sequence[SeenFeature], centroid: Floats) -> bool:
    slack = SLACK * body.diameter
    hidden = [
        body.rays.blocks(sighting.eye - centroid, (feature.at - centroid)[None], slack)[0]
        for feature in features
        for sighting in feature.sightings
    ]
    return sum(hidden) <= ASTRAY * len(hidden)
