"""The unexplained data of a sequence as arrays, lines of sight from known places.

And where tracks of them triangulate to.

Vocabulary: a ``View`` is one image, ``View("v1", Gamma(...), world_from_camera)``; a ``Sights`` holds V views of at
most N data each; a *track* is a row (V,) of indices, one datum a view at most, -1 for none; ``Places``, of T tracks:
the most likely place of each, its covariance, and how well it fits. Inside, an *observation* is one datum of one track;
there are O of them, those of a track together.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices, Mask, frozen
from geometry.errors import GeometryError
from geometry.frames import inverse, is_rigid
from kb.clouds.cloud import Rates
from plogic.match.gamma.data import Columns
from sensing.appearance import Appearance, Gamma

HIT = 0.8
"""Chance that a feature is detected, where the KB states none (as ``kb.yaml`` has it)."""
CLUTTER = 1.0
"""Data of clutter an image, of an appearance type of which the KB states none (as the engine has it)."""


@dataclass(frozen=True, eq=False)
class View:
    """One image of a sequence: ``id`` ('v1'), its Γ, and where its camera stood.

    ``world_from_camera`` (4, 4), metres, world z up.
    """

    id: str
    gamma: Gamma
    world_from_camera: Floats

    def __post_init__(self) -> None:
        """Keep a read-only pose, and Γ in its order. Raises GeometryError where the pose is not rigid."""
        if not is_rigid(self.world_from_camera):
            raise GeometryError(f"{self.id}: T_world_camera must be a rotation and a translation")
        object.__setattr__(self, "world_from_camera", frozen(self.world_from_camera))
        object.__setattr__(self, "gamma", self.gamma.in_order())

    @property
    def camera_from_world(self) -> Floats:
        """The inverse (4, 4)."""
        return inverse(self.world_from_camera)


@dataclass(frozen=True, eq=False)
class Sights:
    """What the views saw and nobody explained.

    ``ids`` (V) of their data. ``xy`` (V, N, 2) ideal places x/z, y/z, NaN beyond a view's data; ``kind`` (V, N) the
    number of each datum's appearance type among ``types`` (K), -1 beyond. ``camera_from_world`` (V, 4, 4), ``eye`` (V,
    3) m. ``sigma`` (V, K): location noise in ideal units. ``clutter`` (V, K): the density of clutter per ideal area.
    ``hit`` (K): chance to be detected. ``expected`` (K): data of clutter an image. ``angle`` (V, N) rad on the screen,
    NaN where there is none; ``sigma_angle`` their noise, None where they say nothing.
    """

    views: tuple[View, ...]
    ids: tuple[tuple[str, ...], ...]
    types: tuple[str, ...]
    xy: Floats
    kind: Indices
    camera_from_world: Floats
    eye: Floats
    sigma: Floats
    clutter: Floats
    hit: Floats
    expected: Floats
    angle: Floats
    sigma_angle: float | None

    def seen(self, tracks: Indices) -> Floats:
        """(T, V, 2) ideal places of the tracks' data, NaN where a view has none."""
        return np.where(tracks[..., None] >= 0, self.xy[np.arange(len(self.views)), tracks], np.nan)

    def in_image(self, world: Floats) -> Mask:
        """(T, V) whether the places (T, 3) m lie in each view's image."""
        rows = zip((view.gamma.camera for view in self.views), self.camera_from_world, strict=True)
        masks = [camera.contains(camera.project(world @ frame[:3, :3].T + frame[:3, 3])) for camera, frame in rows]
        return np.stack(masks, axis=-1).reshape(len(world), len(self.views))


