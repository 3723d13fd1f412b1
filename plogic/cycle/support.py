"""What stands where: each hypothesis told what its stance is worth, and what may stand on a plane looked for there.

The planes are those that all proposals speak for (``plogic.cycle.planes``), before any is accepted, and again as more
are. On each that is likely every type of which none is accepted is looked for, in far fewer ways than a free body has
poses; what leans, hangs or lies on something else is found as before, by the search that knows of no plane.

* ``leaning(task, state)``: the state with its planes and stances; ``standing(...)``: what is found on them
* ``support_of(accepted, setting)``: the plane that accepted objects stand on, where two or more do
"""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats
from geometry.bodies.resting import Plane
from geometry.bodies.standing import joined
from kb.clouds.cloud import UNKNOWN_SUPPORT
from plogic.cycle.judging import judge, surplus_beside
from plogic.cycle.planes import STANDS, Bodies, Setting, Standing, Supported, abduced, roughly, standing_on, supported
from plogic.cycle.state import Proposal, State, Task
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.judged.type_models import Given

SURE = 50.0
"""Log-odds of what is accepted."""
LIKELY = 0.1
"""Probability from which a plane is searched."""
RESTS = 1.0 - UNKNOWN_SUPPORT
"""P(a thing rests), where a knowledge base does not say."""
FEWEST = 2
"""Accepted objects that must stand on a plane for it to say which way is up: one alone could stand on any face."""


class Support(NamedTuple):
    """``plane``, camera frame; ``by``: places in the list of those that stand on it, increasing."""

    plane: Plane
    by: tuple[int, ...]


def support_of(accepted: Sequence[Hypothesis], setting: Setting) -> Support | None:
    """The plane below the camera on which most of these objects stand; None where no two do, or nothing rests."""
    if setting.kb.rests is None:
        return None
    sure = [posed.told(surplus=SURE, stance=0.0) for posed in accepted]
    return _agreed(*abduced(sure, [], setting, setting.kb.rests), setting.kb.rests)


def plane_under(posed: Sequence[tuple[Standing, Floats]], rests: float = RESTS) -> Support | None:
    """The same of bodies at poses (4, 4)."""
    stands = joined([roughly(k, body, pose) for k, (body, pose) in enumerate(posed)])
    number = len(posed)
    sure, names = np.full(number, SURE), tuple(map(str, range(number)))
    bodies = Bodies(names, np.arange(number), sure, stands, np.zeros(number), np.ones(number))
    return _agreed(bodies, supported(bodies, rests), rests)


def _agreed(bodies: Bodies, found: Supported, rests: float) -> Support | None:
    if not found.planes or found.probability[0] < STANDS:
        return None
    plane = found.planes[0].known.plane
    by = np.flatnonzero(standing_on(bodies, plane, rests) > STANDS)
    return Support(plane, tuple(map(int, by))) if len(by) >= FEWEST else None


def leaning(task: Task, state: State) -> State:
    """The state with its planes, and all that is accepted or proposed told what its stance is worth."""
    rests = task.kb.rests
    proposed = [proposal.hypothesis for proposal in state.proposals]
    if rests is None or not (proposed or state.accepted):
        return state
    _, found = abduced(state.accepted, proposed, task.setting, rests)
    told = [_leans(h, float(worth)) for h, worth in zip((*state.accepted, *proposed), found.worth, strict=True)]
    for models, search in task.searches:
        best: dict[str, float] = {}
        for posed in told:
            if posed.type in models and posed.pixels is not None:
                best[posed.type] = max(posed.pixels + posed.stance, best.get(posed.type, -np.inf))
        search.reckon(best)
    number = len(state.accepted)
    proposals = (Proposal(h, p.beside) for h, p in zip(told[number:], state.proposals, strict=True))
    return replace(state, accepted=tuple(told[:number]), proposals=tuple(proposals), supported=found)


def _leans(posed: Hypothesis, worth: float) -> Hypothesis:
    more = worth - posed.stance
    return posed.told(stance=worth, worth=posed.worth + more, surplus=posed.surplus + more)


def standing(task: Task, state: State, left: Data, given: Given) -> tuple[list[Hypothesis], list[str]]:
    """The hypotheses that the free data and the photo suggest on likely planes; and what is told of each plane."""
    found: list[Hypothesis] = []
    said: list[str] = []
    supports = state.supported
    for plane, probability in zip(supports.planes, supports.probability, strict=False) if supports else ():
        if probability < LIKELY:
            break
        some: list[Hypothesis] = []
        for _, search in task.searches:
            with closing(search.standing(plane.known, left, given)) as searches:
                for rows in searches:
                    some += [posed.told(put=True) for _, posed in rows]
                    task.request.check()
        said.append(
            f"{', '.join(plane.by)} stand on a plane (P {probability:.2f}), {plane.known.plane.offset:.2f} m below the "
            f"camera: {len(some)} poses that stand there are tried"
        )
        found += some
    return found, said


def settled_down(task: Task, state: State) -> State:
    """The state in which each accepted object that stands on the likeliest plane is moved to touch it, about.

    Its pixels and what it stands on speak together there. What would not be accepted there stays as it was.
    """
    if task.kb.rests is None or len(state.accepted) < FEWEST:
        return state
    bodies, found = abduced(state.accepted, [], task.setting, task.kb.rests)
    if not found.planes or found.probability[0] < STANDS:
        return state
    known, some = found.planes[0].known, list(state.accepted)
    stands = standing_on(bodies, known.plane, task.kb.rests) > STANDS
    for one in [one for one, on in zip(state.accepted, stands, strict=True) if on]:
        others, search = [other for other in some if other is not one], task.search_for(one)
        moved = one if search is None else search.stood(one, known, others)
        if moved is one:
            continue
        moved = judge(task, others, moved, 0).told(status=one.status, why=one.why)
        if surplus_beside(moved, others) > task.demanded(moved):
            some = [moved if other is one else other for other in some]
    return replace(state, accepted=tuple(some))
