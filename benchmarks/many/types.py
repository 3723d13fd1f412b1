"""The types of ``plogic bench many``: polyhedra written by hand, and clouds made of what was learned from meshes.

* ``many_kb(learned)``: Σ of 50 types, half of them polyhedra with corners and with patches on their faces

There are ten YCB meshes only. The other learned types are new prints of these, as packages of one make have: the same
surface, but other places of it are features where the learned cloud has enough, their words are exchanged and their
directions turned on the surface. All types look like ones of one vocabulary; the corners of polyhedra share a small
part of it, as the junctions of edges do.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.types import (
    DIAMETER,
    HALF_ANGLE,
    LEAST_HALF_ANGLE,
    Detector,
    body_frames,
    knowledge_base,
    learned_types,
    made,
    scattered,
    type_names,
)
from kb.surfaces.surface import Surface

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType

    Floats = NDArray[np.float64]

TYPES, LEARNED = 50, 25
"""Types in all, and how many of them are learned ones."""
FEATURES = 100
"""Of a type."""
LOOKS, JUNCTIONS = 200, 20
"""Appearance types in all; corners look like one of the first so many, patches like one of the others."""
DETECTOR = Detector("many", hit=0.8, sigma=1.0, turn=float(np.radians(3.0)))
"""20 % missed, one pixel and three degrees of noise."""
PLANES = 6, 12
"""Least and most planes that bound a polyhedron, besides those that close it."""
PRIOR = 0.15
"""Of a type to be there: seven or eight objects of 50 types."""
CLUTTER = 50.0
"""Data of clutter that Σ expects in an image, in all; about what scenes of other seeds have on the average."""


def many_kb(learned: KnowledgeBase | None, seed: int = 0) -> KnowledgeBase:
    """Σ of ``TYPES`` types, ``LEARNED`` of them made of what was ``learned``.

    All of them polyhedra where nothing was.
    """
    rng = np.random.default_rng([seed, TYPES, LOOKS])
    names = type_names(LOOKS)
    prints = [] if learned is None else printed(learned, names, rng)
    polyhedra = [polyhedron(f"p{i:02d}", names, rng) for i in range(TYPES - len(prints))]
    return with_rates([*polyhedra, *prints], names)


def with_rates(types: Sequence[ObjectType], names: tuple[str, ...]) -> KnowledgeBase:
    """Σ of some types with the statistics of the detector.

    Clutter is as frequent as what it looks like is among the features.
    """
    kb = knowledge_base(types, names, DETECTOR)
    clutter = {name: CLUTTER * share for name, share in zip(names, frequencies(kb), strict=True)}
    return replace(
        kb, name="many", rates=replace(kb.rates, clutter=clutter, prior=dict.fromkeys(kb.rates.prior, PRIOR))
    )


def frequencies(kb: KnowledgeBase) -> Floats:
    """(L,) share of each appearance type among the features of all types, one added to each: they sum to 1."""
    number = {name: i for i, name in enumerate(kb.appearance_types)}
    looks = [number[name] for kind in kb.types for name in kind.lobes.types]
    counts = np.bincount(np.array(looks, np.intp), minlength=len(number)) + 1.0
    return np.asarray(counts / counts.sum())


def polyhedron(name: str, names: Sequence[str], rng: np.random.Generator) -> ObjectType:
    """A random convex polyhedron.

    A feature at each corner, the others patches on its faces, more on the larger ones.
    """
    surface = random_polyhedron(rng)
    corners = surface.vertices
    at, normal = scattered(surface, FEATURES - len(corners), rng)
    frames = body_frames(np.concatenate([_outward(surface), normal]), rng)
    looks = np.concatenate(
        [rng.integers(JUNCTIONS, size=len(corners)), rng.integers(JUNCTIONS, len(names), size=len(at))]
    )
    return made(
        name, surface, np.concatenate([corners, at]), frames, [names[i] for i in looks], np.full(FEATURES, HALF_ANGLE)
    )


def random_polyhedron(rng: np.random.Generator) -> Surface:
    """The space between planes that touch an ellipsoid, opposite pairs of planes along its axes among them.

    About its middle, closed.
    """
    import trimesh
    from scipy.spatial import HalfspaceIntersection

    axes = rng.uniform(0.5, 1.0, 3)
    tilt = 0.15 * rng.normal(size=(6, 3))
    sides = np.concatenate([np.eye(3), -np.eye(3)]) + tilt
    normals = np.concatenate([sides, rng.normal(size=(int(rng.integers(*PLANES, endpoint=True)) - 3, 3))])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = np.linalg.norm(normals * axes, axis=1)
    corners = HalfspaceIntersection(np.column_stack([normals, -offsets]), np.zeros(3)).intersections
    hull = trimesh.convex.convex_hull(np.unique(np.round(corners, 6), axis=0))
    vertices = np.asarray(hull.vertices)
    vertices = vertices * (rng.uniform(*DIAMETER) / float(np.linalg.norm(np.ptp(vertices, axis=0))))
    return Surface(vertices, np.asarray(hull.faces))


def _outward(surface: Surface) -> Floats:
    """(V, 3) unit: at each vertex the mean of the normals of its facets, each by its angle there."""
    import trimesh

    mesh = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
    normals = np.asarray(mesh.vertex_normals)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def printed(learned: KnowledgeBase, names: tuple[str, ...], rng: np.random.Generator) -> list[ObjectType]:
    """``LEARNED`` types: those that were learned, and new prints of them, one after the other."""
    whole = [kind for kind in learned_types(learned, 2 * FEATURES, len(names)) if kind.surface is not None]
    kinds = [_part(kind, 0) for kind in whole]
    while whole and len(kinds) < LEARNED:
        kinds.append(reprinted(whole[len(kinds) % len(whole)], f"{len(kinds):02d}", names, rng))
    return kinds[:LEARNED]


def _part(kind: ObjectType, first: int) -> ObjectType:
    """The same with ``FEATURES`` of its features, from the ``first`` on."""
    some = kind.features[first : first + FEATURES]
    at, frames = np.array([f.at for f in some]), np.array([f.rotation for f in some])
    half = np.array([f.appearances[0].lobe.half_angle for f in some])
    return made(kind.name, kind.surface, at, frames, [f.type for f in some], half)


def reprinted(kind: ObjectType, suffix: str, names: Sequence[str], rng: np.random.Generator) -> ObjectType:
    """A new print: the second ``FEATURES`` features, if so many, exchanged looks, each turned about its lobe's axis."""
    part = _part(kind, FEATURES if len(kind.features) >= 2 * FEATURES else 0)
    other = dict(zip(names, rng.permutation(names).tolist(), strict=True))
    frames = body_frames(np.array([f.rotation[:, 2] for f in part.features]), rng)
    half = np.full(len(part.features), LEAST_HALF_ANGLE)
    return made(
        f"{kind.name}_{suffix}",
        kind.surface,
        np.array([f.at for f in part.features]),
        frames,
        [other[f.type] for f in part.features],
        half,
    )
