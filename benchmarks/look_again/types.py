"""The types of ``plogic bench look-again``.

Boxes that a first look often cannot tell apart, or of which it cannot tell which way they stand.

* *twins*: two types of one body that look the same but for a mark low on one side
* *turned*: one type that looks the same when it is turned by half, but for a mark low on one side
* *plain*: one type without a mark, low and wide: it stands before others
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.types import HALF_ANGLE, Detector, body_frames, knowledge_base, made, type_names
from kb.surfaces.surface import Surface

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType

    Floats = NDArray[np.float64]

DETECTOR = Detector("robot", 0.6, 1.0, float(np.radians(6.0)))
"""What reports the features, and what perception is told of it."""
CLUTTER, LOOKS = 60, 30
"""Data of clutter an image, on the average; appearance types in all."""
FEATURES, MARK = 90, 5
"""Features of a body beside its mark, and those of a mark."""
TALL = (0.10, 0.14), (0.10, 0.14), (0.20, 0.26)
LOW = (0.10, 0.14), (0.13, 0.17), (0.11, 0.14)
"""Least and greatest width, depth and height of boxes with a mark and of the plain one, m."""
FAMILIES = 2
"""Of twins, and of turned ones."""
SIDE = np.array([1.0, 0.0, 0.0])
"""Where the mark is, object frame."""
SPREAD = 0.8
"""Share of a mark's side over which it is spread; it keeps to the lower half."""

Cloud = tuple["Floats", "Floats", list[str]]  # places (N, 3), frames (N, 3, 3), looks


def look_alikes(seed: int) -> KnowledgeBase:
    """Σ: twins ``twin0_a``, ``twin0_b``, ...; ``turned0``, ...; and ``plain``."""
    rng = np.random.default_rng([seed, 2006])
    names = type_names(LOOKS)
    types: list[ObjectType] = []
    for i in range(FAMILIES):
        types += _twins(f"twin{i}", names, rng)
        types.append(_turned(f"turned{i}", names, rng))
    size = _size(LOW, rng)
    types.append(_type("plain", size, [_scattered(size, FEATURES, names, rng)]))
    return knowledge_base(types, names, DETECTOR, CLUTTER)


def _twins(name: str, names: Sequence[str], rng: np.random.Generator) -> list[ObjectType]:
    size = _size(TALL, rng)
    common, (at, frames, looks) = _scattered(size, FEATURES, names, rng), _mark(size, names, rng)
    others = [names[(names.index(look) + 1 + int(rng.integers(len(names) - 1))) % len(names)] for look in looks]
    return [
        _type(f"{name}_{which}", size, [common, (at, frames, some)]) for which, some in (("a", looks), ("b", others))
    ]


def _turned(name: str, names: Sequence[str], rng: np.random.Generator) -> ObjectType:
    size, half = _size(TALL, rng), np.diag([-1.0, -1.0, 1.0])
    at, frames, looks = _scattered(size, FEATURES // 2, names, rng)
    return _type(name, size, [(at, frames, looks), (at @ half.T, half @ frames, looks), _mark(size, names, rng)])


def _type(name: str, size: Floats, clouds: Sequence[Cloud]) -> ObjectType:
    at, frames = (np.concatenate([cloud[i] for cloud in clouds]) for i in (0, 1))
    looks = [look for cloud in clouds for look in cloud[2]]
    return made(name, _box(size), at, frames, looks, np.full(len(looks), HALF_ANGLE))


def _size(ranges: Sequence[tuple[float, float]], rng: np.random.Generator) -> Floats:
    return np.array([rng.uniform(*some) for some in ranges])


def _box(size: Floats) -> Surface:
    """A box that stands on z = 0, its middle over the origin."""
    import trimesh

    mesh = trimesh.creation.box(extents=size)
    return Surface(np.asarray(mesh.vertices) + _raised(size), np.asarray(mesh.faces))


def _raised(size: Floats) -> Floats:
    return np.array([0.0, 0.0, size[2] / 2.0])


def _scattered(size: Floats, count: int, names: Sequence[str], rng: np.random.Generator) -> Cloud:
    """Features over the sides and the top, by area."""
    normals = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], float)
    area = np.prod(size) / np.abs(normals @ size)
    normal = normals[rng.choice(5, count, p=area / area.sum())]
    at = rng.uniform(-0.46, 0.46, (count, 3)) * size
    at = np.where(normal != 0.0, normal * size / 2.0, at) + _raised(size)
    return at, body_frames(normal, rng), [names[i] for i in rng.integers(len(names), size=count)]


def _mark(size: Floats, names: Sequence[str], rng: np.random.Generator) -> Cloud:
    """``MARK`` features on the lower half of one side."""
    across = rng.uniform(-0.5, 0.5, MARK) * SPREAD * size[1]
    at = np.column_stack([np.full(MARK, size[0] / 2.0), across, rng.uniform(0.08, 0.42, MARK) * size[2]])
    return at, body_frames(np.tile(SIDE, (MARK, 1)), rng), [names[i] for i in rng.integers(len(names), size=MARK)]
