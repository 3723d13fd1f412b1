"""Small scenes on which every set of four can be tried.

Four types of 24 oriented features, one or two objects, ten data of clutter.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from benchmarks.clutter.scenes import CAMERA, trial
from benchmarks.clutter.types import Detector, random_types
from geometry.frames import pose_error
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.run.perceive import Perceiver
from sensing.appearance import Gamma

SHARP = Detector("sharp", 0.9, 0.5, float(np.radians(3.0)))
ANGLES, PLACES = True, False
"""Whether the knowledge base says how exact angles are, or places alone count."""
TYPES, FEATURES, LOOKS, CLUTTER = 4, 24, 24, 10


@cache
def world(objects, seed, angles):
    """Knowledge base, Γ and truths.

    Without ``angles`` the knowledge base does not say how exact they are, and nobody asks.
    """
    kb = random_types(TYPES, FEATURES, LOOKS, np.random.default_rng(seed), SHARP, CLUTTER)
    rng = np.random.default_rng([seed, 7])
    data, truths, trials = [], [], []
    for k, which in enumerate(rng.choice(TYPES, objects, replace=False)):
        trials.append(trial(kb.types[which], kb, SHARP, rng, 200))
        data += [replace(a, id=f"o{k}{a.id}") for a in trials[-1].gamma.appearances if a.id in trials[-1].causes]
        truths.append(trials[-1].truth)
    strangers = [a for a in trials[-1].gamma.appearances if a.id not in trials[-1].causes][:CLUTTER]
    rates = kb.rates if angles else replace(kb.rates, sigma_angle=None)
    return replace(kb, rates=rates), Gamma(CAMERA, (*data, *strangers)), truths


@cache
def interpreted(objects, seed, angles, generator):
    """What is accepted of a scene, and what is not."""
    kb, gamma, _ = world(objects, seed, angles)
    delta, rejected, _ = Perceiver(kb, generator=generator).delta(gamma, Options(reading="posterior"), Stopwatch())
    accepted = [belief for belief in delta.beliefs.values() if belief.status == "accepted"]
    return accepted, [*(b for b in delta.beliefs.values() if b.status != "accepted"), *rejected]


def apart(one, other):
    """Degrees, and share of the distance, by which two hypotheses differ; infinite of different types."""
    if one.object_type.name != other.object_type.name:
        return np.inf, np.inf
    pose = other.camera_from_object
    rotation, translation = pose_error(one.camera_from_object, pose, other.object_type.symmetries)
    return np.degrees(rotation), translation / np.linalg.norm(pose[:3, 3])


def claimed(belief):
    """The rows of the data that it claims."""
    return frozenset(belief.matches[belief.detected].tolist())
