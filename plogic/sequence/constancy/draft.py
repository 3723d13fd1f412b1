"""The paper's third outcome (§1): an unknown object becomes a draft of a new type in Σo.

Its frame stands at the centroid of its features, turned as the world is: z up. Each feature is as it was seen: one
appearance, whose lobe holds all viewpoints from which it was, and a margin. What has not been looked at has no features
yet.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from kb.clouds.cloud import ObjectType
from kb.clouds.lobes import Lobe
from kb.clouds.tree import Branch, build_tree, features_of
from plogic.sequence.constancy.draft_body import draft_body
from plogic.sequence.constancy.draft_frames import feature_frame

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.sequence.constancy.sightings import SeenFeature

    Floats = NDArray[np.float64]

MARGIN = math.radians(30.0)
"""By which a lobe is wider than the viewpoints that were there."""
LEAST_HALF_ANGLE, MOST_HALF_ANGLE = math.radians(55.0), math.radians(100.0)
"""Of a draft's lobe: most marks are seen from 55 degrees aside of a viewpoint, few from far behind."""
NEARER, FARTHER = 0.5, 2.0
"""The range of a lobe, as a share of the least and of the greatest distance from which the feature was seen."""


def draft_type(name: str, features: Sequence[SeenFeature], f_ref: float) -> ObjectType:
    """The draft ``name``; ranges hold for the focal length ``f_ref``, pixels. Its body is what ``draft_body`` says; without one it is not opaque."""
    centroid = np.mean([feature.at for feature in features], axis=0)
    parts = [_branch(f"f{i}", feature, centroid, f_ref) for i, feature in enumerate(features, 1)]
    tree = build_tree(Branch("object", name, name, parts=parts))
    cloud, every = features_of(tree)
    body = draft_body(features, centroid)
    return ObjectType(name, tree, cloud, every, body, opaque=body is not None, symmetries=np.eye(4)[None])


def _branch(name: str, feature: SeenFeature, centroid: Floats, f_ref: float) -> Branch:
    frame = feature_frame(feature)
    shown = Branch("appearance", "", feature.type, lobe=draft_lobe(feature, frame, f_ref))
    return Branch("feature", name, feature.type, feature.at - centroid, frame, [shown])


def draft_lobe(feature: SeenFeature, world_from_feature: Floats, f_ref: float) -> Lobe:
    """The lobe in the feature's frame: about the mean direction to those who saw it, as wide as all of them and a margin need."""
    towards = np.array([sighting.eye - feature.at for sighting in feature.sightings])
    far = np.linalg.norm(towards, axis=1)
    unit = towards / far[:, None]
    axis = unit.sum(axis=0)
    axis /= np.linalg.norm(axis)
    widest = float(np.arccos(np.clip(unit @ axis, -1.0, 1.0)).max())
    scaled = far * f_ref / np.array([sighting.focal for sighting in feature.sightings])
    half = min(max(widest + MARGIN, LEAST_HALF_ANGLE), max(widest, MOST_HALF_ANGLE))
    return Lobe(axis @ world_from_feature, half, NEARER * float(scaled.min()), FARTHER * float(scaled.max()))
