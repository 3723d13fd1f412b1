"""A knowledge base of one learned type, a cube with a keypoint on each side; the planes of a body."""

from __future__ import annotations

import networkx as nx
import numpy as np

from kb.clouds.cloud import KnowledgeBase, ObjectType, Rates
from kb.clouds.learned import LearnedCloud
from kb.surfaces.surface import Surface

CUBE = Surface(
    np.array([(x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]),
    np.array(
        [
            (0, 1, 3),
            (0, 3, 2),
            (4, 6, 7),
            (4, 7, 5),
            (0, 4, 5),
            (0, 5, 1),
            (2, 3, 7),
            (2, 7, 6),
            (0, 2, 6),
            (0, 6, 4),
            (1, 5, 7),
            (1, 7, 3),
        ]
    ),
)
SIDES = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=float)
UPS = np.roll(SIDES, 1, axis=1)


def learned_kb(*, at=SIDES * 0.1, axis=SIDES, up=UPS, hit=0.5, half_angle=0.3, word=0, size=0.01, feature=None):
    """One learned type, a cube with a keypoint in the middle of each side unless asked otherwise."""
    n, at = len(axis), np.asarray(at)
    full = {
        name: np.broadcast_to(value, (n,))
        for name, value in {"hit": hit, "half_angle": half_angle, "lobe_word": word, "size": size}.items()
    }
    feature = np.arange(n) if feature is None else np.asarray(feature)
    cloud = LearnedCloud(
        at=at, sigma=np.full(len(at), 0.001), normal=np.tile((0.0, 0, 1), (len(at), 1)), word=np.zeros(len(at), int), feature=feature,
        descriptor=np.zeros((n, 128), np.uint8), axis=axis, up=up, r_min=np.full(n, 0.1), r_max=np.full(n, 5.0), **full,
    )  # fmt: skip
    kind = ObjectType("cube", nx.DiGraph(), (), (), CUBE, opaque=True, symmetries=np.eye(4)[None], learned=cloud)
    return KnowledgeBase("learned", (kind,), (), Rates({}, {}, {}), 600.0, "", "")


def outward(surface):
    """Unit normals (T, 3) and offsets (T,) of the facets' planes."""
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return normal, (normal * a).sum(axis=1)
