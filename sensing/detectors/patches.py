"""Patches: dark, even, convex quadrilaterals on something brighter, such as painted windows (``patch``).

Thresholds give blobs; a blob's hull gives a quadrilateral; its four sides are fitted to a fraction of a pixel; what has
no such side all round, or is not even inside, is no patch. The place is where the diagonals meet: the projection of a
rectangle's centre.

Dark blobs: connected regions that stay the same over several brightness thresholds.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Floats, Mask
from sensing.appearance import Appearance
from sensing.detectors.edges import fitted_quads, meet, sample, sides_of

STEP = 12
"""Grey levels between two thresholds."""
MIN_AREA, MAX_SHARE = 9, 0.03
"""Smallest area in pixels, largest as a share of the image."""
MIN_FILL = 0.35
"""Area over the bounding box's: a thin diagonal parallelogram fills less."""


TYPE = "patch"
MIN_CONTRAST = 14.0
"""Grey levels by which the surroundings are brighter, on each side."""
MIN_SIDE = 2.0
"""Pixels: no side may be shorter."""
SMALL = 7.0
"""Pixels: where the shorter side is below this, the darkness' centroid is the place."""
MAX_ASPECT = 12.0


@dataclass(frozen=True, eq=False)
class Patches:
    """N patches: ``corners`` (N, 4, 2) px, clockwise on the screen; ``centre`` (N, 2) px.

    ``contrast`` (N,) grey levels; ``score`` (N,).
    """

    corners: Floats
    centre: Floats
    contrast: Floats
    score: Floats

    def __post_init__(self) -> None:
        for array in vars(self).values():
            array.setflags(write=False)


class PatchDetector:
    """Reports patches with ``scale`` (diameter of an equal disc) and ``angle`` (of the longer side, in [0, π/2))."""

    name = "patch"
    types: tuple[str, ...] = (TYPE,)

    def detect(self, image_bgr: Bytes) -> list[Appearance]:
        """Patches of an (H, W, 3) uint8 image."""
        found = find_patches(np.asarray(cv2.cvtColor(image_bgr, cv2.COLOR_BGR2GRAY), np.uint8))
        sides = found.corners[:, 1] - found.corners[:, 0]
        angle = np.mod(np.arctan2(sides[:, 1], sides[:, 0]), np.pi / 2)
        scale = np.sqrt(areas(found.corners)) * 2 / np.sqrt(np.pi)
        rows = zip(found.centre, angle, scale, found.score, strict=True)
        return [
            Appearance("", TYPE, (float(c[0]), float(c[1])), self.name, float(a), float(d), float(s))
            for c, a, d, s in rows
        ]


def find_patches(grey: Bytes) -> Patches:
    """Patches of an (H, W) uint8 image, in the order of their centres' v, then u.

    The last image's patches are kept: the junctions' detector asks for the same ones.
    """
    return _found(np.ascontiguousarray(grey).tobytes(), grey.shape)


@lru_cache(maxsize=1)
def _found(pixels: bytes, shape: tuple[int, int]) -> Patches:
    grey = np.frombuffer(pixels, np.uint8).reshape(shape)
    if grey.size == 0 or int(grey.max()) - int(grey.min()) < MIN_CONTRAST:
        return _none()
    blobs = dark_blobs(np.asarray(cv2.GaussianBlur(grey, (0, 0), 0.7), np.uint8))
    quads = np.array([_quad(blob) for blob in blobs], dtype=np.float64).reshape(-1, 4, 2)
    areas_seen = np.array([blob.area for blob in blobs], dtype=np.float64)
    keep = _plausible(quads)
    quads, areas_seen = quads[keep], areas_seen[keep]
    if not len(quads):
        return _none()
    fine = grey.astype(np.float32)
    soft, rise = np.asarray(cv2.GaussianBlur(fine, (0, 0), 0.5), np.float32), np.zeros((0, 4))
    for share in (0.7, 0.75):
        quads, rise = _fitted(soft, quads, share)
        closed = np.isfinite(quads).all(axis=(1, 2))  # neighbouring sides may turn out to be parallel
        quads, rise, areas_seen = quads[closed], rise[closed], areas_seen[closed]
    return _chosen(fine, quads, rise, areas_seen)


def areas(corners: Floats) -> Floats:
    """(N,) areas of (N, 4, 2) quadrilaterals; positive where the corners run clockwise on the screen."""
    a, b, c, d = np.moveaxis(corners, 1, 0)
    p, q = c - a, d - b
    return np.asarray((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) / 2)


