"""The pose that one pair fixes: the lobe gives the direction of view, the angle the roll, the size the distance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.data import centre_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data
    from plogic.match.learned.keypoint_pairs import Pairs
    from plogic.match.learned.learned_index import LearnedIndex

    Floats = NDArray[np.float64]

NEAREST, FARTHEST = 0.6, 40.0
"""Distances of the object's middle, in its diameters, that are believed."""


def single_poses(index: LearnedIndex, pairs: Pairs, data: Data) -> Floats:
    """(N, 4, 4) camera_from_object of those of the P pairs that place the object before the camera, N ≤ P."""
    at = sights(pairs, data) * depths(index, pairs, data)[:, None]
    poses = np.zeros((len(at), 4, 4))
    poses[:, :3, :3] = turns(index, pairs, data)
    poses[:, :3, 3] = at - np.einsum("nij,nj->ni", poses[:, :3, :3], index.places[pairs.lobe])
    poses[:, 3, 3] = 1.0
    return poses[plausible(index, poses)]


def sights(pairs: Pairs, data: Data) -> Floats:
    """(P, 3) the lines of sight to the pairs' keypoints, camera frame, of depth 1."""
    ideal = data.ideal[pairs.datum]
    return np.column_stack([(ideal - centre_of(data.camera)) / data.camera.f, np.ones(len(ideal))])


def depths(index: LearnedIndex, pairs: Pairs, data: Data) -> Floats:
    """(P,) metres at which the lobes' sizes are those of the keypoints."""
    return np.asarray(index.cloud.size[pairs.lobe] * data.camera.f / data.scale[pairs.datum])


def turns(index: LearnedIndex, pairs: Pairs, data: Data) -> Floats:
    """(P, 3, 3) the rotations at which each lobe is seen from its middle, its appearance turned as the keypoint is."""
    cloud, angle, at = index.cloud, data.angle[pairs.datum], sights(pairs, data) * depths(index, pairs, data)[:, None]
    back = -at / np.linalg.norm(at, axis=1, keepdims=True)
    screen = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))])
    up = screen - (screen * back).sum(axis=1, keepdims=True) * back
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    camera = np.stack([back, up, np.cross(back, up)], axis=2)
    axis, own_up = cloud.axis[pairs.lobe], cloud.up[pairs.lobe]
    own = np.stack([axis, own_up, np.cross(axis, own_up)], axis=2)
    return np.asarray(camera @ np.swapaxes(own, 1, 2))


def plausible(index: LearnedIndex, poses: Floats) -> NDArray[np.bool_]:
    """(N,) finite, and the middle neither behind the camera, nor too near, nor absurdly far."""
    depth = poses[:, 2, :3] @ index.centre + poses[:, 2, 3]
    return np.asarray(
        np.isfinite(poses).all(axis=(1, 2)) & (depth > NEAREST * index.diameter) & (depth < FARTHEST * index.diameter)
    )
