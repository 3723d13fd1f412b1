"""What stands where: each hypothesis told what its stance is worth, and what may stand on a plane looked for there.

The planes are those that all proposals speak for (``plogic.cycle.planes``), before any is accepted, and again as more
are. On each that is likely every type of which none is accepted is looked for, in far fewer ways than a free body has
poses; what leans, hangs or lies on something else is found as before, by the search that knows of no plane.

* ``leaning(task, state)``: the state with its planes and stances; ``standing(...)``: what is found on them
* ``support_of(accepted, setting)``: the plane that accepted objects stand on, where two or more do
"""

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats
from geometry.bodies.resting import Plane
from geometry.bodies.standing import Known, joined, log_ratios, off, off_by, top_of
from kb.clouds.cloud import UNKNOWN_SUPPORT
from plogic.cycle.choosing import separated
from plogic.cycle.judging import judge, surplus_beside
from plogic.cycle.planes import (
    STANDS,
    Bodies,
    Setting,
    Standing,
    Supported,
    abduced,
    bodies_of,
    roughly,
    standing_on,
    supported,
    with_noise,
)
from plogic.cycle.state import JUDGING, Proposal, Stable, State, Task, of_types
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.judged.type_models import Given

SURE = 50.0
"""Log-odds of what is accepted."""
LIKELY = 0.1
"""Probability from which a plane is searched."""
RESTS = 1.0 - UNKNOWN_SUPPORT
"""P(a thing rests), where a knowledge base does not say."""
LEVEL = 3.0
"""Standard deviations by which what is level may be tilted, and below what it stands on."""
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
    bodies = Bodies(names, np.arange(number), sure, stands, np.zeros(number, bool))
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
    bodies, found = abduced(state.accepted, proposed, task.setting, rests)
    number = len(state.accepted)
    told = [_leans(h, float(worth)) for h, worth in zip((*state.accepted, *proposed), found.worth, strict=True)]
    for models, search in task.searches:
        best: dict[str, float] = {}
        for k, posed in enumerate(told):
            if posed.type in models and posed.pixels is not None:
                instead = k >= number > bodies.kind[k]  # of one that is accepted
                odds = -np.inf if instead else posed.pixels + posed.stance
                best[posed.type] = max(odds, best.get(posed.type, -np.inf))
        search.reckon(best)
    proposals = (Proposal(h, p.beside, p.most) for h, p in zip(told[number:], state.proposals, strict=True))
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
        tops = list(_tops(task, state.accepted, plane.known)) if probability > STANDS else []
        some = _looked_for(task, [plane.known, *(top for _, top in tops)], left, given)
        on_tops = f", or on {', '.join(lower.type for lower, _ in tops)}," if tops else ""
        said.append(
            f"{', '.join(plane.by) or 'some'} stand on a plane (P {probability:.2f}), "
            f"{plane.known.plane.offset:.2f} m below the camera: {len(some)} poses that stand there{on_tops} are tried"
        )
        found += some
    return found, said


def _looked_for(task: Task, supports: Sequence[Known], left: Data, given: Given) -> list[Hypothesis]:
    """What is found on a plane, or on tops."""
    found: list[Hypothesis] = []
    for models, search in task.searches:
        asked = sum(not given.count(name) for name in models)
        task.at(f"on a plane, {of_types(0, asked)}")
        with closing(search.standing(supports, left, given)) as searches:
            for number, rows in enumerate(searches, 1):
                found += [posed for _, posed in rows]
                task.request.check()
                task.at(f"on a plane, {of_types(number, asked)}")
    task.at(JUDGING)
    return found


def _tops(task: Task, some: Sequence[Hypothesis], known: Known) -> Iterator[tuple[Hypothesis, Known]]:
    """What is accepted and stands on a plane, or level above it, and its top."""
    stands = off_by(bodies_of(some, [], task.setting).stands, known.noise)
    tilted, above = off(stands, known.plane)
    squares = (tilted**2).sum(axis=1) / stands.tilt**2
    for body, lower in enumerate(some):
        own = np.flatnonzero((stands.body == body) & (squares < LEVEL**2) & (above > -LEVEL * stands.high))
        if len(own):
            way = own[np.argmin(squares[own])]
            stands_on_it = above[way] < LEVEL * stands.high[way]
            top = top_of(stands, int(way), known, 0.0 if stands_on_it else float(above[way]))
            if top.plane.offset > 0.0:
                yield lower, top


def settled_down(task: Task, state: State) -> State:
    """The state in which each accepted object that stands on the likeliest plane, or on a top, is moved to touch it.

    About: its pixels and what it stands on speak together there, and nothing reaches into another. What would not be
    accepted there stays as it was.
    """
    if task.kb.rests is None or len(state.accepted) < FEWEST:
        return state
    found = abduced(state.accepted, [], task.setting, task.kb.rests)[1]
    if not found.planes or found.probability[0] < STANDS:
        return state
    known, some = found.planes[0].known, list(state.accepted)
    order = np.argsort([float(known.plane.height(one.middle)) for one in some], kind="stable")
    for place, k in enumerate(order):
        lower = [some[j] for j in order[:place]]
        there = _stands_on(task, some[k], [known, *(top for _, top in _tops(task, lower, known))])
        if there is not None:
            some[k] = _set_down(task, some[k], there, [*some[:k], *some[k + 1 :]])
    apart = separated(task, Stable(tuple(some), tuple(some), ()))
    return state if apart.rejected else replace(state, accepted=apart.accepted).tells(*apart.steps)


def _stands_on(task: Task, one: Hypothesis, supports: Sequence[Known]) -> Known | None:
    """On which of these a hypothesis stands, most probably, if on any."""
    rests = task.kb.rests or 0.0
    bodies = with_noise(bodies_of([one], [], task.setting))
    some = [
        known
        for known in supports
        if known.over(one.middle[None])[0] and standing_on(bodies, known.plane, rests)[0] > STANDS
    ]
    return max(some, key=lambda known: float(log_ratios(bodies.stands, known.plane).max()), default=None)


def _set_down(task: Task, one: Hypothesis, known: Known, others: Sequence[Hypothesis]) -> Hypothesis:
    """What stands on a plane moved to touch it, as its pixels allow; as it was where it would not be accepted there."""
    search = task.search_for(one)
    moved = one if search is None else search.stood(one, known, others)
    if moved is one:
        return one
    moved = judge(task, others, moved, 0).told(status=one.status, why=one.why)
    return moved if surplus_beside(moved, others) > task.demanded(moved) else one
