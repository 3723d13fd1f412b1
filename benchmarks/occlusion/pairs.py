"""Random posed pairs for ``plogic bench occlusion``, by kind.

Those of one kind share no volume (A4), equal silhouettes that cross aside.

``Pair("nested", x, y, None)``; of stacks and of equal silhouettes the exact relation is known from how they were made.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.occlusion.bodies import Body, body, concave_bodies, convex_bodies, placed, posed, stack_surface
from benchmarks.occlusion.stacks import clamps, codes, grown
from geometry.bodies.overlap import solid_overlap
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw, transform_points
from geometry.visibility.roc import ROC20

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from geometry.visibility.occlusion import PosedSurface
    from geometry.visibility.roc import Roc

TRIES = 50
"""Poses tried for two bodies until they share no volume."""


class Pair(NamedTuple):
    """Two posed surfaces; ``known``: their relation, where the making of them decides it."""

    kind: str
    x: PosedSurface
    y: PosedSurface
    known: Roc | None = None


KINDS = ("convex", "concave", "interlocking", "touching", "nested", "equal", "stacks", "clamps")


def pairs(kind: str, count: int, seed: int) -> Iterator[Pair]:
    """``count`` pairs of a kind."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    if kind == "stacks":
        yield from _stacks(rng, count)
        return
    if kind == "clamps":
        yield from (_of_grid(rng, grid, kind) for grid in clamps(rng, count))
        return
    makers = {
        "convex": lambda: _anywhere(rng, "convex", _convex(), _convex()),
        "concave": lambda: _anywhere(rng, "concave", _concave(), _concave() + _convex()),
        "interlocking": lambda: _interlocking(rng),
        "touching": lambda: _touching(rng),
        "nested": lambda: _nested(rng),
        "equal": lambda: _equal(rng),
    }
    for _ in range(count):
        yield makers[kind]()


@cache
def _convex() -> tuple[Body, ...]:
    return tuple(convex_bodies())


@cache
def _concave() -> tuple[Body, ...]:
    return tuple(concave_bodies())


@cache
def _rod() -> Body:
    low, high = np.array([-0.08, -0.08, -1.5]), np.array([0.08, 0.08, 1.5])
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return body(
        low + corners * (high - low), np.array([facet for a, b, c, d in sides for facet in ((a, b, c), (a, c, d))])
    )


def _turn(rng: np.random.Generator) -> NDArray[np.float64]:
    return rotation_from_quat_xyzw(rng.normal(size=(1, 4)))[0]


def _pose(rng: np.random.Generator, aside: float = 0.8, near: float = 3.0, far: float = 7.0) -> NDArray[np.float64]:
    return from_rotation_translation(_turn(rng), [*rng.uniform(-aside, aside, 2), rng.uniform(near, far)])


def _pick(rng: np.random.Generator, some: tuple[Body, ...]) -> Body:
    return some[int(rng.integers(len(some)))]


def _anywhere(rng: np.random.Generator, kind: str, some: tuple[Body, ...], others: tuple[Body, ...]) -> Pair:
    x, y = _pick(rng, some), _pick(rng, others)
    T_x, T_y = _pose(rng), _pose(rng)
    for _ in range(TRIES):
        if not solid_overlap(x.solid, T_x, y.solid, T_y):
            break
        T_y = _pose(rng)
    return Pair(kind, posed(x, T_x), posed(y, T_y))


def _interlocking(rng: np.random.Generator) -> Pair:
    """A rod through a ring, a hook's or a U's hollow.

    Or two concave bodies so near that they may reach into each other.
    """
    frame = _concave()[int(rng.integers(1, 4))]
    T = _pose(rng, 0.3, 4.0, 6.0)
    other = _rod() if rng.random() < 0.7 else _pick(rng, _concave())
    for _ in range(TRIES):
        lean = (
            rotation_from_quat_xyzw(np.array([[*rng.normal(0, 0.15, 2), 0.0, 1.0]]))[0]
            if other is _rod()
            else _turn(rng)
        )
        inside = from_rotation_translation(lean, [*rng.uniform(-0.25, 0.25, 2), rng.uniform(0.0, 0.4)])
        if not solid_overlap(frame.solid, T, other.solid, T @ inside):
            break
    else:
        return _anywhere(rng, "interlocking", _concave(), _concave())
    return Pair("interlocking", posed(frame, T), posed(other, T @ inside))


