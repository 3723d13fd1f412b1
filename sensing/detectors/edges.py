"""Edges to a fraction of a pixel: profiles across lines, and lines fitted to where the brightness changes most.

A *segment* is a row (u1, v1, u2, v2) in pixels. Its normal is its direction turned clockwise on the screen by a
quarter: the profile runs from the side on the left of the direction (as seen on the screen, negative) to the right
(positive).
"""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats

STEP = 0.5
"""Pixels between two samples of a profile."""
_MAX_ROWS = 30_000
"""cv2.remap takes no more rows at once."""


def sample(grey: NDArray[np.float32], at: Floats) -> NDArray[np.float32]:
    """(...,) bilinear brightness at (..., 2) places (u, v); places outside take the border's value."""
    import cv2

    if at.size == 0:
        return np.zeros(at.shape[:-1], np.float32)
    flat = at.reshape(-1, at.shape[-2], 2).astype(np.float32)
    pieces = [flat[i : i + _MAX_ROWS] for i in range(0, len(flat), _MAX_ROWS)]
    values = [
        cv2.remap(grey, p[:, :, 0].copy(), p[:, :, 1].copy(), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        for p in pieces
    ]
    return np.asarray(np.concatenate(values).reshape(at.shape[:-1]), np.float32)


def directions(segments: Floats) -> tuple[Floats, Floats, Floats]:
    """(N, 2) unit directions, (N, 2) unit normals and (N,) lengths of (N, 4) segments.

    A point's direction is (0, 0).
    """
    along = segments[:, 2:] - segments[:, :2]
    length = np.linalg.norm(along, axis=1)
    along = along / np.maximum(length, 1e-9)[:, None]
    return along, np.stack([-along[:, 1], along[:, 0]], axis=1), length


def profiles(
    grey: NDArray[np.float32], segments: Floats, share: tuple[float, float], samples: int, reach: Floats
) -> tuple[Floats, Floats, Floats]:
    """Brightness across segments.

    Args:
        grey: (H, W) brightness.
        segments: (N, 4).
        share: The stretch of each segment to look at, 0 its start, 1 its end.
        samples: S places along it.
        reach: (N,) pixels to either side.

    Returns:
        Brightness (N, S, P), offsets along the normal (N, P) in pixels, and the places on the segment (N, S, 2).
    """
    _, normal, _ = directions(segments)
    t = np.linspace(share[0], share[1], samples)
    base = segments[:, None, :2] + t[None, :, None] * (segments[:, 2:] - segments[:, :2])[:, None]
    count = 2 * int(np.ceil(float(reach.max(initial=1.0)) / STEP)) + 1
    offsets = np.linspace(-1, 1, count)[None, :] * reach[:, None]
    at = base[:, :, None] + offsets[:, None, :, None] * normal[:, None, None, :]
    return sample(grey, at).astype(np.float64), offsets, base


def edge_offsets(values: Floats, offsets: Floats, polarity: Floats) -> tuple[Floats, Floats]:
    """Where each profile changes most, in the sense that ``polarity`` (N,) = ±1 gives (+1: brighter along it).

    The centroid of the rising part of the slope, squared so that noise counts little. Returns offsets (N, S) in pixels,
    and the rise (N, S) in grey levels that it stands for (0 where there is none; its offset is then NaN).
    """
    rise = np.maximum(np.diff(values, axis=2) * polarity[:, None, None], 0)
    middle = (offsets[:, 1:] + offsets[:, :-1]) / 2
    weight = rise**2
    total = weight.sum(axis=2)
    with np.errstate(invalid="ignore", divide="ignore"):
        where = np.where(total > 0, (weight * middle[:, None]).sum(axis=2) / total, np.nan)
    return where, rise.sum(axis=2)


def fit_lines(places: Floats, weights: Floats) -> tuple[Floats, Floats, Floats]:
    """Weighted least squares lines, one robust reweighting: (N, S, 2) places, (N, S) weights.

    Returns a point (N, 2), a unit direction (N, 2) and the rms distance (N,) in pixels; NaN where fewer than two
    weights count.
    """
    weights = np.where(np.isfinite(places).all(axis=2), weights, 0)
    places = np.nan_to_num(places)
    for _ in range(2):
        point, direction = _line(places, weights)
        across = _distance(places, point, direction)
        spread = _weighted_median(across, weights)[:, None]
        weights = weights / (1 + (across / np.maximum(2 * spread, 0.15)) ** 2)
    rms = np.sqrt((weights * across**2).sum(axis=1) / np.maximum(weights.sum(axis=1), 1e-12))
    bad = (weights > 0).sum(axis=1) < 2
    point[bad], direction[bad], rms[bad] = np.nan, np.nan, np.nan
    return point, direction, rms


def meet(point_a: Floats, along_a: Floats, point_b: Floats, along_b: Floats) -> Floats:
    """(..., 2) intersection of lines given by points and directions; NaN for parallels."""
    cross = along_a[..., 0] * along_b[..., 1] - along_a[..., 1] * along_b[..., 0]
    gap = point_b - point_a
    with np.errstate(invalid="ignore", divide="ignore"):
        t = (gap[..., 0] * along_b[..., 1] - gap[..., 1] * along_b[..., 0]) / np.where(
            np.abs(cross) < 1e-9, np.nan, cross
        )
    return np.asarray(point_a + t[..., None] * along_a)


def _line(places: Floats, weights: Floats) -> tuple[Floats, Floats]:
    total = np.maximum(weights.sum(axis=1), 1e-12)[:, None]
    point = (weights[:, :, None] * places).sum(axis=1) / total
    d = places - point[:, None]
    xx, yy, xy = ((weights * d[:, :, i] * d[:, :, j]).sum(axis=1) for i, j in ((0, 0), (1, 1), (0, 1)))
    angle = np.arctan2(2 * xy, xx - yy) / 2
    return point, np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _distance(places: Floats, point: Floats, direction: Floats) -> Floats:
    d = places - point[:, None]
    return np.abs(d[:, :, 0] * direction[:, None, 1] - d[:, :, 1] * direction[:, None, 0])


def _weighted_median(values: Floats, weights: Floats) -> Floats:
    """(N,) median of the values whose weight counts; 0 where none does."""
    counted = np.where(weights > 0, values, np.nan)
    counted[np.isnan(counted).all(axis=1)] = 0
    return np.asarray(np.nanmedian(counted, axis=1))
