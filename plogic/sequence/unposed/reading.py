"""Read of an ``interpretation/1`` what is known of a hypothesis whose pose is withheld, and of those around it."""

from collections.abc import Mapping, Sequence

import numpy as np

from geometry.arrays import Floats
from geometry.camera import camera_from_dict
from plogic.facts.dependence import Scene
from plogic.facts.document import Interpretation
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.facts.interpretation import situation_of
from plogic.sequence.next_view.expected import Cloud, Prospect
from plogic.sequence.next_view.reading import prospect_of
from plogic.sequence.unposed.drawn import Prior
from plogic.sequence.unposed.standing import Reports, Stander, Target


def target_of(document: Interpretation, name: str, beside: Sequence[str]) -> Target:
    """What is known of ``name`` without its pose, and of those ``beside`` it, which it can be present with."""
    scene = Scene(situation_of(document))
    prospect = prospect_of(document, [(1.0, [name, *beside])])
    bodies = {body.id: body for body in prospect.bodies}
    camera = camera_from_dict(document["camera"])
    own, cloud, row = scene.by_id[name], bodies[name].cloud, {f.id: f for f in scene.by_id[name].features}
    chances = {other: _chances(bodies[other].cloud, prospect, camera.width * camera.height) for other in bodies}
    facing = [row[f] if f in row and _faces(own, row[f]) else None for f in cloud.features]
    shown = [f for f in facing if f is not None]
    standers = tuple(
        Stander(bodies[other], *_known(scene, scene.by_id[other], {*beside} - {other}, chances[other])) for other in beside
    )
    others = tuple(one.body for one in standers)
    aspect = np.array([f is not None for f in facing], bool)
    prior = Prior(cloud, aspect, others, camera, prospect.f_ref)
    inside = np.array([f.in_image for f in shown], bool)
    return Target(prior, own.opaque, inside, _reports([f for f in shown if f.in_image], chances[name]), standers)


def _faces(h: Hypothesis, f: FeatureFact) -> bool:
    return f.in_lobe and not (f.self_hidden and h.opaque)


def _known(
    scene: Scene, h: Hypothesis, beside: set[str], chances: Mapping[str, float]
) -> tuple[Floats, Reports]:
    """The features of a posed hypothesis that are expected beside these others, and what was reported of them."""
    some = [f for f in h.features if f.stands_for == 1 and h.expects(f) and not beside & set(scene.hiders(h, f))]
    return np.array([f.at for f in some]).reshape(-1, 3), _reports(some, chances)


def _reports(some, chances: Mapping[str, float]) -> Reports:
    return Reports(
        np.array([f.match is not None for f in some], bool),
        np.array([f.hit_rate for f in some]),
        np.array([chances.get(f.id, 0.0) for f in some]),
    )


def _chances(cloud: Cloud, prospect: Prospect, area: float) -> dict[str, float]:
    """By feature: the probability that clutter of one of its looks is within the tolerance of its place."""
    looks = {(f, name) for f, name in zip(cloud.lobes.feature.tolist(), cloud.lobes.types, strict=True)}
    expected = np.zeros(cloud.lobes.features)
    for f, name in looks:
        expected[f] += prospect.clutter.get(name, 1.0) / area * np.pi * prospect.tolerance**2
    return dict(zip(cloud.features, (-np.expm1(-expected)).tolist(), strict=True))