def _none() -> Patches:
    return Patches(np.zeros((0, 4, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0))


def _quad(blob: "Blob") -> Floats:
    """(4, 2) first guess, clockwise.

    The outline's longest chord, and on either side of it the point that is farthest off.
    """
    hull = cv2.convexHull(blob.outline).reshape(-1, 2).astype(np.float64)
    apart = ((hull[:, None] - hull[None]) ** 2).sum(axis=2)
    i, j = np.unravel_index(int(np.argmax(apart)), apart.shape)
    along = hull[j] - hull[i]
    off = (hull[:, 0] - hull[i, 0]) * along[1] - (hull[:, 1] - hull[i, 1]) * along[0]
    quad = np.array([hull[i], hull[int(np.argmax(off))], hull[j], hull[int(np.argmin(off))]])
    middle = quad.mean(axis=0)
    return np.asarray(
        middle
        + (quad - middle) * (1 + 1.0 / np.maximum(np.linalg.norm(quad - middle, axis=1, keepdims=True) * 1.4, 1.0))
    )


def _plausible(quads: Floats) -> Mask:
    """Convex, clockwise, no side too short, not too long for its width."""
    edges = np.roll(quads, -1, axis=1) - quads
    onward = np.roll(edges, -1, axis=1)
    convex = ((edges[:, :, 0] * onward[:, :, 1] - edges[:, :, 1] * onward[:, :, 0]) > 0).all(axis=1)
    sides, area = np.linalg.norm(edges, axis=2), areas(quads)
    width = area / np.maximum(sides.max(axis=1), 1e-9)
    good = (
        (sides.min(axis=1) >= MIN_SIDE)
        & (area >= MIN_SIDE**2)
        & (sides.max(axis=1) <= MAX_ASPECT * np.maximum(width, 1e-9))
    )
    return np.asarray(good & convex)


def _fitted(grey: NDArray[np.float32], quads: Floats, share: float) -> tuple[Floats, Floats]:
    """Quadrilaterals with sides moved to where brightness changes, and the median rise (N, 4) across each."""
    sides = sides_of(quads)
    lengths = np.linalg.norm(sides[:, 2:] - sides[:, :2], axis=1).reshape(-1, 4)
    width = np.repeat(areas(quads)[:, None], 4, axis=1) / np.maximum(lengths, 1e-9)
    reach = np.clip(0.6 * width, 1.5, 2.5).reshape(-1)
    moved, rise = fitted_quads(grey, sides, ((1 - share) / 2, (1 + share) / 2), 10, reach)
    return moved, np.median(rise, axis=1).reshape(-1, 4)


def _chosen(grey: NDArray[np.float32], quads: Floats, rise: Floats, areas_seen: Floats) -> Patches:
    """Those that a sharp rise surrounds on every side, that are even inside, and as large as their blob.

    Each place once.
    """
    whole = _plausible(quads)
    quads, rise, areas_seen = quads[whole], rise[whole], areas_seen[whole]
    inside = _inside(grey, quads)
    contrast = np.median(rise, axis=1)
    even = inside.std(axis=1) < np.maximum(0.22 * contrast, 7)
    ratio = areas(quads) / np.maximum(areas_seen, 1)
    good = (rise.min(axis=1) >= np.maximum(MIN_CONTRAST, 0.5 * contrast)) & even & (ratio > 0.6) & (ratio < 2.2)
    quads, contrast, rise, inside = quads[good], contrast[good], rise[good], inside[good]
    score = np.clip(rise.min(axis=1) / np.maximum(rise.max(axis=1), 1e-9), 0, 1) * np.clip(contrast / 60, 0, 1)
    return _once(Patches(quads, _centres(grey, quads, contrast, inside), contrast, score))


def _inside(grey: NDArray[np.float32], quads: Floats) -> Floats:
    """(N, 25) brightness on a 5 × 5 grid over the middle part of each quadrilateral."""
    s = np.linspace(0.3, 0.7, 5)
    x, y = (a.reshape(-1) for a in np.meshgrid(s, s))
    weights = np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], axis=1)
    return sample(grey, np.einsum("pk,nkd->npd", weights, quads)).astype(np.float64)


def _centres(grey: NDArray[np.float32], quads: Floats, contrast: Floats, inside: Floats) -> Floats:
    """(N, 2): where the diagonals meet; for a small patch the centroid of darkness within its rim."""
    a, b, c, d = np.moveaxis(quads, 1, 0)
    crossing = meet(a, c - a, b, d - b)
    sides = np.linalg.norm(np.roll(quads, -1, axis=1) - quads, axis=2)
    small = areas(quads) / np.maximum(sides.max(axis=1), 1e-9) < SMALL
    dark = np.median(inside, axis=1)
    for i in np.flatnonzero(small):
        crossing[i] = _darkness_centroid(grey, quads[i], float(dark[i]), float(contrast[i]), crossing[i])
    return crossing


