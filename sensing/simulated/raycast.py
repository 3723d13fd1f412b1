"""Bodies seen by rays instead of TinyRenderer.

Meshes of any size, textures without aliasing, rounded shading, cast shadows.

Used for table-top scenes, whose packages carry fine print. What is learned from pictures of another renderer is not
flattered by it. A texture is looked up in a pyramid of halved copies, each sample from the one that fits its footprint.

* ``Cast``: what each ray met first, ``Caster(bodies).cast(eye, rays)``
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import lengths
from geometry.visibility.rays import RayMesh
from sensing.simulated.body import Body, TexturedMesh

SMALLEST = 16
"""Texels of the smallest copy's shorter side, at least."""
_ROW = 4096
"""Samples a row given to OpenCV, which takes no picture of a million columns."""


class TexturePyramid:
    """A texture (H, W, 3) uint8 with its copies of half the size, and so on; beyond its rims it is mirrored."""

    def __init__(self, texture: NDArray[np.uint8]) -> None:
        """Halve until the shorter side would fall below ``SMALLEST``."""
        self.levels = [np.ascontiguousarray(texture)]
        while min(self.levels[-1].shape[:2]) >= 2 * SMALLEST:
            height, width = self.levels[-1].shape[:2]
            self.levels.append(
                np.asarray(
                    cv2.resize(self.levels[-1], (width // 2, height // 2), interpolation=cv2.INTER_AREA), np.uint8
                )
            )

    @property
    def flat(self) -> tuple[NDArray[np.uint8], NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """All copies one after the other (N, 3); and where each starts, how wide and how high it is."""
        high, wide = (np.array([level.shape[k] for level in self.levels]) for k in (0, 1))
        return (
            np.concatenate([level.reshape(-1, 3) for level in self.levels]),
            np.cumsum(high * wide) - high * wide,
            wide,
            high,
        )

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, texels."""
        return self.levels[0].shape[1], self.levels[0].shape[0]

    def at(self, uv: NDArray[np.float64], footprint: NDArray[np.float64]) -> NDArray[np.float32]:
        """(N, 3) colours at ``uv`` (N, 2) in [0, 1], (0, 0) the lower left.

        ``footprint`` (N,): texels between neighbouring samples.
        """
        level = np.clip(np.rint(np.log2(np.maximum(footprint, 1e-9))), 0, len(self.levels) - 1).astype(int)
        colours = np.empty((len(uv), 3), np.float32)
        for i, picture in enumerate(self.levels):
            chosen = level == i
            if chosen.any():
                colours[chosen] = _bilinear(picture, uv[chosen])
        return colours


def _bilinear(picture: NDArray[np.uint8], uv: NDArray[np.float64]) -> NDArray[np.float32]:
    height, width = picture.shape[:2]
    at = np.stack([uv[:, 0] * width - 0.5, (1 - uv[:, 1]) * height - 0.5], axis=1).astype(np.float32)
    rows = -(-len(at) // _ROW)
    padded = np.zeros((rows * _ROW, 2), np.float32)
    padded[: len(at)] = at
    grid = padded.reshape(rows, _ROW, 2)
    found = cv2.remap(picture, grid[:, :, 0], grid[:, :, 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return np.asarray(found, np.float32).reshape(-1, 3)[: len(at)]


CREASE = 0.8
"""Cosine between two facets that touch above which the surface is taken to be rounded there."""
STEEPEST = 0.2
"""Cosine below which a surface seen from the side is not blurred more."""


@dataclass(frozen=True, eq=False)
class Cast:
    """Per ray (N): body (-1 none), triangle among all, distance in ray lengths, point (N, 3), normal (N, 3), world.

    ``weight`` (N, 3): of the triangle's corners there.
    """

    body: NDArray[np.int64]
    triangle: NDArray[np.int64]
    depth: NDArray[np.float64]
    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    weight: NDArray[np.float64]


class Caster:
    """Bodies ready to be shot at, all in the world frame; at least one. ``paints``: the texture of each."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        """Gather the triangles of all, with their texture coordinates and the normals of their corners."""
        meshes = [body.mesh for body in bodies]
        turns = [body.world_from_body[:3, :3] for body in bodies]
        self._corners = np.concatenate([body.vertices_world[body.mesh.triangles] for body in bodies])
        self._normals = np.concatenate([corner_normals(m) @ R.T for m, R in zip(meshes, turns, strict=True)])
        self._uv = np.concatenate([_uv(m)[m.triangles] for m in meshes])
        self._of = np.repeat(np.arange(len(bodies)), [len(m.triangles) for m in meshes])
        self.paints = [_paint(m) for m in meshes]
        self._texels = _texels_per_metre(self._corners, self._uv, np.array([p.size for p in self.paints])[self._of])
        self._duals = _duals(self._corners)

    @cached_property
    def mesh(self) -> RayMesh:
        """All triangles, ready to be shot at."""
        return RayMesh(self._corners.reshape(-1, 3), np.arange(self._corners.shape[0] * 3).reshape(-1, 3))

    @property
    def facets(self) -> tuple[NDArray[np.float64], ...]:
        """Of T triangles: corners (T, 3, 3), normals (T, 3), duals (T, 2, 3), rounded normals (T, 3, 3), and paint.

        The paint by texture coordinates (T, 3, 2) and texels a metre (T,).
        """
        across = np.cross(self._corners[:, 1] - self._corners[:, 0], self._corners[:, 2] - self._corners[:, 0])
        every = self._corners, across, self._duals, self._normals, self._uv, self._texels
        return tuple(np.ascontiguousarray(some, float) for some in every)

    def cast(self, eye: NDArray[np.float64], rays: NDArray[np.float64]) -> Cast:
        """What rays (N, 3) of any length from ``eye`` (3,) meet.

        A depth of inf, a zero normal and a NaN point for nothing.
        """
        distance, triangle = self.mesh.first_triangle(eye[None], rays)
        depth = distance / lengths(rays)
        hit = triangle >= 0
        some = np.where(hit, triangle, 0)
        point = eye + np.where(hit, depth, np.nan)[:, None] * rays
        normal, weight = np.zeros((2, *point.shape))
        weight[hit] = self._weights(point[hit], some[hit])
        normal[hit] = _mixed(weight[hit], self._normals[some[hit]])
        normal /= np.maximum(lengths(normal)[:, None], 1e-12)
        return Cast(np.where(hit, self._of[some], -1), triangle, depth, point, normal, weight)

    def colours(self, found: Cast, spread: NDArray[np.float64], steepness: NDArray[np.float64]) -> NDArray[np.float32]:
        """(N, 3) paint of what was met, blue first, 0 to 255; black where nothing was.

        ``spread`` (N,): metres between neighbouring rays there; ``steepness`` (N,): cosine between ray and normal.
        """
        colours = np.zeros((len(found.body), 3), np.float32)
        for i, paint in enumerate(self.paints):
            own = np.flatnonzero(found.body == i)
            if len(own):
                triangle = found.triangle[own]
                uv = _mixed(found.weight[own], self._uv[triangle])
                footprint = self._texels[triangle] * spread[own] / np.sqrt(np.maximum(steepness[own], STEEPEST))
                colours[own] = paint.at(uv, footprint)
        return colours

    def lit(self, points: NDArray[np.float64], to_lamp: NDArray[np.float64], lift: float = 1e-3) -> NDArray[np.bool_]:
        """Whether nothing stands between points (N, 3), metres, and a lamp far away in the directions (N, 3)."""
        return ~self.mesh.meets(points + lift * to_lamp, to_lamp)

    def _weights(self, points: NDArray[np.float64], triangle: NDArray[np.int64]) -> NDArray[np.float64]:
        """(N, 3) barycentric coordinates of points in their triangles."""
        along = (self._duals[triangle] @ (points - self._corners[triangle, 0])[:, :, None])[:, :, 0]
        return np.clip(np.c_[1 - along.sum(axis=1), along], 0, 1)


def _mixed(weight: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, X) of corners (N, 3, X), each by its weight (N, 3)."""
    return np.asarray((weight[:, None, :] @ corners)[:, 0])


def corner_normals(mesh: TexturedMesh) -> NDArray[np.float64]:
    """(T, 3, 3) unit normals at the corners.

    The mean, by area, of those facets around that do not meet this one at an edge.
    """
    a, b, c = np.moveaxis(mesh.corners, 1, 0)
    area, facets = np.cross(b - a, c - a), mesh.normals
    _, place = np.unique(np.round(mesh.vertices, 6), axis=0, return_inverse=True)
    of_corner = np.asarray(place).reshape(-1)[mesh.triangles].reshape(-1)
    order = np.argsort(of_corner, kind="stable")  # corners at one place follow one another
    of_corner, facet = of_corner[order], order // 3
    total = area[facet]
    for step in range(1, len(order)):
        near = of_corner[:-step] == of_corner[step:]
        if not near.any():
            break
        one, other = (near.nonzero()[0] + k for k in (0, step))
        smooth = (facets[facet[one]] * facets[facet[other]]).sum(axis=1) > CREASE
        one, other = one[smooth], other[smooth]
        total[one] += area[facet[other]]
        total[other] += area[facet[one]]
    normals = np.empty_like(total)
    normals[order] = total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-15)
    return normals.reshape(-1, 3, 3)


def _uv(mesh: TexturedMesh) -> NDArray[np.float64]:
    return np.zeros((len(mesh.vertices), 2)) if mesh.uv is None else np.asarray(mesh.uv)


def _paint(mesh: TexturedMesh) -> TexturePyramid:
    """The mesh's texture times its colour, or its colour alone."""
    colour = np.array(mesh.colour[::-1])
    texture = np.full((1, 1, 3), 255, np.uint8) if mesh.texture is None or mesh.uv is None else mesh.texture
    return TexturePyramid(texture if np.allclose(colour, 1) else np.rint(texture * colour).astype(np.uint8))


def _texels_per_metre(
    corners: NDArray[np.float64], uv: NDArray[np.float64], size: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(T,) how finely each triangle is painted."""
    a, b = (uv[:, i] - uv[:, 0] for i in (1, 2))
    painted = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) * size.prod(axis=1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.sqrt(painted / np.maximum(area, 1e-12))


def _duals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 2, 3) vectors whose products with a point, seen from the first corner, are its weights on the other two."""
    edges = corners[:, 1:] - corners[:, :1]
    gram = edges @ edges.transpose(0, 2, 1)
    determinant = gram[:, 0, 0] * gram[:, 1, 1] - gram[:, 0, 1] ** 2
    adjugate = np.stack([np.stack([gram[:, 1, 1], -gram[:, 0, 1]], 1), np.stack([-gram[:, 0, 1], gram[:, 0, 0]], 1)], 1)
    return np.asarray((adjugate / np.maximum(determinant, 1e-30)[:, None, None]) @ edges)
