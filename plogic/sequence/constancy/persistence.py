"""That a feature persists: how probable it is to be detected in these views and missed in those, if its lobe is not known (§2.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

AXES = 96
"""Directions, spread evenly, that the unknown lobe's axis may have."""
HALF_ANGLES = tuple(np.radians([60.0, 75.0, 90.0, 110.0]).tolist())
"""Half-angles, each as probable, that it may have: a mark on a wall is seen from within about 75 degrees, a corner from
farther round."""
CHUNK = 1000
"""Tracks at a time: memory stays small."""


def log_pattern(towards: Floats, in_view: Flags, detected: Flags, hit: Floats) -> Floats:
    """(T,) ln of P(detected so, in the views where the place is in view) / P(detected in a given one).

    ``towards`` (T, V, 3): unit directions from the place to the cameras; ``in_view`` (T, V): in the image and hidden by
    nothing that is known; ``detected`` (T, V); ``hit`` (T,). The lobe is unknown: the mean over its axis and
    half-angle. Its own body hides a feature from outside of its lobe, so that a miss far round the object costs little,
    and one between two detections much.
    """
    parts = [slice(start, start + CHUNK) for start in range(0, len(towards), CHUNK)]
    return np.concatenate([np.zeros(0), *(_some(towards[p], in_view[p], detected[p], hit[p]) for p in parts)])


def _some(towards: Floats, in_view: Flags, detected: Flags, hit: Floats) -> Floats:
    cosine = (towards @ _directions().T).astype(np.float32)  # (T, V, A)
    h = hit[:, None, None].astype(np.float32)
    total = np.zeros(len(towards))
    for half in HALF_ANGLES:
        seen = np.where(cosine >= np.cos(half), h, np.float32(0.0))
        factor = np.where(detected[..., None], seen, np.where(in_view[..., None], 1.0 - seen, np.float32(1.0)))
        total += factor.prod(axis=1).mean(axis=1)
    alone = np.mean([(1.0 - np.cos(half)) / 2.0 for half in HALF_ANGLES]) * hit
    return np.asarray(np.log(np.maximum(total / len(HALF_ANGLES), 1e-300)) - np.log(alone))


def _directions() -> Floats:
    """(A, 3) unit, spread evenly."""
    z = 1.0 - (2.0 * np.arange(AXES) + 1.0) / AXES
    around, r = np.pi * (1.0 + 5.0**0.5) * np.arange(AXES), np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(around), r * np.sin(around), z], axis=1)
