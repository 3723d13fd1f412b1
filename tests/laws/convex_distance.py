"""How far convex bodies are apart, by pybullet: an oracle for A4 that shares no code with the engine."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

SCALE = 1000.0
"""Bodies are made so much larger, that the millimetre of margin which pybullet puts around them is a thousandth of
one."""


def distances(bodies):
    """Of each two bodies (vertices (V, 3) m of a convex surface, pose (4, 4)) their distance, m, negative inside."""
    world = pybullet.connect(pybullet.DIRECT)
    try:
        made = [_made(world, *body) for body in bodies]
        return [_distance(world, one, other) for one, other in combinations(made, 2)]
    finally:
        pybullet.disconnect(world)


def _made(world, vertices, pose):
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_MESH, vertices=(SCALE * np.asarray(vertices)).tolist(), physicsClientId=world
    )
    turn, place = Rotation.from_matrix(pose[:3, :3]).as_quat(), SCALE * pose[:3, 3]
    return pybullet.createMultiBody(
        1.0, shape, basePosition=place.tolist(), baseOrientation=turn.tolist(), physicsClientId=world
    )


def _distance(world, one, other):
    found = pybullet.getClosestPoints(one, other, SCALE * 100.0, physicsClientId=world)
    return min(point[8] for point in found) / SCALE
