"""The ceiling of ``plogic bench clutter``.

What somebody makes of a trial who is told the type, and whose each datum is.

What he cannot tell, nobody can: the places and angles of so few data at so much noise leave the pose open.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.recognition.score import Found
from plogic.match.judged.expectation import FEWEST
from plogic.match.oriented.oriented_match import Held, Noise, refined

if TYPE_CHECKING:
    from benchmarks.clutter.scenes import Trial
    from kb.clouds.cloud import KnowledgeBase

STEPS = 20
"""Of least squares."""


def told(kb: KnowledgeBase, posed: Trial) -> list[Found]:
    """The true type where least squares on its own data leads from the true pose.

    Nothing where they are fewer than ``FEWEST``.

    Every datum counts by the noise that the KB states, none is taken for an outlier.
    """
    own = [a for a in posed.gamma.appearances if a.id in posed.causes]
    if len(own) < FEWEST or kb.rates.sigma_angle is None:
        return []
    kind = kb.type(posed.truth.type)
    features = [kind.features[posed.causes[a.id]] for a in own]
    points, turns = np.array([f.at for f in features]), np.array([f.rotation[:, 0] for f in features])
    uv, angle = np.array([a.uv for a in own]), np.array([np.nan if a.angle is None else a.angle for a in own])
    held = Held(points[None], turns[None], uv[None], angle[None], np.ones((1, len(own))))
    start, camera = posed.truth.camera_from_object[None], posed.gamma.camera
    return [
        Found(
            kind.name,
            refined(start, held, Noise(kb.rates.sigma, kb.rates.sigma_angle), camera, steps=STEPS, robust=np.inf)[0],
        )
    ]
