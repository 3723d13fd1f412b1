"""Random clouds whose data have angles, ready for the search over all types at once, and exact pictures of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

from benchmarks.clutter.scenes import trial
from benchmarks.clutter.types import Detector, knowledge_base, made, random_types, type_names
from benchmarks.recognition.score import Found, errors_of
from geometry.camera import Camera
from geometry.frames import from_rotation_translation, transform_points
from kb.clouds.lobes import Feature, FeatureAppearance, Lobe
from plogic.match.gamma.data import data_of
from plogic.match.hand.view_cells import DISTANCE
from plogic.match.judged.evidence import nothing_hidden
from plogic.match.kinds import models_of
from plogic.match.oriented.asked import Asked, chances_of
from plogic.match.oriented.oriented_match import Noise
from plogic.match.oriented.oriented_models import generate_together, search_of
from plogic.match.oriented.oriented_search import Search
from plogic.match.oriented.pair_index import pair_index
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from sensing.appearance import Appearance

EASY = Detector("easy", 0.6, 1.0, float(np.radians(5.0)))
HARD = Detector("hard", 0.35, 2.0, float(np.radians(12.0)))
STRAIGHT = Camera(640, 480, np.array([[600.0, 0.0, 319.5], [0.0, 600.0, 239.5], [0.0, 0.0, 1.0]]))
"""Whose ideal pixels are its pixels."""


@dataclass(frozen=True, eq=False)
class Ready:
    """A knowledge base and all that the search over its types asks for."""

    kb: object

    @cached_property
    def indices(self):
        """Of each type by name, in the order of the types."""
        return models_of(self.kb, distinctiveness(instance_counts(self.kb.types)))

    @cached_property
    def rows(self):
        """The same by number."""
        return list(self.indices.values())

    @cached_property
    def shared(self):
        """The index over all types."""
        return pair_index(self.rows)

    @property
    def noise(self):
        """As the cycle takes it."""
        return Noise(self.kb.rates.sigma, self.kb.rates.sigma_angle)

    def asked(self, data, index=None):
        """As the cycle asks; ``index``: another than its own."""
        index = index or self.shared
        return Asked(index, data, self.noise, chances_of(index, self.kb.rates))

    def proposals(self, data):
        """The best poses of all types."""
        return Search(self.asked(data)).proposals(data)

    def together(self, data, hidden_of=nothing_hidden):
        """By type the hypotheses of all types, as the cycle asks for them.

        {} where they are not searched for together.
        """
        search = search_of(self.shared, data, self.kb)
        return {} if search is None else generate_together(search, data, self.kb, hidden_of)


def told_angles(kb, detector):
    """The same knowledge base, which says how far angles may be off."""
    return replace(kb, rates=replace(kb.rates, sigma_angle=detector.turn))


@cache
def clouds(count=5, features=100, looks=30, seed=1, detector=EASY, appearances=200):
    """Random types on convex bodies."""
    kb = random_types(count, features, looks, np.random.default_rng(seed), detector, appearances)
    return Ready(told_angles(kb, detector))


def kb_of(*types, detector=EASY, looks=30):
    """The knowledge base of some types, which says how far angles may be off."""
    return Ready(told_angles(knowledge_base(types, type_names(looks), detector, 200), detector))


@cache
def flat_cap(seed=0, features=24, relief=0.7):
    """A type without a surface whose features lie nearly in the plane z = 0: places leave its tilt open.

    They face up to ``relief`` radians away from +z, and so their x axes lead out of the plane.
    """
    rng = np.random.default_rng(seed)
    at = np.column_stack([rng.uniform(-0.1, 0.1, (features, 2)), rng.normal(0.0, 5e-4, features)])
    around, aside, turn = (
        rng.uniform(0.0, 2.0 * np.pi, features),
        rng.uniform(0.0, relief, features),
        rng.uniform(0.0, 2.0 * np.pi, features),
    )
    frames = np.array([about_z(a) @ about_x(b) @ about_z(c) for a, b, c in zip(around, aside, turn, strict=True)])
    looks = [type_names(30)[i] for i in rng.permutation(30)[:features]]
    return kb_of(made("cap", None, at, frames, looks, np.full(features, np.radians(80.0))))


def about_z(angle):
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def about_x(angle):
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]])


def with_other_look(kind, name):
    """The type whose every feature looks like ``name`` from behind as well: two lobes a feature, of opposite axes."""
    axis, angle = np.array([0.0, 0.0, 1.0]), float(np.radians(65.0))

    def both(feature):
        mine = FeatureAppearance(feature.type, Lobe(axis, angle, 0.05, 20.0))
        return Feature(
            feature.name,
            feature.type,
            feature.at,
            feature.rotation,
            (mine, FeatureAppearance(name, Lobe(-axis, angle, 0.05, 20.0))),
        )

    features = tuple(both(feature) for feature in kind.features)
    return replace(kind, features=features, all_features=features)


def seen_from(index, cell, roll=0.0):
    """camera_from_object (4, 4) of a camera at a cell's viewpoint, looking at the middle, rolled clockwise, radians."""
    R = about_z(roll) @ index.cells.cell_from_object[cell]
    viewpoint = index.cells.centre + DISTANCE * index.cells.diameter * index.cells.directions[cell]
    return from_rotation_translation(R, -R @ viewpoint)


def picture_of(index, pose, features, camera=STRAIGHT):
    """Exact data of some features at a pose.

    An angle is where a point a little way along the x axis of the feature's frame is seen.
    """
    chosen = [index.object_type.features[f] for f in features]
    at = transform_points(pose, np.array([feature.at for feature in chosen]).reshape(-1, 3))
    beside = transform_points(
        pose, np.array([feature.at + 1e-6 * feature.rotation[:, 0] for feature in chosen]).reshape(-1, 3)
    )
    uv = camera.project(at)
    step = camera.project(beside) - uv
    angle = np.arctan2(step[:, 1], step[:, 0]) % (2.0 * np.pi)
    looks = [feature.appearances[0].type for feature in chosen]
    return [datum(i, name, place, turn) for i, (name, place, turn) in enumerate(zip(looks, uv, angle, strict=True))]


def datum(number, name, uv, angle=None):
    """One appearance."""
    return Appearance(
        f"d{number}", name, (float(uv[0]), float(uv[1])), "made", angle=None if angle is None else float(angle)
    )


def a_trial(ready, seed, detector=EASY, appearances=200):
    """Number of the type that is there, the trial, and its data."""
    which = seed % len(ready.kb.types)
    case = trial(ready.kb.types[which], ready.kb, detector, np.random.default_rng(seed), appearances)
    return which, case, data_of(case.gamma.appearances, case.gamma.camera)


def off(ready, found, case):
    """How far a proposal is from the truth: radians, and share of the distance; both infinite of a wrong type."""
    name = ready.rows[found.kind].object_type.name
    return errors_of(Found(name, found.pose), case.truth) if name == case.truth.type else (np.inf, np.inf)
