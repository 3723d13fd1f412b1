"""OpenCV's lens distortion on normalised image points, both ways, with its fold told apart from its range.

Coefficients are k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tau_x tau_y]]]]: 0, 4, 5, 8, 12 or 14 of them.
"""

import numpy as np

from geometry.arrays import Floats

LENGTHS = (0, 4, 5, 8, 12, 14)  # the numbers of coefficients that OpenCV knows
_ROUNDS = 30  # of Newton's method in `undistort`; five are enough for a usual lens
_STEP = 1e-6  # for its central differences
_FOUND = 1e-8  # how near the distorted solution must come, in normalised units (6e-6 px at f = 600)


def distort(xy: Floats, dist: Floats) -> Floats:
    """Where the ideal points `xy` (..., 2) = x/z, y/z appear (..., 2) after the lens `dist` (k,); NaN past its fold."""
    if not np.any(dist):
        return xy
    inside = np.linalg.norm(xy, axis=-1, keepdims=True) < fold_radius(dist)
    return np.where(inside, _lens(np.where(inside, xy, 0.0), _padded(dist)), np.nan)


def undistort(xy: Floats, dist: Floats) -> Floats:
    """The ideal points (..., 2) that appear at `xy` (..., 2), by Newton's method; NaN where there is none."""
    if not np.any(dist):
        return xy
    k, edge = _padded(dist), fold_radius(dist)
    guess = np.where(np.isfinite(xy), xy, 0.0)
    target = guess
    for _ in range(_ROUNDS):
        off = _lens(guess, k) - target
        guess = _within(guess - _solve2(_slopes(guess, k), off), edge)
        if np.abs(off).max(initial=0.0) < _FOUND / 100:
            break
    found = np.abs(_lens(guess, k) - target).max(axis=-1, keepdims=True) < _FOUND
    return np.where(found & np.isfinite(xy), guess, np.nan)


def fold_radius(dist: Floats) -> float:
    """The first ideal radius at which the radial part stops growing, inf if none: past it a lens model shows ghosts."""
    k1, k2, _, _, k3, k4, k5, k6 = _padded(dist)[:8]
    up = np.polynomial.Polynomial([1.0, k1, k2, k3])  # in s = r^2
    down = np.polynomial.Polynomial([1.0, k4, k5, k6])
    s = np.polynomial.Polynomial([0.0, 1.0])
    slope = up * down + 2 * s * (up.deriv() * down - up * down.deriv())  # d(r up/down)/dr times down^2
    roots = [*slope.trim(1e-15).roots(), *down.trim(1e-15).roots()]
    real = [float(root.real) for root in roots if abs(root.imag) < 1e-9 and root.real > 0]
    return float(np.sqrt(min(real))) if real else float("inf")


def _padded(dist: Floats) -> Floats:
    return np.concatenate([dist, np.zeros(14 - len(dist))])


def _lens(xy: Floats, k: Floats) -> Floats:
    """OpenCV's formula, in its own names."""
    x, y = xy[..., 0], xy[..., 1]
    r2 = x * x + y * y
    radial = (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])))
    u = x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + r2 * (k[8] + r2 * k[9])
    v = y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + r2 * (k[10] + r2 * k[11])
    return _tilted(np.stack([u, v], axis=-1), k[12], k[13])


def _tilted(xy: Floats, tau_x: float, tau_y: float) -> Floats:
    """The points `xy` (..., 2) on a sensor tilted by the two angles (rad) against the lens."""
    if tau_x == 0 and tau_y == 0:
        return xy
    (cx, cy), (sx, sy) = np.cos([tau_x, tau_y]), np.sin([tau_x, tau_y])
    turn = np.array([[cy, 0, -sy], [0, 1, 0], [sy, 0, cy]]) @ np.array([[1, 0, 0], [0, cx, sx], [0, -sx, cx]])
    onto = np.array([[turn[2, 2], 0, -turn[0, 2]], [0, turn[2, 2], -turn[1, 2]], [0, 0, 1]]) @ turn
    raised = xy @ onto[:, :2].T + onto[:, 2]
    return np.asarray(raised[..., :2] / raised[..., 2:])


def _slopes(xy: Floats, k: Floats) -> Floats:
    """Jacobian (..., 2, 2) of the lens by central differences."""
    steps = np.eye(2) * _STEP
    return np.stack([(_lens(xy + step, k) - _lens(xy - step, k)) / (2 * _STEP) for step in steps], axis=-1)


def _solve2(matrix: Floats, right: Floats) -> Floats:
    """Solutions (..., 2) of 2x2 systems; a singular one gives a zero step."""
    (a, b), (c, d) = np.moveaxis(matrix, (-2, -1), (0, 1))
    det = a * d - b * c
    safe = np.where(np.abs(det) > 1e-12, det, np.inf)
    p, q = right[..., 0], right[..., 1]
    return np.stack([(d * p - b * q) / safe, (a * q - c * p) / safe], axis=-1)


def _within(xy: Floats, edge: float) -> Floats:
    """`xy` (..., 2) drawn back inside the fold."""
    if not np.isfinite(edge):
        return xy
    radius = np.linalg.norm(xy, axis=-1, keepdims=True)
    return np.asarray(xy * np.minimum(1.0, 0.999 * edge / np.maximum(radius, 1e-12)))
