"""How probable each plane and each stance of a situation is (§9.9), and that a hypothesis is free.

As the queries ``support_plane(S)``, ``stance(H, On, Face), present(On)`` and ``free(H)`` on the program text answer.
"""

import time

from plogic.base.errors import OutsideError
from plogic.facts.situation import Situation, names_of
from plogic.facts.stances import FREE, NONE, Stance, Stood, Support
from plogic.inference.gates import And, Formula, Literal, Not
from plogic.inference.marginals import beliefs
from plogic.logic.safety.atoms import quoted
from plogic.logic.served.engine import Limits, run
from plogic.scene.factors.asked_formulas import Asked
from plogic.scene.factors.goal_meaning import Meaning, standing
from plogic.scene.factors.scene_graph import SceneGraph, scene_graph
from plogic.scene.factors.support_factors import UNSAID
from plogic.scene.readings.standing import Standing
from plogic.scene.text.program_text import program_of


def stood(situation: Situation, seconds: float | None = None) -> Stood | None:
    """Exact, or the middle of what is known by a deadline; None where nobody said that things rest.

    Raises InconsistentError where no world is possible.
    """
    support = situation.support
    if support is None:
        return None
    posed = list(Standing(situation, support).posed)
    try:
        found = _on_graph(situation, support, posed, seconds)
    except OutsideError:
        found = _by_text(situation, support, posed, seconds)
    planes, stances = len(support.planes), len(support.stances)
    return Stood(
        dict(zip((plane.name for plane in support.planes), found, strict=False)),
        tuple(found[planes : planes + stances]),
        dict(zip(posed, found[planes + stances :], strict=True)),
    )


def _on_graph(situation: Situation, support: Support, posed: list[str], seconds: float | None) -> list[float]:
    spoken = Meaning((("support", [[NONE]]), *(("footing", [[name], [FREE], [NONE]]) for name in posed)), (), (), ())
    scene = scene_graph(situation, spoken=[*standing(situation), spoken])
    end = None if seconds is None else time.monotonic() + seconds
    asked = Asked(
        scene.graph, lambda graph: beliefs(graph, seconds=None if end is None else max(end - time.monotonic(), 0.0))
    )
    image = scene.support
    planes = [] if image is None else [_middle(asked, image.literal(plane.name)) for plane in support.planes]
    stances = [_middle(asked, _there(scene, stance)) for stance in support.stances]
    standing_so = dict.fromkeys(posed, 0.0)
    for stance, p in zip(support.stances, stances, strict=True):
        standing_so[stance.hypothesis] += p
    said = {
        name: _middle(asked, And((_present(scene, name), Not(scene.footings[name].literal(*UNSAID))))) for name in posed
    }
    return [*planes, *stances, *(max(0.0, said[name] - standing_so[name]) for name in posed)]


def _middle(asked: Asked, formula: Formula) -> float:
    return sum(asked.probability(formula)) / 2


def _there(scene: SceneGraph, stance: Stance) -> Formula:
    so = scene.footings[stance.hypothesis].literal(stance.on, str(stance.face))
    who = [name for name in (stance.hypothesis, stance.on) if name in scene.place]
    return And((so, *(_present(scene, name) for name in who)))


def _present(scene: SceneGraph, name: str) -> Literal:
    variable, state = scene.place[name]
    return Literal(variable, frozenset({state}))


def _by_text(situation: Situation, support: Support, posed: list[str], seconds: float | None) -> list[float]:
    ids = {h.id for h in situation.hypotheses}
    goals = [f"support_plane({quoted(plane.name)})" for plane in support.planes]
    for s in support.stances:
        there = f", present({quoted(s.on)})" if s.on in ids else ""
        goals.append(f"stance({quoted(s.hypothesis)}, {quoted(s.on)}, {s.face}){there}")
    goals += [f"{FREE}({quoted(name)})" for name in posed]
    limits = Limits() if seconds is None else Limits(seconds=seconds)
    found = run([program_of(situation)], goals, names=names_of(situation), limits=limits)
    return [answer.probability for (answer,) in found]
