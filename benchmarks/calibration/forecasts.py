"""What perception says of the hypotheses of a scene, by each reading, and which of them are true.

* ``Forecast``: one hypothesis, ``Forecast(scene=17, among="gate", true=True, said={"posterior": 0.97, "P(ev)": 0.81,
  ...})``

Hypotheses are looked at twice. ``gate``: every pose that the search came to and that passed the geometric gate (laid
onto Γ, refined, rays cast, four expected features or more detected), near-duplicates merged, none accepted or rejected
by what it explains. ``cycle``: Δh of the perceptual cycle, what it accepted and its rivals.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.calibration.truth import true_ones
from plogic.base.clock import Stopwatch
from plogic.base.errors import InconsistentError
from plogic.cycle.delta import Delta, Options, delta_of
from plogic.cycle.state import Cycle, Trace
from plogic.match.gamma.data import data_of
from plogic.match.judged.evidence import as_counted, judged
from plogic.match.judged.type_models import Given, Request
from plogic.measures.explanatory import probability_of_ev
from plogic.run.perceive import SMOOTHED
from plogic.scene.worlds.ranked_worlds import ranked_worlds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from benchmarks.calibration.scenes import CalibrationScene
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.facts.situation import Situation
    from plogic.match.gamma.data import Data
    from plogic.run.perceive import Perceiver

POSTERIOR, BEST, SCORE, P_EV = "posterior", "posterior, its pose as given", "score, P(present)", "P(ev)"
READINGS = POSTERIOR, BEST, SCORE, P_EV
"""The posterior; what it would be if a pose owed nothing to having been fitted; P(present) of the paper's reading;
P(ev) itself."""
GATE, CYCLE = "gate", "cycle"


@dataclass(frozen=True)
class Forecast:
    """``among``: ``GATE`` or ``CYCLE``; ``said``: its probability by each of ``READINGS``."""

    scene: int
    among: str
    true: bool
    said: Mapping[str, float]


def forecasts_of(perceiver: Perceiver, scene: CalibrationScene, number: int) -> list[Forecast]:
    """Those of one scene, in both looks at it."""
    gamma = scene.gamma
    data = data_of(gamma.appearances, gamma.camera)
    perceived = perceiver.delta(gamma, Options(reading="posterior"), Stopwatch())[0]
    looks = ((GATE, gated(perceiver, data)), (CYCLE, perceived))
    return [
        forecast for among, delta in looks for forecast in _judged(delta, data, perceiver.kb, scene, (number, among))
    ]


def gated(perceiver: Perceiver, data: Data) -> Delta:
    """Δh of all types before anything is accepted or rejected."""
    nothing = Given((), lambda posed: np.zeros(len(posed.uv), bool), lambda _: None, lambda _: None)
    beliefs: list[Hypothesis] = []
    for kind in perceiver.models.kinds.values():
        proposed = kind.search(Request(data, perceiver.kb)).propose(list(kind.models), data, nothing)
        for _, posed in chain.from_iterable(proposed):
            beliefs.append(judged(posed, data, perceiver.kb, perceiver.dv))
    best = sorted(beliefs, key=lambda b: -b.worth)
    return delta_of(
        Cycle((), tuple(best), (), (), Trace()), data, perceiver.kb, perceiver.dv, Options(reading="posterior")
    )


def _judged(
    delta: Delta, data: Data, kb: KnowledgeBase, scene: CalibrationScene, which: tuple[int, str]
) -> list[Forecast]:
    if not delta.beliefs:
        return []
    poses = {name: (b.object_type, b.camera_from_object) for name, b in delta.beliefs.items()}
    true = true_ones(poses, scene.truth.objects)
    said = {
        POSTERIOR: presences(delta.situation),
        BEST: presences(_as_given(delta, data, kb)),
        SCORE: presences(replace(delta.situation, reading="score")),
        P_EV: {name: 0.0 if b.ev is None else probability_of_ev(b.ev) for name, b in delta.beliefs.items()},
    }
    return [
        Forecast(*which, name in true, {reading: table[name] for reading, table in said.items()})
        for name in delta.beliefs
    ]


def presences(situation: Situation) -> dict[str, float]:
    """P(present(h)) of every hypothesis; smoothed, as perception does, where dogmatic P(ev) leave no world."""
    try:
        return ranked_worlds(situation, 1).marginals
    except InconsistentError:
        return ranked_worlds(replace(situation, smoothing=SMOOTHED), 1).marginals


def _as_given(delta: Delta, data: Data, kb: KnowledgeBase) -> Situation:
    """The situation whose densities are those at the poses, as if these had been known before: for comparison."""
    hypotheses = []
    for h in delta.situation.hypotheses:
        posed = delta.beliefs[h.id]
        at = {feature.name: f for f, feature in enumerate(posed.object_type.features)}
        near = as_counted(posed, data, kb)[1]
        hypotheses.append(replace(h, features=tuple(replace(f, density=float(near[at[f.id]])) for f in h.features)))
    return replace(delta.situation, hypotheses=tuple(hypotheses))
