"""Where to ask which of two surfaces is in front: an even grid, then sure points.

Within the image of one facet of x crossed with one facet of y the difference of the inverse depths is linear, so it
takes its extremes at the corners: points just inside the corners of every such crossing, and its middle, miss no change
of order between facets that are seen. The grid settles most of what is mutual without them; both are deterministic.
"""

from collections.abc import Iterator
from typing import Protocol

import numpy as np
import shapely

from geometry.arrays import Floats, Ints
from geometry.camera import Camera
from geometry.frames import transform_points
from geometry.visibility.outline import NEAR, Area, is_closed

GRID = 400  # points, about, of the even grid over the common interior
CROSSINGS = 4000  # pairs of facets beyond which the crossings are thinned out evenly
_THIN = 0.02  # px; a crossing narrower than twice this is left out: along an edge of both surfaces single precision decides who is met
_INWARD = 0.02  # how far a corner's point is drawn towards the crossing's middle, as a part of the way


class Placed(Protocol):
    """What is sampled: a surface with its pose, as `geometry.visibility.occlusion.PosedSurface`."""

    @property
    def vertices(self) -> Floats:
        """(V, 3) m."""

    @property
    def triangles(self) -> Ints:
        """(T, 3)."""

    @property
    def camera_from_object(self) -> Floats:
        """(4, 4)."""


def samples_inside(common: Area, pair: tuple[Placed, Placed], camera: Camera) -> Iterator[Floats]:
    """Ideal pixels (N, 2) inside the `common` interior of the two images: first the even ones, then the sure ones, which cost more.

    At least one for an interior not empty.
    """
    shapely.prepare(common)
    yield np.concatenate(
        [shapely.get_coordinates(shapely.point_on_surface(shapely.get_parts(common))), _inside(common, _grid(common))]
    )
    yield _inside(common, _corners(_crossings(common, pair, camera)))


def _inside(area: Area, points: Floats) -> Floats:
    return np.asarray(points[shapely.contains_xy(area, points[:, 0], points[:, 1])])


def even_grid(area: Area, count: int) -> Floats:
    """About `count` pixels (N, 2) spread evenly over the box of `area`'s bounds and lying inside `area`."""
    return _inside(area, _grid(area, count))


def _grid(area: Area, count: int = GRID) -> Floats:
    left, top, right, bottom = area.bounds
    step = max(np.sqrt(max(area.area, 1e-12) / count), (right - left) / count, (bottom - top) / count, 1e-9)
    across, down = (np.arange(low + step / 2, high, step) for low, high in ((left, right), (top, bottom)))
    return np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)


def _crossings(common: Area, pair: tuple[Placed, Placed], camera: Camera) -> Area:
    """The crossings (K,) of the images of facets of the one with facets of the other, within the bounds of `common`."""
    first, second = (_facets(surface, common, camera) for surface in pair)
    left, right = shapely.STRtree(second).query(first, predicate="intersects")
    every = max(1, -(-len(left) // CROSSINGS))
    return shapely.intersection(first[left[::every]], second[right[::every]])


def _facets(surface: Placed, common: Area, camera: Camera) -> Area:
    """Images (K,) of the facets that may be seen in the bounds of `common`; none that crosses the near plane."""
    placed = transform_points(surface.camera_from_object, surface.vertices)
    corners = placed[surface.triangles]
    corners = corners[(corners[..., 2] >= NEAR).all(axis=1)]
    if is_closed(surface.triangles):  # of a closed, outward surface only what turns towards the camera is seen
        corners = corners[np.einsum("ti,ti->t", np.cross(*_sides(corners)), corners[:, 0]) < 0]
    pixels = camera.to_pixels(corners[..., :2] / corners[..., 2:])
    left, top, right, bottom = common.bounds
    low, high = pixels.min(axis=1), pixels.max(axis=1)
    near = (low[:, 0] <= right) & (high[:, 0] >= left) & (low[:, 1] <= bottom) & (high[:, 1] >= top)
    return shapely.polygons(pixels[near])


def _sides(corners: Floats) -> tuple[Floats, Floats]:
    return corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]


def _corners(areas: Area) -> Floats:
    """Points (N, 2) just inside the corners of `areas` (K,), and their middles."""
    areas = areas[shapely.area(areas) > _THIN * shapely.length(areas)]
    corners, owner = shapely.get_coordinates(areas, return_index=True)
    middles = shapely.get_coordinates(shapely.centroid(areas))
    if not len(middles):
        return np.zeros((0, 2))
    return np.concatenate([corners + _INWARD * (middles[owner] - corners), middles])
