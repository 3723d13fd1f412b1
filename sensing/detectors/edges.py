"""Edges to a fraction of a pixel: profiles across lines, lines fitted to where the brightness changes most, segments.

A *segment* is a row (u1, v1, u2, v2) in pixels. Its normal is its direction turned clockwise on the screen by a
quarter: the profile runs from the side on the left of the direction (as seen on the screen, negative) to the right
(positive).

Segments are found by OpenCV's detector and refined on the brightness, and collinear pieces are merged. A segment's ends
are moved out or in to where the step across it begins and ceases.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Mask

STEP = 0.5
"""Pixels between two samples of a profile."""
_MAX_ROWS = 30_000
"""cv2.remap takes no more rows at once."""


def sample(grey: NDArray[np.float32], at: Floats) -> NDArray[np.float32]:
    """(...,) bilinear brightness at (..., 2) places (u, v); places outside take the border's value."""
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


def sides_of(quads: Floats) -> Floats:
    """(4 N, 4) segments from each corner of N quadrilaterals (N, 4, 2) to the next."""
    return np.concatenate([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 4)


def fitted_quads(
    grey: NDArray[np.float32], sides: Floats, share: tuple[float, float], samples: int, reach: Floats
) -> tuple[Floats, Floats]:
    """Corners (N, 4, 2) where lines meet that are fitted to the steepest change, dark inside, across sides (4 N, 4).

    NaN where neighbouring sides turn out to be parallel. ``share``, ``samples`` and ``reach`` as in ``profiles``; and
    the rise (4 N, S) in grey levels across each side.
    """
    values, offsets, base = profiles(grey, sides, share, samples, reach)
    where, rise = edge_offsets(values, offsets, np.full(len(sides), -1.0))
    normal = directions(sides)[1]
    point, direction, _ = (
        x.reshape(-1, 4, *x.shape[1:]) for x in fit_lines(base + where[:, :, None] * normal[:, None], rise)
    )
    return meet(np.roll(point, 1, axis=1), np.roll(direction, 1, axis=1), point, direction), rise


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
    counts = weights > 0
    row, number = np.arange(len(values)), counts.sum(axis=1)
    rising = np.sort(np.where(counts, values, np.inf), axis=1)
    middle = rising[row, (number - 1) // 2] + rising[row, number // 2]  # an eighth of nanmedian's time
    return np.where(number > 0, middle / 2, 0.0)


OUT, IN = 8, 24
"""Pixels beyond each end, and inside it, that are looked at."""
SHARE = 0.45
"""Share of the segment's own step that still counts as the edge."""
WINDOW = 4
"""Pixels along the edge over which the step is averaged."""


MIN_LENGTH = 7.0
MIN_RISE = 4.0
"""Grey levels that an edge must rise within 3 px across it, in the mean along it."""
SHARPNESS = 0.65
"""Share of the rise within 7 px across an edge that lies within 3 px."""
MERGE_ANGLE = np.radians(4.0)
MERGE_OFFSET = 1.2
"""Pixels that two collinear pieces may lie apart across their direction."""


def find_segments(channels: Sequence[NDArray[np.float32]]) -> Floats:
    """(N, 4) refined, merged segments of an (H, W) image given as one or more channels in grey levels; longest first.

    The first channel is searched for sharp and for weak edges, the others for weak ones alone. What one channel shows
    and another shows longer is reported once, the longer.
    """
    raw = [
        np.concatenate([_lsd(channels[0], 0.8, 1.6, MIN_LENGTH), _weak_edges(channels[0])]),
        *(_weak_edges(c) for c in channels[1:]),
    ]
    found = np.concatenate(
        [with_true_ends(c, merged(refined(c, lines))) for c, lines in zip(channels, raw, strict=True)]
    )
    found = _longest_first(found)
    free = np.ones(len(found), dtype=bool)
    for i in range(len(found)):
        if free[i]:
            free[i + 1 :] &= ~_covered(found[i], found[i + 1 :])
    return found[free]


def _covered(longer: Floats, others: Floats) -> Mask:
    """Which of (N, 4) ``others`` lie along ``longer`` (4,) by more than half, in either sense."""
    along, normal, length = (x[0] for x in directions(longer[None]))
    ends = others.reshape(-1, 2, 2) - longer[:2]
    (a, b), (c, d) = (ends @ along).T, np.abs(ends @ normal).T
    first, last = np.minimum(a, b), np.maximum(a, b)
    shared = np.minimum(last, length) - np.maximum(first, 0)
    return np.asarray((np.maximum(c, d) < 2.0) & (shared > 0.5 * (last - first)))


def _weak_edges(grey: NDArray[np.float32]) -> Floats:
    """Edges of a few grey levels, found in a softer picture, where only longer ones are worth a look."""
    return _lsd(grey, 1.6, 0.35, 2 * MIN_LENGTH)


def _lsd(grey: NDArray[np.float32], blur: float, quantum: float, shortest: float) -> Floats:
    soft = np.clip(cv2.GaussianBlur(grey, (0, 0), blur), 0, 255).astype(np.uint8)
    finder = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD, 0.8, 0.6, quantum, 22.5, 0, 0.6)
    lines = finder.detect(soft)[0]
    found = np.zeros((0, 4)) if lines is None else np.asarray(lines, np.float64).reshape(-1, 4)
    return found[np.linalg.norm(found[:, 2:] - found[:, :2], axis=1) >= shortest]


def refined(grey: NDArray[np.float32], segments: Floats) -> Floats:
    """Segments moved onto the steepest change across them; those where nothing rises by ``MIN_RISE`` are dropped.

    The result runs so that the brighter side is on the right of its direction.
    """
    if not len(segments):
        return segments
    along, normal, _ = directions(segments)
    values, offsets, base = profiles(grey, segments, (0.06, 0.94), 24, np.full(len(segments), 2.5))
    middle = values.shape[2] // 2
    polarity = np.sign(np.median(values[:, :, middle + 1 :].mean(axis=2) - values[:, :, :middle].mean(axis=2), axis=1))
    where, rise = edge_offsets(values, offsets, polarity)
    point, direction, rms = fit_lines(base + where[:, :, None] * normal[:, None], rise)
    good = (polarity != 0) & (rms < 1.0) & np.isfinite(point).all(axis=1)
    direction *= np.where((direction * along).sum(axis=1) < 0, -1, 1)[:, None]
    good &= (direction * along).sum(axis=1) > np.cos(np.radians(15))
    ends = [
        point + ((e - point) * direction).sum(axis=1, keepdims=True) * direction
        for e in (segments[:, :2], segments[:, 2:])
    ]
    forward = (polarity > 0)[:, None]
    found = np.where(forward, np.hstack(ends), np.hstack(ends[::-1]))[good]
    return found[_sharp(grey, found)]


def _sharp(grey: NDArray[np.float32], segments: Floats) -> Mask:
    """Whether brightness rises by enough within 1.5 px of the line, and most of its rise within 3.5 px lies there.

    A step, not a slope.
    """
    if not len(segments):
        return np.zeros(0, dtype=np.bool_)
    values, _, _ = profiles(grey, segments, (0.03, 0.97), 24, np.full(len(segments), 3.5))
    mean = (values[:, :, 1:-1] + values[:, :, :-2] + values[:, :, 2:]).mean(axis=1) / 3
    middle = mean.shape[1] // 2
    inner, outer = mean[:, middle + 3] - mean[:, middle - 3], mean[:, -1] - mean[:, 0]
    return np.asarray((inner >= MIN_RISE) & (inner >= SHARPNESS * np.abs(outer)))


def merged(segments: Floats) -> Floats:
    """Collinear pieces of one polarity joined over gaps shorter than a sixth of their joint length plus 4 px.

    Longest first.
    """
    rest = _longest_first(segments)
    along, _, length = directions(rest)
    left = np.arange(len(rest))
    done: list[Floats] = []
    while len(left):
        one, left = rest[left[0]], left[1:]
        while (mates := _mates(one, rest[left], along[left], length[left])).any():
            for other in rest[left[mates]]:
                one = _joined(one, other)
            left = left[~mates]
        done.append(one)
    return _longest_first(np.array(done).reshape(-1, 4))


def _longest_first(segments: Floats) -> Floats:
    length = np.linalg.norm(segments[:, 2:] - segments[:, :2], axis=1)
    return segments[np.argsort(-length, kind="stable")]


def _mates(one: Floats, others: Floats, other_along: Floats, other_length: Floats) -> Mask:
    """Which of (N, 4) ``others``, of these directions (N, 2) and lengths (N,), continue ``one`` (4,)."""
    along, normal, length = (x[0] for x in directions(one[None]))
    ends = others.reshape(-1, 2, 2) - one[:2]
    (a, b), (c, d) = (ends @ along).T, np.abs(ends @ normal).T
    gap = np.maximum(np.minimum(a, b) - length, -np.maximum(a, b))
    straight = other_along @ along > np.cos(MERGE_ANGLE)
    limit = MERGE_OFFSET + 0.02 * np.maximum(gap, 0)
    close = (np.maximum(c, d) < limit + 0.02 * other_length) & (np.minimum(c, d) < limit)
    return np.asarray(straight & close & (gap < 4 + (length + other_length) / 6))


def _joined(a: Floats, b: Floats) -> Floats:
    """One segment through both, weighted by length."""
    along, _, lengths = directions(np.array([a, b]))
    direction = (along * lengths[:, None]).sum(axis=0)
    direction /= np.linalg.norm(direction)
    middles = np.array([a.reshape(2, 2).mean(axis=0), b.reshape(2, 2).mean(axis=0)])
    if lengths.max() < 3 * lengths.min():
        apart = middles[1] - middles[0]
        if np.linalg.norm(apart) > 0.5 * lengths.max():
            direction = apart / np.linalg.norm(apart) * np.sign(apart @ direction)
    middle = (middles * lengths[:, None]).sum(axis=0) / lengths.sum()
    t = (np.concatenate([a, b]).reshape(4, 2) - middle) @ direction
    return np.concatenate([middle + t.min() * direction, middle + t.max() * direction])


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
