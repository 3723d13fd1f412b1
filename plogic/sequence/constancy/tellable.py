"""Which single data the views could have told about: had they been physical, another view would have seen them from aside."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.sequence.constancy.tracks import DEPTHS, MIN_PARALLAX

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.sequence.constancy.sight_lines import Sights
    from plogic.sequence.constancy.weights import Hidden

    Flags = NDArray[np.bool_]

STEPS = 24
"""Depths, evenly spaced in their logarithm, at which a datum's unknown place is tried."""
SHARE = 0.25
"""Share of these at which another view must have been able to tell. Noise is the more probable from the first of them
on; this leaves a margin."""


def tellable(sights: Sights, v: int, hidden: Hidden | None) -> Flags:
    """(N,) of the data of view ``v``: whether another view could have told.

    At a quarter of the depths or more where its place may be, some other view has it in its image, hidden by nothing
    known, along a line of sight that makes ``MIN_PARALLAX`` or more with its own.
    """
    count = len(sights.ids[v])
    depths = np.geomspace(*DEPTHS, STEPS)
    rays = np.column_stack([sights.xy[v, :count], np.ones(count)])
    points = (rays[:, None] * depths[:, None]).reshape(-1, 3)
    frame = np.linalg.inv(sights.camera_from_world[v])
    world = points @ frame[:3, :3].T + frame[:3, 3]
    told = sights.in_image(world)
    if hidden is not None:
        told &= ~np.stack([hidden(view.id, world) for view in sights.views], axis=-1)
    sight = world[:, None] - sights.eye
    sight /= np.maximum(np.linalg.norm(sight, axis=-1, keepdims=True), 1e-12)
    aside = np.einsum("pvi,pi->pv", sight, sight[:, v]) <= np.cos(MIN_PARALLAX)
    return np.asarray((told & aside).any(axis=1).reshape(count, STEPS).mean(axis=1) >= SHARE)
