"""What constancy came to, and how it is written.

Vocabulary, each with an example value:

* ``PhysicalFeature("u1/f1", "patch", at, 0.003, 0.97, {"v1": "a3", "v2": "a9"})``
* ``UnknownObject("u1", 0.98, features)``
* ``Constancy(unknown, noise={"v1": ("a4",)}, undecided={"v1": ("a7",)})``

An unknown object becomes a draft of a new type in Σo, the paper's third outcome (§1). Its frame stands at the centroid
of its features, turned as the world is: z up. Each feature is as it was seen: one appearance, whose lobe holds all
viewpoints from which it was, and a margin. What has not been looked at has no features yet.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, frozen
from kb.clouds.cloud import ObjectType
from kb.clouds.lobes import Branch, Lobe, build_tree, features_of
from kb.surfaces.surface import Surface
from plogic.sequence.constancy.sight_lines import View
from plogic.sequence.document import ConstancyRow


@dataclass(frozen=True, eq=False)
class PhysicalFeature:
    """One place that looks alike from several views.

    Its appearances' ``type``, ``at`` (3,) m, world, and its ``data``, by view.

    ``sigma`` m: the standard deviation in the direction that is known worst; ``probability``: that it is physical.
    """

    id: str
    type: str
    at: Floats
    sigma: float
    probability: float
    data: Mapping[str, str]

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", frozen(self.at))


@dataclass(frozen=True, eq=False)
class UnknownObject:
    """A cluster of physical features that no type of Σo explains.

    ``probability``: that one of them at least is physical.
    """

    id: str
    probability: float
    features: tuple[PhysicalFeature, ...]


@dataclass(frozen=True, eq=False)
class Constancy:
    """What case D was (§4.4). ``noise`` and ``undecided``: the ids of the rest, by view, in the order of Γ."""

    unknown: tuple[UnknownObject, ...]
    noise: Mapping[str, tuple[str, ...]]
    undecided: Mapping[str, tuple[str, ...]]


def constancy_document(constancy: Constancy) -> ConstancyRow:
    """The keys ``unknown``, ``noise`` and ``undecided`` of a ``panorama/1``."""
    return {
        "unknown": [
            {
                "id": one.id,
                "probability": one.probability,
                "features": [
                    {
                        "id": feature.id,
                        "type": feature.type,
                        "at": feature.at.tolist(),
                        "sigma": feature.sigma,
                        "probability": feature.probability,
                        "data": dict(feature.data),
                    }
                    for feature in one.features
                ],
            }
            for one in constancy.unknown
        ],
        "noise": {view: list(ids) for view, ids in constancy.noise.items()},
        "undecided": {view: list(ids) for view, ids in constancy.undecided.items()},
    }


@dataclass(frozen=True, eq=False)
class Sighting:
    """From where a feature was seen.

    ``world_from_camera`` (4, 4), the camera's focal length in pixels, the datum's angle on the screen, rad.
    """

    world_from_camera: Floats
    focal: float
    angle: float | None = None

    @property
    def eye(self) -> Floats:
        """(3,) m, world."""
        return self.world_from_camera[:3, 3]


@dataclass(frozen=True, eq=False)
class SeenFeature:
    """What it looks like, ``at`` (3,) m in the world, and who saw it."""

    type: str
    at: Floats
    sightings: tuple[Sighting, ...]


def seen_features(unknown: UnknownObject, views: Sequence[View]) -> tuple[SeenFeature, ...]:
    """Of an unknown object, with the views that its data are of."""
    by_id = {view.id: view for view in views}
    angles = {view.id: {a.id: a.angle for a in view.gamma.appearances} for view in views}
    return tuple(
        SeenFeature(
            feature.type,
            feature.at,
            tuple(
                Sighting(by_id[view].world_from_camera, by_id[view].gamma.camera.f, angles[view][datum])
                for view, datum in feature.data.items()
            ),
        )
        for feature in unknown.features
    )


MARGIN = math.radians(30.0)
"""By which a lobe is wider than the viewpoints that were there."""
LEAST_HALF_ANGLE, MOST_HALF_ANGLE = math.radians(55.0), math.radians(100.0)
"""Of a draft's lobe: most marks are seen from 55 degrees aside of a viewpoint, few from far behind."""
NEARER, FARTHER = 0.5, 2.0
"""The range of a lobe, as a share of the least and of the greatest distance from which the feature was seen."""


