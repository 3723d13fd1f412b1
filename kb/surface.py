"""Surfaces: Surface(surface(x), BoundingSurface, facets), closed and manifold, of triangles (§2.8).

Vocabulary: ``Surface``, a tetrahedron having 4 vertices and 4 triangles; its edges lie each in exactly two facets.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.errors import GeometryError
from geometry.rays import RayMesh, checked_mesh
from kb.errors import SurfaceError

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

WELD = 1e-6
"""Vertices nearer than this, as a share of the diameter, are one: a texture's seam splits them."""
FLAT = 1e-9
"""A facet is degenerate whose height is less than this, as a share of its longest side."""


@dataclass(frozen=True, eq=False)
class Surface:
    """``vertices`` (V, 3) m, object frame, and ``triangles`` (T, 3), counterclockwise from outside; both read-only."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]

    def __post_init__(self) -> None:
        try:
            vertices, triangles = checked_mesh(self.vertices, self.triangles)
        except GeometryError as error:
            raise SurfaceError(str(error)) from error
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", triangles)

    @cached_property
    def rays(self) -> RayMesh:
        """The surface ready to be shot at."""
        return RayMesh(self.vertices, self.triangles)

    @cached_property
    def volume(self) -> float:
        """The volume enclosed, m³; positive where the triangles face outward."""
        a, b, c = np.moveaxis(self.vertices[self.triangles] - self.centre, 1, 0)
        return float(np.einsum("ti,ti->", a, np.cross(b, c)) / 6)

    @cached_property
    def diameter(self) -> float:
        """The diagonal of the bounding box, m."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def centre(self) -> NDArray[np.float64]:
        """The middle (3,) of the bounding box, m."""
        middle: NDArray[np.float64] = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2
        middle.setflags(write=False)
        return middle


def surface_from_mesh(path: Path, scale: float = 1.0) -> Surface:
    """The closed surface of a mesh file; ``scale`` takes the file's unit to metres.

    Raises:
        SurfaceError: for a file that is no mesh, and for a mesh that is not closed.
    """
    vertices, triangles = _read(path)
    surface = welded(vertices * scale, triangles)
    check_closed(surface)
    return surface if surface.volume > 0 else Surface(surface.vertices, surface.triangles[:, ::-1])


def _read(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    import trimesh

    try:
        mesh: Any = trimesh.load(path, force="mesh", process=False)
        vertices, triangles = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
    except Exception as error:  # - trimesh's readers raise whatever their parsers do
        raise SurfaceError(f"{path.name} is no mesh that can be read: {error}") from error
    if not len(triangles):
        raise SurfaceError(f"{path.name} holds no facets")
    return vertices, triangles


def welded(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Surface:
    """The surface whose vertices at one place are one, without degenerate facets and without vertices that none uses.

    Raises:
        SurfaceError: where nothing is left, or a coordinate is not finite.
    """
    rough = Surface(vertices, triangles)
    first, same = _same_place(rough.vertices, WELD * rough.diameter)
    joined = Surface(rough.vertices[first], same[rough.triangles])
    kept = joined.triangles[~degenerate(joined)]
    if not len(kept):
        raise SurfaceError(f"all {len(triangles)} facets are degenerate")
    used, index = np.unique(kept, return_inverse=True)
    return Surface(joined.vertices[used], index.reshape(-1, 3))


def _same_place(vertices: NDArray[np.float64], grain: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The first vertex of each place, and each vertex's place: vertices within ``grain``, linked in chains."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(vertices).query_pairs(max(grain, 1e-300), output_type="ndarray")
    size = len(vertices)
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(size, size))
    label = np.asarray(connected_components(links, directed=False)[1])
    return np.unique(label, return_index=True)[1], label


def degenerate(surface: Surface) -> NDArray[np.bool_]:
    """(T,) which facets have collinear points, or one point twice (§2.8)."""
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    longest = np.max([np.linalg.norm(side, axis=1) for side in (b - a, c - b, a - c)], axis=0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) <= FLAT * longest**2)


def check_closed(surface: Surface) -> None:
    """Hold the surface to §2.8: each edge in exactly two facets, which run along it opposite ways; none degenerate.

    Raises:
        SurfaceError: with the numbers of edges and facets that break it.
    """
    faults = {"degenerate facets": int(degenerate(surface).sum())} | _edge_faults(surface.triangles)
    broken = [f"{count} {fault}" for fault, count in faults.items() if count]
    if broken:
        raise SurfaceError(f"no closed surface: {', '.join(broken)} of {len(surface.triangles)} facets")


def _edge_faults(triangles: NDArray[np.int64]) -> dict[str, int]:
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges, index = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True)
    uses = np.bincount(index.ravel(), minlength=len(edges))
    sense = np.bincount(index.ravel(), weights=np.where(directed[:, 0] < directed[:, 1], 1, -1), minlength=len(edges))
    return {
        "edges in one facet only": int((uses == 1).sum()),
        "edges in more than two facets": int((uses > 2).sum()),
        "edges whose two facets face opposite ways": int(((uses == 2) & (sense != 0)).sum()),
    }
