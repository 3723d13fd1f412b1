"""The folds of a scanned surface in the picture: lines where what is seen of it turns sharply, or steps back.

A mesh that was scanned has thousands of edges, none of them sharp; so its depth is drawn, smoothed a little, and the
lines are taken from the picture: ``folds(mesh, pose)`` gives lines of places (N, 3) m, camera frame.
"""

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Mask
from geometry.frames import transform_points
from geometry.visibility.rays import RayMesh, depth_of

SIZE = 220
"""Pixels of the larger side of the picture that lines are taken from: fine enough for the 4,000 triangles carried."""
ROUND = 2.0
"""Pixels there (standard deviation) over which normals are taken: they even out a scan's noise, and facets."""
APART = 6
"""Pixels there between two places whose normals are compared: as far as the smoothing reaches."""
SHARP = 0.42
"""Length of the difference of their unit normals, 24°, from which it is a fold: a round can's flank turns less."""
STEP = 0.03
"""Diameters by which neighbouring depths differ at a step."""
SHORT = 18
"""Pixels there below which a line is noise."""


def folds(mesh: RayMesh, pose: Floats) -> list[Floats]:
    """Lines of a posed surface (4, 4), (N, 3) m each, camera frame; none where it reaches behind the camera."""
    placed = transform_points(pose, np.asarray(mesh.vertices))
    if placed[:, 2].min() <= 0.0:
        return []
    low, high = (side(placed[:, :2] / placed[:, 2:], axis=0) for side in (np.min, np.max))
    focal = SIZE / float(max(high - low))
    K = np.array([[focal, 0.0, 8.0 - focal * low[0]], [0.0, focal, 8.0 - focal * low[1]], [0.0, 0.0, 1.0]])
    width, height = (int(side) for side in np.ceil((high - low) * focal + 16.0))
    depth = depth_of(mesh, pose, K, (width, height))
    there = np.isfinite(depth)
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    points = np.stack([(u - K[0, 2]) / focal, (v - K[1, 2]) / focal, np.ones(u.shape)], axis=-1)
    points *= np.where(there, depth, 0.0)[..., None]
    limit = STEP * float(np.linalg.norm(np.ptp(placed, axis=0)))
    lines = []
    for line in _chains(_edges(depth, there, points, limit)):
        if len(line) >= SHORT:
            rows, columns = _evened(line).T
            lines.append(_at(points, depth, rows, columns, K))
    return lines


