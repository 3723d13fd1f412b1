"""Worlds in order where auxiliary variables stand beside those of the worlds: a world weighs the sum over them.

Most auxiliary variables are summed out first; those that a world decides need not be, for they add no joint state to
it. Where one would take too large a table (an appearance that very many claim), joint states with it are ranked
instead: a world weighs at most its heaviest joint state times the number of joint auxiliary states, so a world whose
sum is known may be told as soon as no world that is yet unseen can be heavier.
"""

from __future__ import annotations

import heapq
import math
from typing import TYPE_CHECKING

from plogic.base.clock import Clock, OutOfTimeError
from plogic.base.errors import WidthError
from plogic.inference.gates import Literal, observed
from plogic.inference.marginals import beliefs, summed_out
from plogic.inference.ranked import Ranked

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.inference.graph import FactorGraph
    from plogic.scene.factors.scene_graph import SceneGraph

    Weighed = tuple[float, tuple[int, ...]]


def weighed(scene: SceneGraph, clock: Clock) -> Iterator[Weighed]:
    """(log weight, one state a variable of the scene's alternatives) of every possible world, heaviest first; OutOfTimeError past the clock."""
    graph, left = scene.graph, []
    for v in (v for v in scene.auxiliary if v not in scene.decided):
        clock.check()
        try:
            graph = summed_out(graph, [v])
        except WidthError:
            left.append(v)
    count = len(scene.variables)
    if left:
        yield from _lazily(graph, count, math.log(math.prod(graph.cards[v] for v in left)), clock)
    else:
        yield from ((weight, states[:count]) for weight, states in _ranked(graph, clock))


def _ranked(graph: FactorGraph, clock: Clock) -> Iterator[Weighed]:
    states = Ranked(graph, seconds=None if clock.end is None else clock.left())
    yield from states
    if not states.finished:
        raise OutOfTimeError


def _lazily(graph: FactorGraph, count: int, spread: float, clock: Clock) -> Iterator[Weighed]:
    """``spread``: logarithm of how many joint states one world has."""
    waiting: list[tuple[float, tuple[int, ...]]] = []
    seen: set[tuple[int, ...]] = set()
    for weight, states in _ranked(graph, clock):
        while waiting and -waiting[0][0] >= weight + spread:
            minus, world = heapq.heappop(waiting)
            yield -minus, world
        world = states[:count]
        if world not in seen:
            clock.check()
            seen.add(world)
            heapq.heappush(waiting, (-_sum(graph, world), world))
    yield from ((-minus, world) for minus, world in sorted(waiting))


def _sum(graph: FactorGraph, world: tuple[int, ...]) -> float:
    return beliefs(observed(graph, [Literal(v, frozenset({s})) for v, s in enumerate(world)])).log_z[1]
