"""Which keypoints of Γ look like which appearances of a type, by their descriptors alone, and the pose that one such pair fixes.

The lobe gives the direction of view, the angle the roll, the size the distance.

* ``Pairs``: P of them, ``datum`` (P,), ``lobe`` (P,), ``weight`` (P,)
* ``single_poses(index, pairs, data)``: their poses
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.data import Data, centre_of
from plogic.match.learned.lexicon import NTH
from sensing.detectors.edge_sides import fairly

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices, Mask
    from plogic.match.learned.learned_models import LearnedIndex


EACH = 3
"""Features that a keypoint is paired with, the most alike."""
CLOSE, OFF = 120.0, 100.0
"""Descriptors no farther apart are as good as equal; of those farther apart fewer are right, by a bell of this
width."""
MOST, SEEDS = 2500, 400
"""Pairs in all; those of them that poses are made of."""
CELL = 64.0
"""Pixels: half of the pairs are taken in turns from cells of the image this wide, so that no textured floor drowns an
object."""


@dataclass(frozen=True)
class Pairs:
    """P keypoints and appearances that look alike: half of them the weightiest, half of them the weightiest of each part of the image.

    ``weight`` (P,) in (0, 1], about as the odds that a pair is right: 1 for the keypoint of the image that looks most
    like the appearance, a third for the second, and so on. What looks like much else in the image says little: a corner
    of a letter is anywhere in print.
    """

    datum: Indices
    lobe: Indices
    weight: Floats

    def __len__(self) -> int:
        return len(self.datum)

    def first(self, count: int) -> Pairs:
        """The first of them, again half and half."""
        return Pairs(self.datum[:count], self.lobe[:count], self.weight[:count])


def pairs_of(index: LearnedIndex, data: Data) -> Pairs:
    """At most ``EACH`` features a keypoint, by their most similar appearance, and ``MOST`` pairs."""
    datum, lobe, apart = index.lexicon.alike(index.object_type.name, data)
    place = np.arange(len(lobe)) - np.searchsorted(lobe, lobe)
    near = place < NTH
    datum, lobe, apart, place = datum[near], lobe[near], apart[near], place[near]
    weight = np.exp(-0.5 * (np.maximum(apart - CLOSE, 0.0) / OFF) ** 2) / (1.0 + place) ** 1.5
    feature = index.cloud.feature[lobe]
    keep = np.lexsort((datum, -weight))  # of one datum by appearance, for so they come
    keep = _leading(keep, datum * len(index.points) + feature, 1)
    keep = _leading(keep, datum, EACH)
    best = keep[fairly(data.uv[datum[keep]], CELL)[:MOST]]
    return Pairs(datum[best], lobe[best], weight[best])


def _leading(order: Indices, owner: Indices, most: int) -> Indices:
    """Of pairs in some order the first few of each owner, in that order."""
    owners = owner[order]
    by_owner = np.argsort(owners, kind="stable")
    place = np.arange(len(order)) - np.searchsorted(owners[by_owner], owners[by_owner])
    return order[np.sort(by_owner[place < most])]


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


def plausible(index: LearnedIndex, poses: Floats) -> Mask:
    """(N,) finite, and the middle neither behind the camera, nor too near, nor absurdly far."""
    depth = poses[:, 2, :3] @ index.centre + poses[:, 2, 3]
    return np.asarray(
        np.isfinite(poses).all(axis=(1, 2)) & (depth > NEAREST * index.diameter) & (depth < FARTHEST * index.diameter)
    )