def _darkness_centroid(
    grey: NDArray[np.float32], quad: Floats, dark: float, contrast: float, otherwise: Floats
) -> Floats:
    middle = quad.mean(axis=0)
    wider = quad + 1.2 * (quad - middle) / np.maximum(np.linalg.norm(quad - middle, axis=1, keepdims=True), 1e-9) * 1.3
    low, high = np.maximum(np.floor(wider.min(axis=0)).astype(int), 0), np.ceil(wider.max(axis=0)).astype(int) + 1
    box = grey[low[1] : high[1], low[0] : high[0]]
    mask = np.zeros(box.shape, np.uint8)
    cv2.fillConvexPoly(mask, np.rint((wider - low) * 16).astype(np.int32), 1, shift=4)
    weight = np.clip((dark + contrast - box) / max(contrast, 1.0), 0, 1.2) * mask
    weight = np.where(weight < 0.12, 0, weight)
    if weight.sum() < 2:
        return otherwise
    v, u = np.mgrid[: box.shape[0], : box.shape[1]]
    return np.array([(weight * u).sum(), (weight * v).sum()]) / weight.sum() + low


def _once(found: Patches) -> Patches:
    """The better one of any two whose centres are closer than a quarter of the smaller's size; ordered by v, then u."""
    size = np.sqrt(areas(found.corners))
    order = np.argsort(-found.score, kind="stable")
    kept: list[int] = []
    for i in order:
        away = np.linalg.norm(found.centre[kept] - found.centre[i], axis=1)
        if (away >= np.maximum(1.5, 0.25 * np.minimum(size[kept], size[i]))).all():
            kept.append(int(i))
    kept.sort(key=lambda i: (found.centre[i, 1], found.centre[i, 0]))
    return Patches(found.corners[kept], found.centre[kept], found.contrast[kept], found.score[kept])


@dataclass(frozen=True)
class Blob:
    """A region darker than ``level``: its (N, 2) outline pixels (u, v), and its area in pixels."""

    outline: NDArray[np.int32]
    area: int
    level: float


def dark_blobs(grey: Bytes) -> list[Blob]:
    """Blobs of an (H, W) image that live through two thresholds or more, once, at the middle of their life."""
    levels = np.arange(int(grey.min()) + STEP // 2, int(grey.max()), STEP)
    rows = [_regions(grey, int(level)) for level in levels]
    found = np.concatenate(rows) if rows else np.zeros((0, 8))
    return [blob for members in _lives(found) if (blob := _blob(grey, found[members])) is not None]


def _regions(grey: Bytes, level: int) -> Floats:
    """(N, 8) rows of regions darker than ``level``: centroid u, v, area, box left, top, width, height, level."""
    mask = (grey < level).view(np.uint8)
    _, _, stats, centre = cv2.connectedComponentsWithStats(mask, connectivity=4, ltype=cv2.CV_32S)
    left, top, width, height, area = stats.T
    inside = (left > 0) & (top > 0) & (left + width < grey.shape[1]) & (top + height < grey.shape[0])
    solid = (area >= MIN_AREA) & (area <= MAX_SHARE * grey.size) & (area >= MIN_FILL * width * height)
    keep = inside & solid & (np.minimum(width, height) >= 2)
    keep[0] = False
    kept: Floats = np.c_[centre, area, left, top, width, height, np.full(len(area), level)][keep]
    return kept


def _lives(found: Floats) -> list[list[int]]:
    """Groups of rows that are one region at successive thresholds: like centroids, areas within a factor of 2.5."""
    order = np.argsort(found[:, 7], kind="stable")
    grid: dict[tuple[int, int], list[list[int]]] = {}
    groups: list[list[int]] = []
    for i in order:
        u, v, area = found[i, :3]
        cell = (int(u // 8), int(v // 8))
        near = [g for du in (-1, 0, 1) for dv in (-1, 0, 1) for g in grid.get((cell[0] + du, cell[1] + dv), ())]
        mine = next((g for g in near if _same(found[g[-1]], u, v, area)), None)
        if mine is None:
            groups.append([int(i)])
            grid.setdefault(cell, []).append(groups[-1])
        else:
            mine.append(int(i))
    return [g for g in groups if len(g) >= 2]


def _same(row: Floats, u: float, v: float, area: float) -> bool:
    reach = 0.8 + 0.12 * float(np.sqrt(row[2]))
    return bool(abs(row[0] - u) < reach and abs(row[1] - v) < reach and area < 2.5 * row[2] + 8)


def _blob(grey: Bytes, rows: Floats) -> Blob | None:
    """The blob at the middle of its life, with the outline of its largest part in its box."""
    _, _, area, left, top, width, height, level = rows[len(rows) // 2]
    x, y = int(left), int(top)
    box = np.ascontiguousarray(grey[y : y + int(height), x : x + int(width)] < level).view(np.uint8)
    outlines = cv2.findContours(box, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[-2]
    outline = max(outlines, key=len).reshape(-1, 2) + np.array([x, y], np.int32)
    return Blob(outline.astype(np.int32), int(area), float(level)) if len(outline) >= 4 else None
