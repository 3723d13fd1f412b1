"""Three measures of the same hypotheses on the same scene: ev, Shanahan's explanatory value, and the posterior."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from synthetic import belief_at, cycle_of, data, perceiver, scene, towers

from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from plogic.cycle.delta import Options, delta_of
from plogic.measures.explanatory import explanatory_value, shanahan_values
from plogic.scene.worlds.ranked_worlds import ranked_worlds

NOISE = 0.02
"""Prior of "this appearance is noise", an abducible of Shanahan's measure."""


@dataclass(frozen=True)
class Row:
    """One hypothesis with its three numbers: ``Row("t1 right", 0.97, 0.999, 0.998)``."""

    name: str
    ev: float
    shanahan: float
    posterior: float


def turned(pose, degrees, step=(0.0, 0.0, 0.0)):
    """The pose of an object that is turned about its own vertical and moved along its own axes, metres."""
    half = np.radians(degrees) / 2
    return pose @ from_rotation_translation(
        rotation_from_quat_xyzw([0, 0, np.sin(half), np.cos(half)]), np.array(step, float)
    )


def abducibles(posed, of):
    """Priors of what the explanation "it stands there" takes on.

    The object, each hit, each miss, and noise for what it leaves over.
    """
    kb = towers()
    hit = np.array([kb.rates.hit[f.type] for f in posed.object_type.features])
    found, missed = posed.candidate & posed.detected, posed.candidate & ~posed.detected
    left = len(of.ids) - len(set(posed.matches[found].tolist()))
    return [kb.rates.prior[posed.object_type.name], *hit[found], *(1.0 - hit[missed]), *[NOISE] * left]


def beliefs_of(poses, of):
    """``{"t1 right": ("t1", pose)}`` → a belief each."""
    return {label: belief_at(name, pose, of) for label, (name, pose) in poses.items()}


def situation_with(beliefs, of, shot, reading="posterior"):
    """The facts of a Δh that holds just these, none of them rejected."""
    cycle = replace(cycle_of(scene(np.random.default_rng(0), {}, clutter=0).gamma), accepted=tuple(beliefs))
    return delta_of(cycle, of, towers(), perceiver().dv, Options(reading=reading)).situation


def rows_of(poses, shot):
    """The three numbers of each of several rival hypotheses about one scene."""
    of = data(shot)
    beliefs = beliefs_of(poses, of)
    shanahan = shanahan_values({label: abducibles(b, of) for label, b in beliefs.items()})
    marginals = ranked_worlds(situation_with(beliefs.values(), of, shot)).marginals
    return [
        Row(label, explanatory_value(b.support(), perceiver().dv), shanahan[label], p)
        for (label, b), p in zip(beliefs.items(), marginals.values(), strict=True)
    ]
