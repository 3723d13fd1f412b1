"""Γ as arrays: what the search works on, in an ideal image without distortion.

Vocabulary: ``Data``, A appearances; *ideal pixels*, the pinhole image of focal length f with the camera's own principal
point.

* ``project_ideal(poses, points, data)``: thousands of posed clouds at once, in ideal pixels
* ``blocks(20_000, 20_000)``: a large table in slices of 52 rows, so that memory is bounded, and the time can be asked
  between them
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask
from geometry.camera import Camera
from kb.clouds.words import POINT, SIDE, WIDTHS
from plogic.match.gamma.grid import Grid, grid_of
from plogic.match.gamma.side_looks import contrasts_of

if TYPE_CHECKING:  # what makes a type ready does not see Γ
    from sensing.appearance import Appearance
    from sensing.pixels.photo import Photo

ENTRIES = 2**20
"""Entries of a block, one row at least: 8 MB of each array of floats; of the dozen that a search has at a time about
100 MB."""


def blocks(rows: int, columns: int) -> Iterator[slice]:
    """The rows of a table, as many at a time as have ``ENTRIES`` entries; none of an empty table."""
    some = max(1, ENTRIES // max(1, columns))
    return (slice(start, min(start + some, rows)) for start in range(0, rows, some))


@dataclass(frozen=True, eq=False)
class Columns:
    """A table of N rows: its fields are arrays whose first axis is N, or such tables."""

    def columns(self) -> list[Any]:
        """The fields, in their order."""
        return [getattr(self, field.name) for field in fields(self)]

    def take(self, which: Indices | Mask | list[int] | slice) -> Self:
        """The rows at an index, or where a mask (N,) holds."""
        return type(self)(*(c.take(which) if isinstance(c, Columns) else c[which] for c in self.columns()))

    @classmethod
    def joined(cls, tables: Iterable[Self]) -> Self:
        """The rows of at least one table, one table after the other."""
        columns = zip(*(table.columns() for table in tables), strict=True)
        return cls(*(type(c[0]).joined(c) if isinstance(c[0], Columns) else np.concatenate(c) for c in columns))


@dataclass(frozen=True)
class Data:
    """``ideal`` (A, 2) ideal pixels; ``types`` (A,) names.

    ``arms`` (A, K) screen angles, NaN where a junction has fewer.

    ``angle`` (A,) rad, ``scale`` (A,) pixels, NaN where the detector gives none; ``descriptors`` (A, D) uint8;
    ``described`` (A,) whether a datum has place, angle, scale and descriptor: a keypoint; ``sided`` (A,) whether it is
    the side of an edge, which has no scale, and ``looks`` (A, 5) uint8 how it looks. ``depth``, ``depth_sigma`` (A,) m,
    NaN where nothing tells a depth; None where nothing tells any. ``photo``: what it was detected in, where that is
    known. ``rows`` (A,) are their indices in ``whole``, of which these are some.
    """

    ids: tuple[str, ...]
    types: tuple[str, ...]
    uv: Floats
    ideal: Floats
    arms: Floats
    camera: Camera
    angle: Floats
    scale: Floats
    descriptors: NDArray[np.uint8]
    described: Mask
    sided: Mask
    looks: NDArray[np.uint8]
    part_of: "tuple[Data, Indices] | None" = None
    depth: Floats | None = None
    depth_sigma: Floats | None = None
    photo: "Photo | None" = None

    @property
    def whole(self) -> "Data":
        """All of Γ."""
        return self if self.part_of is None else self.part_of[0]

    @property
    def rows(self) -> Indices:
        """(A,) where these are in ``whole``."""
        return np.arange(len(self.ids)) if self.part_of is None else self.part_of[1]

    @property
    def coloured(self) -> bool:
        """Whether colours count."""
        return self.descriptors.shape[1] > POINT

    @cached_property
    def namesakes(self) -> Indices:
        """(A,) how many of all of Γ are of each one's type."""
        if self.part_of is not None:
            return self.whole.namesakes[self.rows]
        _, which = self.by_look
        return np.bincount(which)[which]

    @cached_property
    def by_look(self) -> tuple[tuple[str, ...], Indices]:
        """The names of the types that are there, and (A,) which of them each is of."""
        names, which = np.unique(np.array(self.types, str), return_inverse=True)
        return tuple(names.tolist()), np.asarray(which, np.intp)

    @cached_property
    def sizes(self) -> Floats:
        """(A,) the logarithm of ``scale``."""
        return np.log(self.scale)

    @cached_property
    def keypoints(self) -> Grid:
        """The keypoints among these, by place."""
        which = np.flatnonzero(self.described)
        return grid_of(which, self.uv[which], (self.camera.width, self.camera.height))

    @cached_property
    def sides(self) -> Grid:
        """The sides of edges among these, by place and direction."""
        which = np.flatnonzero(self.sided)
        return grid_of(which, self.uv[which], (self.camera.width, self.camera.height), self.angle[which])

    @cached_property
    def contrasts(self) -> Floats:
        """(256,) density of each contrast among all of Γ's sides of edges."""
        return self.whole.contrasts if self.part_of is not None else contrasts_of(self.looks[self.sided])

    def only(self, keep: Mask) -> "Data":
        """The appearances where ``keep`` (A,) holds."""
        index = np.flatnonzero(keep)
        rows = index.tolist()
        return Data(
            tuple(map(self.ids.__getitem__, rows)),
            tuple(map(self.types.__getitem__, rows)),
            self.uv[index],
            self.ideal[index],
            self.arms[index],
            self.camera,
            self.angle[index],
            self.scale[index],
            self.descriptors[index],
            self.described[index],
            self.sided[index],
            self.looks[index],
            (self.whole, self.rows[index]),
            None if self.depth is None else self.depth[index],
            None if self.depth_sigma is None else self.depth_sigma[index],
            self.photo,
        )


