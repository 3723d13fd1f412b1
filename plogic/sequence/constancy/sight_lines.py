"""The unexplained data of a sequence as arrays: lines of sight from known places.

Vocabulary: a ``Sights`` holds V views of at most N data each; a *track* is a row (V,) of indices, one datum a view at
most, -1 for none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import inverse

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.cloud import Rates
    from plogic.sequence.views.view import View
    from sensing.appearance import Appearance


HIT = 0.8
"""Chance that a feature is detected, where the KB states none (as ``kb.yaml`` has it)."""
CLUTTER = 1.0
"""Data of clutter an image, of an appearance type of which the KB states none (as the engine has it)."""


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
        places = self.xy[np.arange(len(self.views)), tracks]
        return np.where(tracks[..., None] >= 0, places, np.nan)

    def in_image(self, world: Floats) -> Mask:
        """(T, V) whether the places (T, 3) m lie in each view's image."""
        masks = []
        for view, frame in zip(self.views, self.camera_from_world, strict=True):
            points = world @ frame[:3, :3].T + frame[:3, 3]
            masks.append(view.gamma.camera.contains(view.gamma.camera.project(points)))
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
    if not rows:
        return rows
    there = np.isfinite(view.gamma.camera.normalised(np.array([a.uv for a in rows])))
    return [a for a, ray in zip(rows, there, strict=True) if ray.all()]
