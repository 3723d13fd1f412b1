"""Triples: three neighbours on one plane fix a pose up to a reflection, as on a wall with a few windows (§6.3).

Features without edges (patches) give no links. Of three that lie side by side on a plane, and of three appearances side
by side in the image, weak perspective about the ray of the first gives two poses in closed form: with A the affine map
from the plane to the image, the greater eigenvalue of AᵀA is the squared scale, and the lesser one's direction and size
tell the slant (Huttenlocher and Ullman 1990).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from geometry.arrays import Floats, Indices
from kb.clouds.lobes import Feature
from plogic.base.clock import unhurried
from plogic.match.gamma.data import Columns, Data, blocks, centre_of

NEIGHBOURS = 8
"""Nearest features, or data, among which the other two of a triple are sought."""
WIDE = np.cos(np.radians(65.0))
"""Two sides of a triple of the cloud meet at 65° to 115°: flatter triples say little of the slant."""
LEVEL = np.cos(np.radians(8.0))
"""Features of one plane look the same way, to 8°."""
FLATTEST = np.cos(np.radians(78.0)) ** 2
"""Least foreshortening, squared: a wall seen at more than 78° shows nothing."""
MOST_IMAGE_TRIPLES = 120
"""Image triples that are tried; those that a fourth datum completes to a parallelogram come first, then the most
compact."""


@dataclass(frozen=True)
class PlaneTriples(Columns):
    """M triples of features, counter-clockwise seen from outside: ``features`` (M, 3).

    ``axes`` (M, 3, 3) rows x, y, outward normal of the
    plane, object frame; ``sides`` (M, 2, 2) columns are the second and third feature relative to the first, in x and y,
    metres.
    """

    features: Indices
    axes: Floats
    sides: Floats


def plane_triples(features: Sequence[Feature]) -> PlaneTriples:
    """Right-angled triples of neighbouring features without edges, in one plane, whose lobes look the same way."""
    plain = [f for f, feature in enumerate(features) if not len(feature.arms) and feature.appearances]
    at = np.array([feature.at for feature in features]).reshape(-1, 3)
    normals = {f: features[f].rotation @ features[f].appearances[0].lobe.axis for f in plain}
    rows = []
    for f in plain:
        level = [
            g
            for g in plain
            if g != f and normals[g] @ normals[f] > LEVEL and abs((at[g] - at[f]) @ normals[f]) < 0.01 * _gap(at, f, g)
        ]
        near = np.array(level, dtype=np.intp)[np.argsort([_gap(at, f, g) for g in level], kind="stable")[:NEIGHBOURS]]
        for g, h in combinations(near.tolist(), 2):
            rows += _right_angled(at, normals[f], f, g, h)
    if not rows:
        return PlaneTriples(np.zeros((0, 3), dtype=np.intp), np.zeros((0, 3, 3)), np.zeros((0, 2, 2)))
    triples, axes, sides = (np.array(column) for column in zip(*rows, strict=True))
    return PlaneTriples(triples.astype(np.intp), axes, sides)


def _gap(at: Floats, f: int, g: int) -> float:
    return float(np.linalg.norm(at[g] - at[f]))


def _right_angled(
    at: Floats, normal: Floats, f: int, g: int, h: int
) -> list[tuple[tuple[int, int, int], Floats, Floats]]:
    """The triple (f, g, h), counter-clockwise about the normal, with a wide angle at f and sides of like length."""
    u, v = at[g] - at[f], at[h] - at[f]
    a, b = np.linalg.norm(u), np.linalg.norm(v)
    if abs(u @ v) > WIDE * a * b or max(a, b) > 2.5 * min(a, b):
        return []
    if np.cross(u, v) @ normal < 0:
        g, h, u, v = h, g, v, u
    x = u / np.linalg.norm(u)
    axes = np.stack([x, np.cross(normal, x), normal])
    return [((f, g, h), axes, np.stack([axes[:2] @ u, axes[:2] @ v], axis=1))]


@dataclass(frozen=True)
class ImageTriples:
    """N triples of data (N, 3), counter-clockwise as the eye sees them (y up).

    ``frame`` (N, 3, 3) turns the optical axis to the first's ray;
    ``sides`` (N, 2, 2) columns are the second and third relative to the first in the plane square to that ray, tangents
    (y down).
    """

    data: Indices
    frame: Floats
    sides: Floats


def image_triples(data: Data, members: Indices, check: Callable[[], None] = unhurried) -> ImageTriples:
    """Triples of neighbouring ``members`` (indices into Γ), the likeliest corners of a regular pattern first.

    ``check`` is called between blocks of them, and may raise to end it.
    """
    rows, score = _neighbouring(data.ideal[members], check)
    order = np.lexsort((*rows.T[::-1], score[:, 1], score[:, 0]))[:MOST_IMAGE_TRIPLES]
    chosen = members[rows[order]].reshape(-1, 3)
    return ImageTriples(chosen, *_tangents(data, chosen))


def _neighbouring(places: Floats, check: Callable[[], None]) -> tuple[Indices, Floats]:
    """Triples (N, 3) of places (M, 2) and their scores (N, 2): 0 where a fourth completes a parallelogram, else 1.

    Then the area's scale.
    """
    near = _nearest(places, check)
    one, other = np.array(list(combinations(range(near.shape[1]), 2)), dtype=np.intp).reshape(-1, 2).T
    first, j, k = (np.repeat(np.arange(len(places)), len(one)), near[:, one].ravel(), near[:, other].ravel())
    u, v = places[j] - places[first], places[k] - places[first]
    to_j, to_k = np.hypot(u[:, 0], u[:, 1]), np.hypot(v[:, 0], v[:, 1])
    cross, size = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], to_j * to_k
    kept = (np.abs(cross) >= 0.12 * size) & (np.minimum(to_j, to_k) > 1.0)
    first, j, k, u, v, cross, size, reach = (
        first[kept],
        j[kept],
        k[kept],
        u[kept],
        v[kept],
        cross[kept],
        size[kept],
        (to_j + to_k)[kept],
    )
    away = _fourth(places, first, u + v, check) > 0.08 * reach
    turned = cross > 0  # y down: counter-clockwise for the eye is the other way round
    rows = np.stack([first, np.where(turned, k, j), np.where(turned, j, k)], axis=1)
    return rows, np.stack([away.astype(float), size], axis=1)


def _nearest(places: Floats, check: Callable[[], None]) -> Indices:
    """(M, up to ``NEIGHBOURS``) the nearest others of each of the places (M, 2)."""
    near = np.zeros((len(places), max(0, min(NEIGHBOURS, len(places) - 1))), np.intp)
    for some in blocks(len(places), len(places)):
        check()
        step = places[None] - places[some][:, None]
        near[some] = np.argsort(np.hypot(step[..., 0], step[..., 1]), axis=1, kind="stable")[:, 1 : NEIGHBOURS + 1]
    return near


def _fourth(places: Floats, first: Indices, corner: Floats, check: Callable[[], None]) -> Floats:
    """(N,) how near a place comes to that which is ``corner`` (N, 2) away from the ``first`` (N,)."""
    gap = np.full(len(first), np.inf)
    for some in blocks(len(first), len(places)):
        check()
        step = places[None] - places[first[some]][:, None]
        gap[some] = np.linalg.norm(step - corner[some][:, None], axis=2).min(axis=1, initial=np.inf)
    return gap


def _tangents(data: Data, rows: Indices) -> tuple[Floats, Floats]:
    """Frames and sides of image triples (N, 3), see ``ImageTriples``."""
    rays = np.concatenate(
        [(data.ideal[rows] - centre_of(data.camera)) / data.camera.f, np.ones((*rows.shape, 1))], axis=2
    )
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    frame = turn_z_to(rays[:, 0])
    local = np.einsum("nji,nkj->nki", frame, rays[:, 1:])
    return frame, np.swapaxes(local[..., :2] / local[..., 2:], 1, 2)


def turn_z_to(ray: Floats) -> Floats:
    """(N, 3, 3) smallest rotations that take the optical axis to unit rays (N, 3) in front of the camera."""
    x, y, z = ray.T
    k = 1.0 / (1.0 + z)
    rows = [[1.0 - k * x * x, -k * x * y, x], [-k * x * y, 1.0 - k * y * y, y], [-x, -y, z]]
    return np.moveaxis(np.array(rows), 2, 0)


def triple_poses(
    plane: PlaneTriples, image: ImageTriples, points: Floats, scales: tuple[float, float], focal: float
) -> Floats:
    """(P, 4, 4) camera_from_object.

    Both reflections of every triple of the cloud on every triple of Γ that is no steeper than ``FLATTEST``.

    ``points`` (F, 3) m; ``scales`` the range of pixels a metre; ``focal`` pixels.
    """
    affine = (
        np.einsum("nij,mjk->mnik", image.sides, np.linalg.inv(plane.sides))
        if len(plane.features)
        else np.zeros((0, 0, 2, 2))
    )
    m, n = np.divmod(np.arange(affine.shape[0] * affine.shape[1]), max(1, affine.shape[1]))
    affine = affine.reshape(-1, 2, 2)
    gram = np.swapaxes(affine, 1, 2) @ affine
    middle, half = (gram[:, 0, 0] + gram[:, 1, 1]) / 2.0, (gram[:, 0, 0] - gram[:, 1, 1]) / 2.0
    root = np.hypot(half, gram[:, 0, 1])
    scale = np.sqrt(np.maximum(middle + root, 1e-18))
    good = (middle - root > FLATTEST * (middle + root)) & (scale * focal > scales[0]) & (scale * focal < scales[1])
    m, n, affine, scale, gram = m[good], n[good], affine[good], scale[good], gram[good]
    slant = _slants(scale, gram)
    poses = np.tile(np.eye(4), (2 * len(m), 1, 1))
    for sign, rows in ((1.0, slice(0, len(m))), (-1.0, slice(len(m), None))):
        columns = np.concatenate([affine / scale[:, None, None], sign * slant[:, None]], axis=1)
        third = np.cross(columns[:, :, 0], columns[:, :, 1])
        plane_rotation = np.stack([columns[:, :, 0], columns[:, :, 1], third], axis=2)
        poses[rows, :3, :3] = image.frame[n] @ plane_rotation @ plane.axes[m]
        at = image.frame[n][:, :, 2] / scale[:, None]
        poses[rows, :3, 3] = at - np.einsum("nij,nj->ni", poses[rows, :3, :3], points[plane.features[m, 0]])
    return poses


def _slants(scale: Floats, gram: Floats) -> Floats:
    """(N, 2) third row of the rotation's first two columns, up to sign: from AᵀA = s² (1 − r rᵀ)."""
    rest = np.eye(2)[None] - gram / (scale**2)[:, None, None]
    size = np.sqrt(np.maximum(rest[:, [0, 1], [0, 1]], 0.0))
    return np.stack([size[:, 0], np.where(rest[:, 0, 1] < 0.0, -1.0, 1.0) * size[:, 1]], axis=1)
