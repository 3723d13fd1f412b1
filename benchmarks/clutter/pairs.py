"""Typed correspondences of all types, which all peers of ``plogic bench clutter`` start from.

Every feature with every datum that looks like it.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from geometry.poses.refine import refine_poses
from plogic.match.judged.expectation import FEWEST
from plogic.match.plain.quadruples import Typed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from sensing.appearance import Gamma

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

Answer = tuple[str, "NDArray[np.float64]"]
"""Type and ``camera_from_object`` (4, 4)."""


def typed(kb: KnowledgeBase, gamma: Gamma) -> list[Typed]:
    """Of all types of which ``FEWEST`` features or more find data that look like them.

    Most pairs first, for whose data are there has more.
    """
    data = by_type(gamma)
    some = [
        pairs for pairs in (correspondences(kind, data) for kind in kb.types) if len(np.unique(pairs.feature)) >= FEWEST
    ]
    return sorted(some, key=lambda pairs: -len(pairs.feature))


def by_type(gamma: Gamma) -> dict[str, list[int]]:
    """The data of each appearance type."""
    rows: dict[str, list[int]] = defaultdict(list)
    for i, appearance in enumerate(gamma.appearances):
        rows[appearance.type].append(i)
    return rows


def correspondences(kind: ObjectType, data: dict[str, list[int]]) -> Typed:
    """All pairs of a feature of one type and a datum that looks like it; ``data`` by appearance type."""
    table = kind.lobes
    rows = [(int(f), i) for f, look in zip(table.feature, table.types, strict=True) for i in data.get(look, ())]
    pairs = np.unique(np.array(rows, np.intp).reshape(-1, 2), axis=0)
    points = np.zeros((table.features, 3))
    points[table.feature] = table.at
    return Typed(kind, points, pairs[:, 0], pairs[:, 1])


def ideal(gamma: Gamma) -> Floats:
    """(N, 2) pixels of a camera of the same K whose lens does not distort."""
    return gamma.camera.to_pixels(gamma.camera.normalised(gamma.uv))


def different(pairs: Typed, inlying: Indices) -> int:
    """How many of these pairs (N,) count, features that share a datum and data that share a feature counted once."""
    return min(len(np.unique(pairs.feature[inlying])), len(np.unique(pairs.datum[inlying])))


def refined(pose: Floats, points: Floats, datum: Indices, gamma: Gamma, kb: KnowledgeBase) -> Floats:
    """The pose (4, 4) after least squares on points (N, 3) m matched with data (N,).

    A residual beyond the noise weighs less.
    """
    weights = np.ones((1, len(datum)))
    return refine_poses(pose[None], points[None], gamma.uv[datum][None], weights, gamma.camera, huber=kb.rates.sigma)[
        0
    ][0]
