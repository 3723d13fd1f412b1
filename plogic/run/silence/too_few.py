"""Types that are seldom found however well they are detected: what they show at once says too little.

Each is put before the camera in directions all around; all that it shows is detected, and it is judged at the right
pose with the KB's own rates, as the search judges it. No search is made.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

import numpy as np

from geometry.arrays import Floats
from geometry.camera import Camera, centred_camera
from geometry.cones import even_directions
from geometry.frames import look_at
from kb.clouds.cloud import KnowledgeBase
from kb.shown.seen_from import usual_distance
from plogic.cycle.judging import judge, refusal
from plogic.cycle.state import State, Task
from plogic.match.gamma.data import data_of
from plogic.match.kinds import Models, models_of
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from plogic.run.simulated_gamma import Posed, simulated_gamma

VIEWS = 24
"""Directions that a type is looked at from."""
ENOUGH = 0.5
"""Share of them from which it should be accepted."""
MOST_TYPES = 40
"""Types that are asked; each takes some tenths of a second."""
SHAPE = 16.0 / 15.0, 0.8
"""Width and height of the picture, focal lengths."""


def seldom_found(kb: KnowledgeBase, but: Collection[str] = ()) -> Iterator[str]:
    """A sentence about each type by hand that is accepted from less than ``ENOUGH`` of the directions, and why.

    ``but``: the names of types of which something worse is known.
    """
    kinds = [kind for kind in kb.types if kind.learned is None and len(kind.lobes.types) and kind.name not in but]
    camera = centred_camera((round(SHAPE[0] * kb.f_ref), round(SHAPE[1] * kb.f_ref)), kb.f_ref)
    dv = distinctiveness(instance_counts(kb.types))
    for kind in kinds[:MOST_TYPES]:
        alone = replace(kb, types=(kind,))
        model = models_of(alone, dv)
        judged = [_judged(alone, model, dv, direction, camera) for direction in even_directions(VIEWS)]
        found = sum(why is None for _, why in judged)
        reasons = [why for _, why in judged if why]
        if found < ENOUGH * VIEWS and reasons:
            shown = sorted(number for number, _ in judged)
            enough = min((number for number, why in judged if why is None), default=None)
            where = "from none" if enough is None else f"where it is accepted it shows {enough} or more"
            yield (
                f"{kind.name}: from {VIEWS - found} of {VIEWS} directions all around it would not be accepted even if "
                f"all that it shows were detected, {shown[VIEWS // 2]} features in the median, {shown[-1]} at most "
                f"({max(reasons, key=reasons.count)}); {where}: give it more features, or looks that are rarer"
            )


def _judged(
    kb: KnowledgeBase, models: Models, dv: Mapping[str, float], direction: Floats, camera: Camera
) -> tuple[int, str | None]:
    """How many features the one type of ``kb`` shows, and why it would be refused; None where it would not be."""
    (kind,) = kb.types
    table = kind.lobes
    away = usual_distance(kind)
    centre = kind.surface.centre if kind.surface is not None else table.at.mean(axis=0)
    up = (0.0, 0.0, 1.0) if abs(direction[2]) < 0.9 else (1.0, 0.0, 0.0)
    pose = look_at(centre + away * direction, centre, up)
    sure = replace(kb.rates, hit=dict.fromkeys(kb.rates.hit, 1.0), clutter=dict.fromkeys(kb.rates.clutter, 0.0))
    reported = simulated_gamma(replace(kb, rates=sure), [Posed(kind.name, pose)], camera, np.random.default_rng(0))
    data = data_of(reported.gamma.in_order().appearances, camera)
    task = Task(data, kb, models, dv)
    found = judge(task, (), task.models[kind.name].settle(pose, data, kb), 0, anew=False)
    return len(reported.gamma.appearances), refusal(task, State(), found)