def _edges(depth: Floats, there: Mask, points: Floats, limit: float) -> Mask:
    """(h, w) one pixel wide: the nearer side of each step, and the ridges of bending away from steps and the rim."""
    far = np.where(there, depth, 1e9).astype(np.float32)
    ring = np.ones((3, 3), np.uint8)
    steps = there & (cv2.dilate(np.where(there, depth, 0.0).astype(np.float32), ring) - far > limit)
    rim = cv2.erode(there.astype(np.uint8), np.ones((7, 7), np.uint8), borderValue=0) == 0
    broken = cv2.dilate(steps.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    normal = _normals(points, there, limit)
    bend = np.zeros(depth.shape, np.float32)
    across = np.zeros((*depth.shape, 2), np.float32)
    for x, y in ((1, 0), (0, 1), (1, 1), (1, -1)):
        reach = APART / 2 / np.hypot(x, y)
        step = round(reach * x), round(reach * y)
        apart = np.linalg.norm(_moved(normal, step) - _moved(normal, (-step[0], -step[1])), axis=-1)
        more = apart > bend
        bend[more], across[more] = apart[more], np.array([x, y], np.float32)
    bend[rim | broken] = 0.0
    ridge = bend > SHARP
    for sign in (1, -1):
        here = np.indices(depth.shape).astype(np.float32)
        u, v = here[1] + sign * across[..., 0], here[0] + sign * across[..., 1]
        beside = cv2.remap(bend, u, v, cv2.INTER_NEAREST)
        ridge &= bend >= beside if sign > 0 else bend > beside
    return _thin(cv2.morphologyEx((ridge | steps & ~rim).astype(np.uint8), cv2.MORPH_CLOSE, ring) > 0)


def _moved(image: Floats, by: tuple[int, int]) -> Floats:
    return np.roll(image, (by[1], by[0]), axis=(0, 1))


def _normals(points: Floats, there: Mask, limit: float) -> Floats:
    """(h, w, 3) unit normals of places (h, w, 3), smoothed; 0 where there is nothing."""
    right, down = np.zeros_like(points), np.zeros_like(points)
    right[:, 1:-1], down[1:-1] = points[:, 2:] - points[:, :-2], points[2:] - points[:-2]
    normal = np.cross(right, down)
    length = np.linalg.norm(normal, axis=-1)
    good = there & (np.abs(right[..., 2]) < 2 * limit) & (np.abs(down[..., 2]) < 2 * limit) & (length > 0.0)
    normal[~good] = 0.0
    normal[good] /= length[good, None]
    smooth = cv2.GaussianBlur(normal, (0, 0), ROUND)
    return np.asarray(smooth / np.maximum(np.linalg.norm(smooth, axis=-1), 1e-9)[..., None] * there[..., None])


def _thin(mask: Mask) -> Mask:
    """The mask worn down to lines one pixel wide (Zhang and Suen)."""
    image = np.pad(mask, 1).astype(np.uint8)
    changed = True
    while changed:
        changed = False
        for first in (True, False):
            p = [np.roll(image, by, axis=(0, 1)) for by in AROUND]
            turns = sum((a == 0) & (b == 1) for a, b in zip(p, [*p[1:], p[0]], strict=True))
            count = np.sum(p, axis=0)
            up, right, down, left = p[0], p[2], p[4], p[6]
            one, two = (up * right * down, right * down * left) if first else (up * right * left, up * down * left)
            gone = (image == 1) & (count >= 2) & (count <= 6) & (turns == 1) & (one == 0) & (two == 0)
            image[gone] = 0
            changed |= bool(gone.any())
    return np.asarray(image[1:-1, 1:-1] > 0)


AROUND = ((1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1), (1, 1))
"""The rolls that bring the neighbours of a pixel to it: above first, then clockwise."""


def _chains(mask: Mask) -> Iterator[NDArray[np.int64]]:
    """Lines of pixels (N, 2), row and column, from one end on; of a fork's branches the straighter one first."""
    left = {(int(row), int(column)) for row, column in np.argwhere(mask)}

    def beside(pixel: tuple[int, int]) -> list[tuple[int, int]]:
        return [q for row, column in AROUND if (q := (pixel[0] + row, pixel[1] + column)) in left]

    for start in sorted(left, key=lambda pixel: (len(beside(pixel)) != 1, pixel)):
        if start not in left:
            continue
        line = [start]
        left.discard(start)
        while following := beside(line[-1]):
            back = np.subtract(line[-1], line[max(0, len(line) - 5)])
            line.append(max(following, key=lambda q: (float(np.dot(back, np.subtract(q, line[-1]))), q)))
            left.discard(line[-1])
        yield np.array(line)


def _evened(line: NDArray[np.int64]) -> Floats:
    """The line without the stairs of its pixels: the mean of five, ends kept."""
    padded = np.pad(line.astype(float), ((2, 2), (0, 0)), mode="edge")
    result = np.mean([padded[i : i + len(line)] for i in range(5)], axis=0)
    result[[0, -1]] = line[[0, -1]]
    return np.asarray(result)


NEARER = 0.003
"""Share of its depth by which a line is drawn before its surface, that its own facets do not hide it."""


def _at(points: Floats, depth: Floats, rows: Floats, columns: Floats, K: Floats) -> Floats:
    """(N, 3) m on the surface at places between its pixels: as deep as the nearest pixel that is on it."""
    i, j = np.rint(rows).astype(int), np.rint(columns).astype(int)
    z = np.where(np.isfinite(depth[i, j]), points[i, j, 2], np.nan)
    known = np.flatnonzero(np.isfinite(z))
    z = np.interp(np.arange(len(z)), known, z[known]) * (1.0 - NEARER)
    rays = np.stack([(columns - K[0, 2]) / K[0, 0], (rows - K[1, 2]) / K[1, 1], np.ones(len(rows))], axis=-1)
    return np.asarray(rays * z[:, None])
