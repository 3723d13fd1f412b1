"""Ranked possible worlds, exact, without ProbLog: tested equal to the program text (§8).

Vocabulary:

* ``World``, one assignment of present/1, ``World(0.961, ("h1", "h2"), {"a1": "h1/roof/apex", "a9": "noise"}, (0.961,
  0.961))``
* ``Ranking``, the most probable worlds with everything that a caller would otherwise normalise again

Where the graph has auxiliary variables, a world weighs the sum over them (``weighed``). Most are summed out first;
those that a world decides need not be, for they add no joint state to it. Where one would take too large a table (an
appearance that very many claim), joint states with it are ranked instead: a world weighs at most its heaviest joint
state times the number of joint auxiliary states, so a world whose sum is known may be told as soon as no world that is
yet unseen can be heavier.

What things stand on in one world is the most probable plane, and the most probable stance of each, given that (§9.9).
"""

import contextlib
import heapq
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plogic.base.clock import Clock, OutOfTimeError
from plogic.base.errors import InconsistentError, LimitError, OutsideError, WidthError
from plogic.facts.dependence import Scene
from plogic.facts.sanity import check
from plogic.facts.situation import Situation, names_of
from plogic.inference.gates import Literal, observed
from plogic.inference.graph import Beliefs, FactorGraph, connected
from plogic.inference.marginals import beliefs, summed_out
from plogic.inference.ranked import Ranked, best
from plogic.logic.safety.atoms import quoted
from plogic.logic.served.engine import Limits, run
from plogic.logic.served.program_worlds import program_worlds
from plogic.scene.factors.scene_graph import SceneGraph, scene_graph
from plogic.scene.factors.weight_tables import Choice, cast_of
from plogic.scene.readings.standing import Standing, Told, said
from plogic.scene.readings.world_weights import log_scale
from plogic.scene.text.program_text import program_of
from plogic.scene.worlds.blame import blaming
from plogic.scene.worlds.causes import CauseTable

Weighed = tuple[float, tuple[int, ...]]
Interval = tuple[float, float]
Listed = list[tuple[float, tuple[str, ...]]]


def weighed(scene: SceneGraph, clock: Clock) -> Iterator[Weighed]:
    """(log weight, one state a variable of the scene's alternatives) of every possible world, heaviest first.

    OutOfTimeError past the clock.
    """
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
            held = observed(graph, [Literal(v, frozenset({s})) for v, s in enumerate(world)])
            heapq.heappush(waiting, (-beliefs(held).log_z[1], world))
    yield from ((-minus, world) for minus, world in sorted(waiting))


TIE = 1e-9
"""Log weights as near as this may be ties: they are all looked at before the list is cut."""
FIRST = 0.25
"""Seconds that the search for the most probable world may take, however near the deadline is."""
MOST_TIES = 1000
"""Worlds beyond the wanted ones that are looked at for that; of more ties than these, the first in the order of states
are listed."""


@dataclass(frozen=True)
class World:
    """One possible world; ``present`` in the order of Δh, ``causes`` for every appearance of Γ.

    ``interval`` bounds the probability. ``told``: what things stand on; None where nobody said that they rest.
    """

    probability: float
    present: tuple[str, ...]
    causes: dict[str, str]
    interval: Interval
    told: Told | None = None


@dataclass(frozen=True)
class Ranking:
    """The ``worlds``, most probable first, ties by ids; the interval of the mass ``unlisted``.

    ``marginals`` P(present(H)).

    ``log_evidence`` is ln P(constraints) in the score reading, and ln of the density of Γ's claimed part, of what is
    missing in it and of the constraints in the posterior reading. ``intervals`` and ``log_evidence_interval`` bound
    them: both ends are the same but where a deadline was reached; then ``marginals`` and ``log_evidence`` are the
    middles. ``complete``: whether the deadline cut no world off the list.
    """

    worlds: tuple[World, ...]
    unlisted: Interval
    log_evidence: float
    marginals: dict[str, float]
    intervals: dict[str, Interval]
    log_evidence_interval: Interval
    complete: bool = True

    @property
    def exact(self) -> bool:
        """Whether the list is complete and every number exact."""
        bounds = [self.log_evidence_interval, *self.intervals.values()]
        return self.complete and all(low == high for low, high in bounds)