def draft_type(name: str, features: Sequence[SeenFeature], f_ref: float) -> ObjectType:
    """The draft ``name``; ranges hold for the focal length ``f_ref``, pixels.

    Its body is what ``draft_body`` says; without one it is not opaque.
    """
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
    """The lobe in the feature's frame.

    About the mean direction to those who saw it, as wide as all of them and a margin need.
    """
    towards = np.array([sighting.eye - feature.at for sighting in feature.sightings])
    far = np.linalg.norm(towards, axis=1)
    unit = towards / far[:, None]
    axis = unit.sum(axis=0)
    axis /= np.linalg.norm(axis)
    widest = float(np.arccos(np.clip(unit @ axis, -1.0, 1.0)).max())
    scaled = far * f_ref / np.array([sighting.focal for sighting in feature.sightings])
    half = min(max(widest + MARGIN, LEAST_HALF_ANGLE), max(widest, MOST_HALF_ANGLE))
    return Lobe(axis @ world_from_feature, half, NEARER * float(scaled.min()), FARTHER * float(scaled.max()))


SIZES = (1.0, 0.95, 0.9, 0.85, 0.8, 0.7, 0.6, 0.5)
"""Of the hull, about its middle: the largest is taken that hides no feature from a place from which it was seen."""
ASTRAY = 0.05
"""Share of the sightings that it may hide all the same: of features that noise put deep inside."""
FLAT = 0.05
"""Least thickness of features that span a volume, as a share of their length."""
SLACK = 0.004
"""Share of the diameter within which a surface does not hide its own features, as in the engine."""


def draft_body(features: Sequence[SeenFeature], centroid: Floats) -> Surface | None:
    """The body in the draft's frame.

    None where the features span no volume, or no hull of half the size lets all be seen that was.

    A hull is too small where sides were not looked at, and too large where the body is hollow; features are known to
    some millimetres only, so that the hull itself would hide those that seem to lie a little inside.
    """
    at = np.array([feature.at for feature in features]) - centroid
    if len(at) < 4 or _thickness(at) < FLAT:
        return None
    hull = _hull(at)
    middle = hull.vertices.mean(axis=0)
    bodies = (Surface(middle + size * (hull.vertices - middle), hull.triangles) for size in SIZES)
    return next((body for body in bodies if _keeps_to_what_was_seen(body, features, centroid)), None)


def _thickness(at: Floats) -> float:
    """The extent (N, 3) along the thinnest axis, as a share of that along the longest."""
    extents = np.ptp(at @ np.linalg.svd(at - at.mean(axis=0), full_matrices=False)[2].T, axis=0)
    return float(extents.min() / max(extents.max(), 1e-12))


def _hull(at: Floats) -> Surface:
    import trimesh

    hull = trimesh.convex.convex_hull(at)
    return Surface(np.asarray(hull.vertices), np.asarray(hull.faces))


def _keeps_to_what_was_seen(body: Surface, features: Sequence[SeenFeature], centroid: Floats) -> bool:
    slack = SLACK * body.diameter
    hidden = [
        body.rays.blocks(sighting.eye - centroid, (feature.at - centroid)[None], slack)[0]
        for feature in features
        for sighting in feature.sightings
    ]
    return sum(hidden) <= ASTRAY * len(hidden)


ANGLE_SIGMA, ASIDE_SIGMA = 0.1, 0.6
"""rad: what a datum's angle is taken to be known by, and how far the x axis is taken to be from at right angles to the
line of sight. Two views from nearly one side hardly tell how far it leans towards them; marks lie on surfaces that face
whoever sees them."""


def feature_frame(feature: SeenFeature) -> Floats:
    """world_from_feature (3, 3): the x axis is along its data's angles, z nearest to the mean direction to viewpoints.

    The identity where a datum has no angle.
    """
    if any(sighting.angle is None for sighting in feature.sightings):
        return np.eye(3)
    rows = [_arrow(feature.at, sighting) for sighting in feature.sightings]
    sights, arrows = (np.array([row[i] for row in rows]) for i in range(2))
    middle = sights.mean(axis=0)
    middle /= np.linalg.norm(middle)
    normals = np.cross(sights, arrows)
    known = np.einsum("ni,nj->ij", normals, normals) / ANGLE_SIGMA**2 + np.outer(middle, middle) / ASIDE_SIGMA**2
    x = np.linalg.eigh(known)[1][:, 0]
    x = x if float((arrows @ x).sum()) >= 0.0 else -x
    z = -(middle - (middle @ x) * x)
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _arrow(at: Floats, sighting: Sighting) -> tuple[Floats, Floats]:
    """The line of sight (3,) to the feature, and the direction (3,) across it of the datum's angle; unit, world."""
    frame, angle = sighting.world_from_camera[:3, :3], sighting.angle or 0.0
    sight = at - sighting.eye
    sight = sight / np.linalg.norm(sight)
    arrow = frame @ np.array([np.cos(angle), np.sin(angle), 0.0])
    arrow -= (arrow @ sight) * sight
    return sight, arrow / np.linalg.norm(arrow)