def sights_of(views: Sequence[View], unexplained: Mapping[str, Sequence[str]], rates: Rates) -> Sights:
    """The unexplained data, by the ids of their views; where a lens has no ray for a pixel, the datum is left out."""
    rows = [_rows(view, unexplained.get(view.id, ())) for view in views]
    types = tuple(sorted({a.type for row in rows for a in row}))
    number = {name: i for i, name in enumerate(types)}
    most = max((len(row) for row in rows), default=0)
    xy, kind, angle = (
        np.full((len(views), most, 2), np.nan),
        np.full((len(views), most), -1, np.intp),
        np.full((len(views), most), np.nan),
    )
    for v, (view, row) in enumerate(zip(views, rows, strict=True)):
        if row:
            xy[v, : len(row)] = view.gamma.camera.normalised(np.array([a.uv for a in row]))
            kind[v, : len(row)] = [number[a.type] for a in row]
            angle[v, : len(row)] = [np.nan if a.angle is None else a.angle for a in row]
    expected = np.array([rates.clutter.get(name, CLUTTER) for name in types])
    usual = float(np.mean(list(rates.hit.values()))) if rates.hit else HIT
    focal = np.array([view.gamma.camera.f for view in views])
    area = np.array([view.gamma.camera.width * view.gamma.camera.height for view in views]) / focal**2
    return Sights(
        views=tuple(views),
        ids=tuple(tuple(a.id for a in row) for row in rows),
        types=types,
        xy=xy,
        kind=kind,
        camera_from_world=np.array([inverse(view.world_from_camera) for view in views]).reshape(-1, 4, 4),
        eye=np.array([view.world_from_camera[:3, 3] for view in views]).reshape(-1, 3),
        sigma=np.array([rates.sigma_of(name) for name in types])[None] / focal[:, None],
        clutter=np.maximum(expected, LEAST_CLUTTER)[None] / area[:, None],
        hit=np.clip([rates.hit.get(name, usual) for name in types], *HITS),
        expected=np.maximum(expected, LEAST_CLUTTER),
        angle=angle,
        sigma_angle=rates.sigma_angle,
    )


LEAST_CLUTTER = 0.01
"""Least data of clutter an image that a type is taken to have: 0 would make any one datum physical."""
HITS = 0.05, 0.98
"""Bounds of a hit rate: 0 and 1 are dogmatic."""


def _rows(view: View, ids: Sequence[str]) -> list[Appearance]:
    """The view's data of these ids, in the order of Γ."""
    wanted = set(ids)
    rows = [a for a in view.gamma.appearances if a.id in wanted]
    there = np.isfinite(view.gamma.camera.normalised(np.array([a.uv for a in rows]).reshape(-1, 2)))
    return [a for a, ray in zip(rows, there, strict=True) if ray.all()]


STEPS = 3
"""Steps of Gauss-Newton from the linear solution."""
NEAREST = 0.01
"""m; depth below which a place is not in front of a camera."""
WORST = 1e-15
"""Determinant of the normal equations, as a share of the cube of their mean eigenvalue, below which a place is not
determined."""


@dataclass(frozen=True)
class Places(Columns):
    """``at`` (T, 3) m, world; ``covariance`` (T, 3, 3) m²; ``chi2`` (T,) of the residuals.

    ``depth`` (T, V) m, NaN in other views.

    ``parallax`` (T,) rad, the greatest between two of the track's lines of sight; ``good`` (T,): solved, and in front
    of all its views.
    """

    at: Floats
    covariance: Floats
    chi2: Floats
    depth: Floats
    parallax: Floats
    good: Mask


class _Observed(NamedTuple):
    """``track``, ``view`` (O,); ``first`` (T,) where each track's begin; ``seen`` (O, 2) ideal.

    ``weight`` (O,) one over the noise.
    """

    track: Indices
    view: Indices
    first: Indices
    seen: Floats
    weight: Floats
    R: Floats
    t: Floats

    def total(self, values: Floats) -> Floats:
        """(T, ...) the sums of values (O, ...) over each track."""
        return np.add.reduceat(values, self.first, axis=0)