def ranked_worlds(situation: Situation, n: int = 10, *, seconds: float | None = None) -> Ranking:
    """The ``n`` most probable worlds.

    With ``seconds``, what can be said by then, in intervals that contain the exact values.

    Raises InconsistentError where none is possible, WidthError (without ``seconds``) where exact inference would need
    too large a table; where rules of the author's say what only the program text can, also as
    ``plogic.logic.served.engine.run``.
    """
    check(situation)
    with blaming(situation):
        try:
            return _on_graph(situation, n, seconds)
        except OutsideError:
            return _by_text(situation, n, seconds)


def _on_graph(situation: Situation, n: int, seconds: float | None) -> Ranking:
    end = None if seconds is None else time.monotonic() + seconds
    scene = scene_graph(situation)
    belief = beliefs(scene.graph, seconds=None if seconds is None else seconds / 2)
    if belief.log_z[1] == -math.inf:
        raise InconsistentError(_reason(scene))
    ranking = ranking_of(situation, scene, belief, listed_worlds(situation, scene, n, end))
    return with_joint_causes(ranking, situation, scene) if scene.spoken else ranking


def _by_text(situation: Situation, n: int, seconds: float | None) -> Ranking:
    """By the program text, all of it by ``seconds``; else LimitError."""
    limits = Limits() if seconds is None else Limits(seconds=max(seconds, FIRST))
    text, names, ids = program_of(situation), names_of(situation), [h.id for h in situation.hypotheses]
    goals = {f"present({quoted(name)})": name for name in ids}
    found = program_worlds(text, n, goals=list(goals), limits=limits, names=names)
    chances = run([text], list(goals), names=names, limits=limits)
    present = [tuple(sorted((goals[goal] for goal in w.holds), key=ids.index)) for w in found.worlds]
    worlds = _told(situation, list(zip([(w.probability, w.probability) for w in found.worlds], present, strict=True)))
    marginals = {name: answer.probability for name, (answer,) in zip(ids, chances, strict=True)}
    log_evidence = (found.log_evidence or 0.0) + log_scale(Scene(situation))
    intervals = {name: (p, p) for name, p in marginals.items()}
    return Ranking(worlds, found.unlisted, log_evidence, marginals, intervals, (log_evidence, log_evidence))


def ranking_of(situation: Situation, scene: SceneGraph, belief: Beliefs, found: tuple[Listed, bool]) -> Ranking:
    """The ranking from what inference found.

    Log weights and what is present, in any order, and whether that list is complete.
    """
    listed, complete = found
    known = float(np.logaddexp.reduce([weight for weight, _ in listed])) if listed else -math.inf
    low, high = min(max(belief.log_z[0], known), belief.log_z[1]), belief.log_z[1]
    log_z = low, high
    chances = [(min(math.exp(weight - high), 1.0), min(math.exp(weight - low), 1.0)) for weight, _ in listed]
    worlds = _told(situation, [(chance, present) for chance, (_, present) in zip(chances, listed, strict=True)])
    intervals = {h.id: _interval(belief, *scene.place[h.id]) for h in situation.hypotheses}
    return Ranking(
        worlds,
        _unlisted(worlds),
        _middle(log_z),
        {h: _middle(i) for h, i in intervals.items()},
        intervals,
        log_z,
        complete,
    )


def _told(situation: Situation, worlds: Sequence[tuple[Interval, tuple[str, ...]]]) -> tuple[World, ...]:
    """Worlds, given as probability and who is present, with their causes and what things stand on there."""
    causes = CauseTable(cast_of(situation)).causes([present for _, present in worlds])
    standing = None if situation.support is None else Standing(situation, situation.support)
    told = [None if standing is None else standing.told(present) for _, present in worlds]
    rows = zip(worlds, causes, told, strict=True)
    return tuple(World(_middle(p), present, c, p, stands) for (p, present), c, stands in rows)