def _touching(rng: np.random.Generator) -> Pair:
    """One stands on another's face, shifted at will.

    Or their images touch: the one is the other, seen farther off and beside it.
    """
    if rng.random() < 0.5:
        x, y = _pick(rng, _concave() + _convex()), _pick(rng, _concave() + _convex())
        T = _pose(rng)
        height = float(x.vertices[:, 2].max())
        upon = from_rotation_translation(np.eye(3), [*rng.uniform(-0.5, 0.5, 2), height])
        return Pair("touching", posed(x, T), posed(y, T @ upon))
    one = _pick(rng, _convex() + _concave())
    points = transform_points(_pose(rng), one.vertices)
    seen = points[:, :2] / points[:, 2:]
    shift = np.array([np.ptp(seen[:, 0]), 0.0]) if rng.random() < 0.5 else np.array([0.0, np.ptp(seen[:, 1])])
    moved = np.c_[seen + shift, np.ones(len(seen))] * points[:, 2:] * rng.uniform(0.7, 1.5)
    return Pair("touching", placed(points, one.triangles), placed(moved, one.triangles))


def _nested(rng: np.random.Generator) -> Pair:
    """A body, and a small one on the line of sight to a point of it, before or behind it."""
    large, small = _pick(rng, _convex() + _concave()), _pick(rng, _convex() + _concave())
    T = _pose(rng, 0.5, 4.0, 6.0)
    corners = transform_points(T, large.vertices)
    aim = corners[large.triangles[int(rng.integers(len(large.triangles)))]].mean(axis=0)
    factor, size = rng.choice([0.4, 1.6]) * rng.uniform(0.9, 1.1), rng.uniform(0.05, 0.4)
    points = small.vertices @ _turn(rng).T * size * factor + aim * factor
    return Pair("nested", placed(corners, large.triangles), placed(points, small.triangles))


def _equal(rng: np.random.Generator) -> Pair:
    """A body, and the same with each corner moved along its line of sight.

    By one factor, or by one that changes across the image.
    """
    one = _pick(rng, _convex() + _concave())
    points = transform_points(_pose(rng), one.vertices)
    if rng.random() < 0.6:
        factor = rng.choice([0.4, 0.6, 1.7, 2.5])
        front: Roc = "totally_occludes_eq" if factor > 1 else "totally_occluded_by_eq"
        return Pair("equal", placed(points, one.triangles), placed(points * factor, one.triangles), front)
    side = points[:, 0] / points[:, 2]
    leaning = 1.0 + 0.8 * (side - side.mean()) / np.ptp(side)
    return Pair(
        "equal", placed(points, one.triangles), placed(points * leaning[:, None], one.triangles), "mutually_occludes_eq"
    )


def _stacks(rng: np.random.Generator, count: int) -> Iterator[Pair]:
    """Half of them as rarely as they come, half such that each relation is as likely as any other."""
    grids = np.concatenate(list(grown(rng, max(count, 400), bodies=2)))
    found = codes(grids, 1, 2)
    for n in range(count):
        some = (
            np.flatnonzero(found == int(rng.choice(np.unique(found[found >= 0]))))
            if n % 2
            else np.flatnonzero(found >= 0)
        )
        yield _of_grid(rng, grids[int(rng.choice(some))])


def _of_grid(rng: np.random.Generator, grid: NDArray[np.int8], kind: str = "stacks") -> Pair:
    """Uneven lines and layers: squares of 14 px or more, layers of 0.2 m or more."""
    side, _, layers = grid.shape
    across, down = (np.cumsum(np.r_[rng.uniform(100, 250), rng.uniform(14, 40, side)]) for _ in range(2))
    depth = np.cumsum(np.r_[2.0, rng.uniform(0.2, 0.8, layers)])
    first, second = (1, 2) if rng.random() < 0.5 else (2, 1)
    x, y = (stack_surface(grid == name, across, down, depth) for name in (first, second))
    return Pair(kind, x, y, ROC20[int(codes(grid[None], first, second)[0])])
