"""Two towers, found in a simulated Γ, that stand on a plane or on each other, and their document."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
from synthetic import cycle_of, data, one_before_the_other, perceiver, scene, towers

from plogic.cycle.delta import Options, delta_of
from plogic.facts.interpretation import text_of
from plogic.facts.stances import Stance, Support, SupportPlane
from plogic.run.document import document_of
from plogic.scene.worlds.ranked_worlds import ranked_worlds

TIGHT = ((4e-4, 0.0, 0.0), (0.0, 4e-4, 0.0), (0.0, 0.0, 1e-4))
SUPPORT = Support(
    0.9,
    0.05,
    (
        SupportPlane("s1", (0.0, -0.8, -0.6), -1.25, TIGHT, 0.6),
        SupportPlane("s2", (0.0, -1.0, 0.0), -2.0, TIGHT, 0.2),
    ),
    (
        Stance("h1", "s1", 0, 0.9, 4.5),
        Stance("h2", "s1", 0, 0.25, 3.25),
        Stance("h2", "s1", 3, 0.2, -7.0),
        Stance("h2", "h1", 0, 0.45, -30.0),
    ),
    (("h2", 0.12),),
)


def standing_towers(reading):
    """The situation of two towers that stand somewhere, its worlds, and the document."""
    rng = np.random.default_rng(7400)
    shot = scene(rng, one_before_the_other(rng))
    cycle = cycle_of(shot.gamma)
    delta = delta_of(cycle, data(shot), towers(), perceiver().dv, Options(reading=reading))
    delta = replace(delta, situation=replace(delta.situation, support=SUPPORT))
    ranking = ranked_worlds(delta.situation, 100)
    document = document_of(towers(), shot.gamma, delta, cycle.rejected, cycle.trace.document(), ranking, None)
    return delta.situation, ranking, json.loads(text_of(document))