def with_joint_causes(ranking: Ranking, situation: Situation, scene: SceneGraph) -> Ranking:
    """The ranking with the most probable joint causes in each world, given the evidence, and what things stand on then.

    Of the appearances whose causes are variables, since evidence speaks of them, and of the stances that it speaks of.
    """
    return replace(ranking, worlds=tuple(_beside_evidence(world, situation, scene) for world in ranking.worlds))


def _beside_evidence(world: World, situation: Situation, scene: SceneGraph) -> World:
    states = dict.fromkeys(range(len(scene.variables)), 0) | dict(scene.place[name] for name in world.present)
    held = observed(scene.graph, [Literal(v, frozenset({s})) for v, s in states.items()])
    (_, found), *_ = best(held, 1)
    causes = {name: "/".join(cause.states[found[cause.variable]]) for name, cause in scene.causes.items()}
    return replace(world, causes={**world.causes, **causes}, told=_stood(world, situation, scene, held))


def _stood(world: World, situation: Situation, scene: SceneGraph, held: FactorGraph) -> Told | None:
    """What things stand on in a world where evidence speaks of it: the plane, and then each one's stance."""
    if situation.support is None or scene.support is None:
        return world.told
    (state,) = _likeliest(scene.support, beliefs(held))
    given_state = beliefs(observed(held, [scene.support.literal(state)]))
    told = Standing(situation, situation.support).told(world.present, state)
    spoken = {
        name: said(*_likeliest(choice, given_state)) for name, choice in scene.footings.items() if name in told.stances
    }
    return replace(told, stances={**told.stances, **spoken})


def _likeliest(choice: Choice, belief: Beliefs) -> tuple[str, ...]:
    return choice.states[int(np.argmax(belief.low[choice.variable]))]


def listed_worlds(situation: Situation, scene: SceneGraph, n: int, end: float | None = None) -> tuple[Listed, bool]:
    """The ``n`` heaviest worlds; weights that agree to twelve digits are ties, and go by ids.

    By ``end`` (a moment of ``time.monotonic``) those that were found till then, and whether none is missing.
    """
    ids = [h.id for h in situation.hypotheses]
    number = {name: i for i, name in enumerate(ids)}
    numbers = [(-1, *[number[str(name)] for name in v.states[1:]]) for v in scene.variables]
    found: Listed = []
    complete = end is None
    with contextlib.suppress(*(() if end is None else (LimitError, OutOfTimeError))):
        for weight, states in weighed(scene, Clock(None if end is None else max(end - time.monotonic(), FIRST))):
            if end is not None and found and time.monotonic() > end:
                raise OutOfTimeError
            if len(found) >= n and (not n or weight < found[n - 1][0] - TIE or len(found) >= n + MOST_TIES):
                break
            members = sorted([mine[s] for mine, s in zip(numbers, states, strict=True) if s])
            found.append((weight, tuple([ids[i] for i in members])))
        complete = True
    top = found[0][0] if found else 0.0
    listed = sorted(found, key=lambda world: (-float(f"{math.exp(world[0] - top):.11e}"), world[1]))[:n]
    return listed, complete or len(listed) == n


def _unlisted(worlds: tuple[World, ...]) -> Interval:
    low, high = (1.0 - math.fsum(w.interval[end] for w in worlds) for end in (1, 0))
    return (0.0 if low < 1e-12 else low, 0.0 if high < 1e-12 else high)


def _interval(belief: Beliefs, v: int, s: int) -> Interval:
    return min(max(float(belief.low[v][s]), 0.0), 1.0), min(max(float(belief.high[v][s]), 0.0), 1.0)


def _middle(interval: Interval) -> float:
    low, high = interval
    return low if low == high else (low + high) / 2


def _reason(scene: SceneGraph) -> str:
    """Which hypotheses cannot be reconciled: those of the first piece of the graph without a possible joint state."""
    for piece in connected(scene.graph):
        factors = tuple(f for f in scene.graph.factors if f.scope and f.scope[0] in piece)
        if beliefs(FactorGraph(scene.graph.cards, factors)).log_z[1] == -math.inf:
            names = [name for name, (v, _) in scene.place.items() if v in piece]
            return (
                f"no world satisfies the constraints on {', '.join(names)}: "
                "each excludes what another holds for certain (smoothing would help)"
            )
    return "no world satisfies the constraints"