def centre_of(camera: Camera) -> Floats:
    """The principal point (2,) of the ideal image, pixels: the camera's own, so that a crop shows what it showed."""
    return np.asarray(camera.K[:2, 2])


def ideal_camera(camera: Camera) -> Camera:
    """The camera of the ideal image: its pixels are ideal pixels."""
    x, y = centre_of(camera)
    return Camera(camera.width, camera.height, np.array([[camera.f, 0.0, x], [0.0, camera.f, y], [0.0, 0.0, 1.0]]))


def data_of(
    appearances: Sequence["Appearance"], camera: Camera, width: int = 138, photo: "Photo | None" = None
) -> Data:
    """Pack appearances into arrays, undistorting their places; ``photo``: what they were detected in.

    ``width``: bytes of those descriptors that the KB's words are made of; colours count where all have them.
    """
    uv = np.array([a.uv for a in appearances], dtype=float).reshape(-1, 2)
    arms = np.full((len(appearances), max((len(a.arms) for a in appearances), default=0)), np.nan)
    for row, appearance in zip(arms, appearances, strict=True):
        row[: len(appearance.arms)] = appearance.arms
    angle = np.array([np.nan if a.angle is None else a.angle for a in appearances], dtype=float)
    scale = np.array([np.nan if a.scale is None else a.scale for a in appearances], dtype=float)
    sizes = np.array([len(a.descriptor or b"") for a in appearances], dtype=int)
    described = (
        np.isin(sizes, [size for size in WIDTHS if WIDTHS[size] == WIDTHS[width]]) & np.isfinite(angle) & (scale > 0.0)
    )
    sided = (sizes == SIDE) & np.isfinite(angle) & np.isnan(scale)
    return Data(
        tuple(a.id for a in appearances),
        tuple(a.type for a in appearances),
        uv,
        camera.normalised(uv) * camera.f + centre_of(camera),
        arms,
        camera,
        angle,
        scale,
        _bytes_of(appearances, described, min([width, *sizes[described].tolist()])),
        described,
        sided,
        _bytes_of(appearances, sided, SIDE),
        None,
        *_depths_of(appearances),
        photo,
    )


def _bytes_of(appearances: Sequence["Appearance"], which: Mask, width: int) -> NDArray[np.uint8]:
    """(A, width) the first bytes of the descriptors ``which`` (A,), zeros for the others."""
    rows = zip(appearances, which, strict=True)
    whole = b"".join((a.descriptor or b"")[:width] if has else bytes(width) for a, has in rows)
    return np.frombuffer(whole, np.uint8).reshape(len(appearances), width)


def _depths_of(appearances: Sequence["Appearance"]) -> tuple[Floats | None, Floats | None]:
    """Depths and their standard deviations (A,), or None where there are none."""
    if all(a.depth is None for a in appearances):
        return None, None
    rows = [
        (np.nan, np.nan) if a.depth is None or a.depth_sigma is None else (a.depth, a.depth_sigma) for a in appearances
    ]
    depth, sigma = np.array(rows).T
    return depth, sigma


FAR = np.float32(-1e6)
"""Where a point behind the camera is put: outside every image."""


def project_ideal(poses: Floats, points: Floats, data: Data) -> NDArray[np.float32]:
    """(N, F, 2) ideal pixels of object points (F, 3) under poses (N, 4, 4), single precision.

    Far outside the image where behind the camera.
    """
    rotations = poses[:, :3, :3].astype(np.float32).reshape(-1, 3)
    local = (rotations @ points.T.astype(np.float32)).reshape(len(poses), 3, len(points))
    local += poses[:, :3, 3:].astype(np.float32)
    seen = local[:, 2] > 1e-6
    inverse = np.float32(data.camera.f) / np.where(seen, local[:, 2], np.float32(1.0))
    places = np.empty((*seen.shape, 2), dtype=np.float32)
    centre = centre_of(data.camera)
    places[..., 0] = np.where(seen, local[:, 0] * inverse + np.float32(centre[0]), FAR)
    places[..., 1] = np.where(seen, local[:, 1] * inverse + np.float32(centre[1]), FAR)
    return places


def viewpoints_of(poses: Floats) -> Floats:
    """(N, 3) the camera's place in the object's frame under each pose."""
    return -np.einsum("nji,nj->ni", poses[:, :3, :3], poses[:, :3, 3])
