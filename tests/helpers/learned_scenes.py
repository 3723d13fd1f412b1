"""A learned type of random features made ready for search, and keypoints as a camera would see them of it.

Exact, without pixels.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import networkx as nx
import numpy as np
from random_cloud import random_cloud, random_words, unit

from geometry.camera import Camera
from geometry.frames import from_rotation_translation, inverse, transform_points
from kb.clouds.cloud import KnowledgeBase, ObjectType, Rates
from kb.files.read import learned_features, learned_lobes, with_compounds
from kb.learning.again import LOOKS, VARIED
from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.learned.learned_models import learned_index
from sensing.appearance import Appearance

CAMERA = Camera(
    640, 480, np.array([[600.0, 0, 330.0], [0, 580.0, 250.0], [0, 0, 1]]), np.array([0.05, -0.02, 0.001, 0.0, 0.0])
)
"""With a lens that distorts, oblong pixels and its principal point off the middle."""


@dataclass(frozen=True)
class Ready:
    """One learned type and all that search asks for."""

    kb: KnowledgeBase
    kind: ObjectType
    index: object = field(repr=False)

    @property
    def cloud(self):
        """What was learned of it."""
        return self.kind.learned


def ready(cloud=None, surface=None, name="thing", words=None):
    """The only type of a knowledge base."""
    cloud = random_cloud() if cloud is None else cloud
    words = words or random_words(width=cloud.descriptor.shape[1])
    seen = learned_features(cloud, words)
    arrays = {
        "symmetries": np.eye(4)[None],
        "learned": cloud,
        "learned_lobes": learned_lobes(cloud, words),
        "learned_features": seen,
    }
    kind = ObjectType(name, nx.DiGraph(), *with_compounds(seen, cloud, words), surface, opaque=True, **arrays)
    kb = KnowledgeBase("some", (kind,), words.names, Rates({}, {}, {}), 600.0, "", "", words=words)
    return Ready(kb, kind, learned_index(kind, dict.fromkeys(words.names, 0.5)))


def pose_on_axis(rng, cloud, lobe, distance):
    """camera_from_object: the viewpoint on the lobe's axis, the feature anywhere well inside the picture."""
    place = cloud.at[cloud.feature[lobe]]
    viewpoint = place + distance * cloud.axis[lobe]
    forward = unit(-cloud.axis[lobe] + 0.2 * unit(rng.normal(size=3)))
    right = unit(np.cross(forward, rng.normal(size=3)))
    R = np.stack([right, np.cross(forward, right), forward])
    return from_rotation_translation(R, -R @ viewpoint)


def keypoint_of(cloud, lobe, pose, camera=CAMERA, number=0):
    """What a detector reports of an appearance at a pose."""
    at = transform_points(pose, cloud.at[[cloud.feature[lobe]]])[0]
    angle = float(screen_angle(pose[:3, :3] @ cloud.up[lobe], at))
    sided = cloud.sided[lobe]
    scale = None if sided else float(cloud.size[lobe] * camera.f / at[2])
    uv = tuple(camera.project(at[None])[0].tolist())
    descriptor = cloud.descriptor[lobe, LOOKS] if sided else cloud.descriptor[lobe]
    return Appearance(
        f"a{number}", "sift", uv, "made", angle=angle % (2 * np.pi), scale=scale, descriptor=descriptor.tobytes()
    )


def gamma_at(cloud, lobes, pose, camera=CAMERA):
    """The keypoints of these appearances as data, in this order."""
    return data_of(
        [keypoint_of(cloud, lobe, pose, camera, i) for i, lobe in enumerate(lobes)], camera, cloud.descriptor.shape[1]
    )


def one_sided(seed=0, features=24, **changed):
    """A cloud that one viewpoint, along +z, sees all of: a lobe a feature."""
    rng = np.random.default_rng(seed)
    axis = unit(np.array([0.0, 0, 1]) + 0.2 * rng.normal(size=(features, 3)))
    up = unit(np.cross(axis, rng.normal(size=(features, 3))))
    ranges = {"half_angle": np.full(features, 0.9), "r_min": np.full(features, 0.2), "r_max": np.full(features, 3.0)}
    return random_cloud(
        seed,
        features,
        features,
        **({"axis": axis, "up": up, "size": rng.uniform(0.01, 0.03, features)} | ranges | changed),
    )


def with_sides(cloud, features, looks=(90, 140, 95, 135, 150), varied=0):
    """The same, 138 bytes wide, but these features are sides of edges; ``looks`` (5,), or (L, 5) of each lobe."""
    sided = np.isin(cloud.feature, features)
    descriptor = np.where(sided[:, None], 0, cloud.descriptor)
    descriptor[sided, LOOKS] = np.broadcast_to(looks, (len(sided), 5))[sided]
    descriptor[sided, VARIED] = varied
    return replace(cloud, size=np.where(sided, 0.0, cloud.size), descriptor=descriptor.astype(np.uint8))


def pose_before(rng, distance=0.8, tilt=0.2):
    """Random clouds whose data have angles, ready for the search over all types, and exact pictures of them."""
    direction = unit(np.array([0.0, 0, 1]) + tilt * rng.normal(size=3))
    right = unit(np.cross(-direction, rng.normal(size=3)))
    R = np.stack([right, np.cross(-direction, right), -direction])
    return from_rotation_translation(R, -R @ (distance * direction))


def viewpoint(pose):
    return inverse(pose)[:3, 3]
