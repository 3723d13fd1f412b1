"""Surfaces: Surface(surface(x), BoundingSurface, facets), of triangles, closed and manifold where it can be (§2.8).

Vocabulary: ``Surface``, a tetrahedron having 4 vertices and 4 triangles; its edges lie each in exactly two facets. A
surface that is not closed hides what is behind it all the same, for that is a matter of rays; for A4 it is repaired, or
refused as a ``solid``.
"""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.bodies.overlap import Solid
from geometry.errors import GeometryError
from geometry.files.mesh_files import joined_meshes, meshes_of, reason, triangles_of
from geometry.visibility.outline import is_closed
from geometry.visibility.rays import RayMesh, checked_mesh
from kb.errors import SurfaceError
from kb.surfaces.closing import LARGEST_HOLE, closed_up, joined_twice, pieces

WELD = 1e-6
"""Vertices nearer than this, as a share of the diameter, are one: a texture's seam splits them."""
FLAT = 1e-9
"""A facet is degenerate whose height is less than this, as a share of its longest side."""

OPEN = (
    "It hides what is behind it all the same, but A4 says nothing of it: others may stand in it. "
    "Where that is not meant, close it in a mesh editor"
)
"""What follows for a surface that is no solid, and the remedy."""


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
    def faults(self) -> str:
        """What breaks §2.8, in words and numbers: edges in one facet only and the like.

        '' for a closed, manifold surface.
        """
        faults = {"degenerate facets": int(degenerate(self).sum())} | _edge_faults(self.triangles)
        return ", ".join(f"{count} {fault}" for fault, count in faults.items() if count)

    @cached_property
    def closed(self) -> bool:
        """Whether each edge is run along as often one way as the other.

        An inside and an outside, and so a volume (§2.8).

        Weaker than to be without ``faults``: two bodies that touch along an edge, four facets meeting there, enclose a
            volume
        all the same.
        """
        return is_closed(self.triangles)

    @cached_property
    def caution(self) -> str:
        """Why A4 says nothing of this mesh, or what had to be repaired; '' for a closed one."""
        if self.solid is self:
            return ""
        what = f"the mesh is not closed ({self.faults})" if not self.closed else "the mesh encloses no volume"
        if self.closed and self.volume > 0:
            what = f"the mesh is not manifold ({self.faults or 'facets meet in single vertices'})"
        solid, done, refused = self.mended
        if solid is not None:
            return f"{what}; repaired for shared volume (A4): {done}; {solid.volume:.4g} m3"
        return f"{what}; refused as a solid: {refused}. {OPEN}"

    @property
    def solid(self) -> "Surface | None":
        """The closed surface whose volume A4 is about: this one, or it repaired.

        None where it is refused, and shares no volume with anything.
        """
        return self.mended.surface

    @cached_property
    def mended(self) -> "Mended":
        """What of it is a solid, and what was repaired for that, or why it is refused (``kb.surfaces.surface``)."""
        return mended(self)

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
    """The surface of a mesh file, closed or not; ``scale`` takes the file's unit to metres.

    Raises:
        SurfaceError: for a file that is no mesh, and for a mesh with a coordinate that is not finite or without an
        extent.
    """
    vertices, triangles = _read(path)
    surface = welded(vertices * scale, triangles)
    return surface if surface.volume >= 0 else Surface(surface.vertices, surface.triangles[:, ::-1])


def _read(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    try:
        parts = [triangles_of(mesh, placed) for mesh, placed in meshes_of(path)]
    except Exception as error:  # - trimesh's readers raise whatever their parsers do
        raise SurfaceError(f"{path.name} is no mesh that can be read: {reason(path, error)}") from error
    if not sum(len(triangles) for _, triangles in parts):
        raise SurfaceError(f"{path.name} holds no facets")
    return joined_meshes(parts)


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
    """The first vertex of each place, and each vertex's place: vertices within ``grain``, linked in chains.

    Those in one cell of a grid of ``grain`` are one first, so that the work is bounded however many stand at one place.
    """
    from scipy.spatial import cKDTree

    if not grain > 0:
        return np.zeros(1, dtype=np.intp), np.zeros(len(vertices), dtype=np.intp)
    cells = np.floor((vertices - vertices.min(axis=0)) / grain).astype(np.int64)
    _, some, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    pairs = cKDTree(vertices[some]).query_pairs(grain, output_type="ndarray")
    label = pieces(len(some), pairs[:, 0], pairs[:, 1])[cell.ravel()]
    _, first, place = np.unique(label, return_index=True, return_inverse=True)
    return first, place


def degenerate(surface: Surface) -> NDArray[np.bool_]:
    """(T,) which facets have collinear points, or one point twice (§2.8)."""
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    longest = np.max([np.linalg.norm(side, axis=1) for side in (b - a, c - b, a - c)], axis=0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) <= FLAT * longest**2)


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


class Mended(NamedTuple):
    """``done``: what was repaired, in words and numbers; '' where nothing had to be."""

    surface: Surface | None
    done: str
    refused: str


def mended(surface: Surface) -> Mended:
    """Holes up to ``LARGEST_HOLE`` of the whole are filled, facets turned outward, and of repeated ones one is kept.

    Its hull never stands in.
    """
    if surface.closed and surface.volume > 0:
        return _checked(surface, "")
    places, facets, holes, left = closed_up(surface.vertices, surface.triangles)
    done = [
        (joined_twice(surface.triangles), "repeated facet dropped", "repeated facets dropped"),
        (_turned(surface.triangles, facets), "facet turned over", "facets turned over"),
        (holes, "hole filled", "holes filled"),
    ]
    said = ", ".join(f"{count} {one if count == 1 else more}" for count, one, more in done if count)
    if left:
        return Mended(
            None,
            "",
            f"{left} {'hole is' if left == 1 else 'holes are'} larger than {LARGEST_HOLE:.0%} of it, and may be meant",
        )
    if not is_closed(facets):
        return Mended(None, "", "its facets meet in a way that leaves no inside")
    try:
        return _checked(Surface(places, facets), said)
    except SurfaceError as error:
        return Mended(None, "", str(error))


def _checked(surface: Surface, done: str) -> Mended:
    """As a solid that volumes can be taken of."""
    try:
        Solid(surface.vertices, surface.triangles)
    except GeometryError as error:
        return Mended(None, "", str(error))
    return Mended(surface, done, "")


def _turned(before: NDArray[np.int64], after: NDArray[np.int64]) -> int:
    """How many triangles of the one run the other way round in the other."""
    return len({*_cycles(before[:, ::-1])} & {*_cycles(after)} - {*_cycles(before)})


def _cycles(triangles: NDArray[np.int64]) -> list[tuple[int, int, int]]:
    """Each triangle from its least vertex on."""
    first = triangles.argmin(axis=1)
    rows = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return [(a, b, c) for a, b, c in rows.tolist()]
