"""Coarse poses are extended by the features that they expect: matched with what is near, refined, and again, ever more tightly (§6.3, §7).

* ``Typed``: the typed correspondences that the plain generators start from: every feature of a type with every datum
  that looks like it
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.frames import inverse
from geometry.poses.refine import refined_poses
from plogic.match.judged.evidence import clutter_density, density
from plogic.match.judged.rivals import apart

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices, Mask
    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.match.gamma.data import Data
    from plogic.match.hand.hand_models import TypeIndex


FEWEST = 4
"""Matches of different features with different data that a pose needs: any three have one."""


class Typed(NamedTuple):
    """``points`` (F, 3) m: the features' places.

    P pairs, by feature and then by datum: ``feature`` (P,) and ``datum`` (P,).
    """

    kind: ObjectType
    points: Floats
    feature: Indices
    datum: Indices

    @property
    def numbers(self) -> Indices:
        """(F,) how many data look like each feature."""
        return np.bincount(self.feature, minlength=len(self.points))

    def mask(self, data: int) -> Mask:
        """(F, A) which of so many data looks like which feature."""
        mask = np.zeros((len(self.points), data), bool)
        mask[self.feature, self.datum] = True
        return mask


def pairs_of(index: TypeIndex, data: Data) -> Typed:
    """All pairs of one type's features and data that look like them."""
    return Typed(index.object_type, index.points, *np.nonzero(index.allowed(data)))


def off(poses: Floats, pairs: Typed, uv: Floats, camera: Camera) -> Floats:
    """(N, P) pixels from where N poses show the pairs' features to their data, ``uv`` (A, 2) undistorted.

    Infinite behind the camera.
    """
    at = np.einsum("nij,fj->nfi", poses[:, :3, :3], pairs.points) + poses[:, None, :3, 3]
    depth = np.where(at[..., 2] > 0.0, at[..., 2], np.nan)
    shown = camera.to_pixels(at[..., :2] / depth[..., None])
    return np.nan_to_num(np.linalg.norm(shown[:, pairs.feature] - uv[pairs.datum], axis=2), nan=np.inf)


WIDENED = 4.0, 2.0, 1.0
"""Of the rounds, how many times wider than the detector's noise places may be: four points fix a pose badly."""
ALIKE = float(np.radians(3.0)), 0.03
"""Radians, and share of the distance, by less than which poses differ of which one is extended."""


class Scene(NamedTuple):
    """One type and Γ: its typed pairs, and ``uv`` (A, 2), the data's undistorted pixels."""

    of: TypeIndex
    pairs: Typed
    data: Data
    kb: KnowledgeBase
    uv: Floats


def scene_of(index: TypeIndex, data: Data, kb: KnowledgeBase) -> Scene:
    """What the plain generators ask for."""
    camera = data.camera
    return Scene(index, pairs_of(index, data), data, kb, camera.to_pixels(camera.normalised(data.uv)))


def worth(scene: Scene, poses: Floats, wider: float) -> Floats:
    """(N,) the evidence (§8) for poses (N, 4, 4) by the nearest datum of each feature that the nearest view cell shows; noise so many times wider.

    A datum may serve several features: what is left is verified.
    """
    index, pairs, kb = scene.of, scene.pairs, scene.kb
    features = index.object_type.features
    hit = np.array([kb.rates.hit.get(feature.type, 0.8) for feature in features])
    sigma = wider * np.array([kb.rates.sigma_of(feature.type) for feature in features])
    apart_by = off(poses, pairs, scene.uv, scene.data.camera)
    clutter = clutter_density(kb, scene.data)[pairs.datum]
    gain = np.log1p(hit[pairs.feature] * (density(apart_by, sigma[pairs.feature]) / clutter - 1.0))
    missed = np.log(1.0 - hit)
    total = np.tile(missed, (len(poses), 1))
    held, first = np.unique(pairs.feature, return_index=True)
    total[:, held] = np.maximum(np.maximum.reduceat(gain, first, axis=1), missed[held])
    return np.asarray(np.where(_shown(scene, poses), total, 0.0).sum(axis=1))


def _shown(scene: Scene, poses: Floats) -> Mask:
    """(N, F) what the nearest view cell of each pose shows."""
    cells = scene.of.cells
    viewpoints = np.array([inverse(pose)[:3, 3] for pose in poses]).reshape(-1, 3) - cells.centre
    return np.asarray(cells.visible[cells.nearest(viewpoints / np.linalg.norm(viewpoints, axis=1, keepdims=True))])


def best(scene: Scene, poses: Floats, values: Floats, most: int) -> Indices:
    """The best of poses (N, 4, 4) by their ``values`` (N,), no two alike."""
    middles = poses[:, :3, :3] @ scene.of.cells.centre + poses[:, :3, 3]
    return np.array(apart(poses, middles, values, most, ALIKE), np.intp)


def extended(scene: Scene, poses: Floats, most: int) -> list[Floats]:
    """At most so many refined poses (4, 4), no two alike, by their evidence, the best first."""
    for wider in WIDENED:
        poses = np.array([_refined(scene, pose, wider) for pose in poses]).reshape(-1, 4, 4)
    values = worth(scene, poses, WIDENED[-1])
    return [poses[i] for i in best(scene, poses, values, most)]


def _refined(scene: Scene, pose: Floats, wider: float) -> Floats:
    """Least squares on the features that the pose expects and that have a datum near.

    As it was where those are too few.
    """
    pairs, sigma = scene.pairs, scene.kb.rates.sigma
    reach = wider * scene.kb.rates.match_tolerance
    apart_by = off(pose[None], pairs, scene.uv, scene.data.camera)[0]
    near = np.flatnonzero((apart_by <= reach) & _shown(scene, pose[None])[0, pairs.feature])
    near = near[np.argsort(apart_by[near], kind="stable")]
    chosen: list[int] = []
    features, data = set(), set()
    for pair in near.tolist():
        feature, datum = pairs.feature[pair], pairs.datum[pair]
        if feature not in features and datum not in data:
            chosen.append(pair)
            features.add(feature)
            data.add(datum)
    if len(chosen) < FEWEST:
        return pose
    points, uv = pairs.points[pairs.feature[chosen]], scene.data.uv[pairs.datum[chosen]]
    weights = np.ones((1, len(chosen)))
    return np.asarray(
        refined_poses(pose[None], points[None], uv[None], weights, scene.data.camera, huber=wider * sigma)[0]
    )
