"""Where an edge ends: a segment's ends moved out or in to where the step across it begins and ceases."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sensing.detectors.edges import directions, sample

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

OUT, IN = 8, 24
"""Pixels beyond each end, and inside it, that are looked at."""
SHARE = 0.45
"""Share of the segment's own step that still counts as the edge."""
WINDOW = 4
"""Pixels along the edge over which the step is averaged."""


def with_true_ends(grey: NDArray[np.float32], segments: Floats) -> Floats:
    """(N, 4) segments, brighter on the right, with each end where the edge ends, to about a pixel."""
    if not len(segments):
        return segments
    start = _moved(grey, segments)
    back = np.hstack([segments[:, 2:], segments[:, :2]])
    end = _moved(grey, back)
    found = np.hstack([start, end])
    forward = ((found[:, 2:] - found[:, :2]) * (segments[:, 2:] - segments[:, :2])).sum(axis=1) > 0
    return np.asarray(found[forward])


def _moved(grey: NDArray[np.float32], segments: Floats) -> Floats:
    """(N, 2) true first ends: outward from an inner place as far as the step, averaged over a few pixels, lasts."""
    along, normal, length = directions(segments)
    t = np.arange(-OUT - WINDOW, IN + 1, dtype=np.float64)
    inside = np.minimum(t[None, :], length[:, None])
    on = segments[:, None, :2] + inside[:, :, None] * along[:, None]
    step = np.zeros(inside.shape)
    for off in (1.0, 1.8):
        step += sample(grey, on + off * normal[:, None]) - sample(grey, on - off * normal[:, None])
    reference = np.median(step[:, OUT + WINDOW :], axis=1)
    kernel = np.ones(WINDOW) / WINDOW
    mean = np.apply_along_axis(np.convolve, 1, step, kernel, "valid")
    lasting = mean * np.sign(reference)[:, None] >= SHARE * np.abs(reference)[:, None]
    anchor = np.minimum(OUT + WINDOW + np.minimum(length / 2, 10).astype(int), lasting.shape[1] - 1)
    place = np.arange(lasting.shape[1])[None, :]
    broken = np.where(~lasting & (place <= anchor[:, None]), place, -1).max(axis=1)
    first = broken + 1 + WINDOW * (1 - SHARE) - 0.5
    return np.asarray(segments[:, :2] + (first + t[0])[:, None] * along)