def places_of(sights: Sights, tracks: Indices, kind: Indices) -> Places:
    """The places of ``tracks`` (T, V) of appearance types ``kind`` (T,), two data or more, by least squares."""
    if not len(tracks):
        none = np.zeros(0)
        return Places(
            np.zeros((0, 3)), np.zeros((0, 3, 3)), none, np.zeros((0, tracks.shape[1])), none, none.astype(bool)
        )
    observed = _observed(sights, tracks, kind)
    at = _linear(sights, observed)
    for _ in range(STEPS):
        residual, jacobian, _ = _residuals(observed, at)
        at = at - _solved(*_normal(observed, residual, jacobian))
    residual, jacobian, z = _residuals(observed, at)
    normal, _ = _normal(observed, residual, jacobian)
    depth = np.full(tracks.shape, np.nan)
    depth[observed.track, observed.view] = z
    behind = observed.total((z <= NEAREST).astype(float)) > 0
    determined = np.linalg.det(normal) > WORST * (np.trace(normal, axis1=1, axis2=2) / 3.0) ** 3
    good = np.isfinite(at).all(axis=1) & ~behind & determined
    covariance = np.linalg.inv(np.where(good[:, None, None], normal, np.eye(3)))
    return Places(
        at, covariance, observed.total((residual**2).sum(axis=1)), depth, _parallax(sights, at, tracks >= 0), good
    )


def _observed(sights: Sights, tracks: Indices, kind: Indices) -> _Observed:
    track, view = np.nonzero(tracks >= 0)
    first = np.searchsorted(track, np.arange(len(tracks)))
    frames = sights.camera_from_world[view]
    seen, weight = sights.xy[view, tracks[track, view]], 1.0 / sights.sigma[view, kind[track]]
    return _Observed(track, view, first, seen, weight, frames[:, :3, :3], frames[:, :3, 3])


def _linear(sights: Sights, observed: _Observed) -> Floats:
    """(T, 3) the points nearest to the lines of sight."""
    rays = (np.column_stack([observed.seen, np.ones(len(observed.seen))])[:, None] @ observed.R)[:, 0]
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    across = np.eye(3) - rays[:, :, None] * rays[:, None]
    moved = (across @ sights.eye[observed.view][..., None])[..., 0]
    return _solved(observed.total(across), observed.total(moved))


def _solved(matrix: Floats, right: Floats) -> Floats:
    """(T, 3) the solutions; a hair on the diagonal keeps singular systems finite, ``good`` tells them later."""
    size = np.trace(matrix, axis1=1, axis2=2)[:, None, None]
    return np.asarray(np.linalg.solve(matrix + np.eye(3) * (1e-12 * size + 1e-30), right[..., None])[..., 0])


def _normal(observed: _Observed, residual: Floats, jacobian: Floats) -> tuple[Floats, Floats]:
    """The normal equations: (T, 3, 3) and (T, 3)."""
    turned = np.swapaxes(jacobian, 1, 2)
    return observed.total(turned @ jacobian), observed.total((turned @ residual[..., None])[..., 0])


def _residuals(observed: _Observed, at: Floats) -> tuple[Floats, Floats, Floats]:
    """Residuals (O, 2) in standard deviations, their derivatives by the place (O, 2, 3), depths (O,) m."""
    points = (observed.R @ at[observed.track][..., None])[..., 0] + observed.t
    z = points[:, 2]
    safe = np.where(np.abs(z) > NEAREST, z, NEAREST)
    ideal = points[:, :2] / safe[:, None]
    jacobian = (observed.R[:, :2] - ideal[..., None] * observed.R[:, 2:]) * (observed.weight / safe)[:, None, None]
    return (ideal - observed.seen) * observed.weight[:, None], jacobian, z


def _parallax(sights: Sights, at: Floats, mask: Mask) -> Floats:
    sight = at[:, None] - sights.eye
    sight /= np.maximum(np.linalg.norm(sight, axis=-1, keepdims=True), 1e-12)
    cosine = sight @ np.swapaxes(sight, 1, 2)
    both = mask[:, :, None] & mask[:, None]
    return np.arccos(np.clip(np.where(both, cosine, 1.0).min(axis=(1, 2)), -1.0, 1.0))
