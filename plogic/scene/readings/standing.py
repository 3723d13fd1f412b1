"""The choices of what things stand on, with their weights in the two readings (§9.9).

An image has one *state*: a plane by its name, ``NONE`` (nothing says where things stand), or ``OTHER`` (on a plane,
but on none of those named). In every state but ``NONE`` each hypothesis that has a footing has one stance: on the plane
of the state, on another hypothesis, or ``FREE``. Who is present has one, and by chance e who is absent, unless one is
present that excludes it: then what was found is explained. Vocabulary:

* ``Way("s1", "2", 0.3)``: one stance and its weight; ``Way(FREE, NONE, 0.1)``: held, leaning, hung

Posterior: a stance weighs its chance times ρ, being free 1 - rests, more where the pose is level above the plane of the
state, and nothing stands on what is absent. Score: a
stance weighs its chance, being free what is left of 1, and who would stand on what is absent is free. So a hypothesis
weighs, in the posterior, f where it is present and 1 - e + e f where it is absent (1 where one that excludes it is
present), f the sum over its stances.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from math import exp, fsum, inf, log
from typing import NamedTuple

import numpy as np

from plogic.base.bounds import SLACK, bounded
from plogic.base.walk import by_key
from plogic.facts.document import WorldRow
from plogic.facts.situation import Situation
from plogic.facts.stances import FREE, NONE, OTHER, Stance, Support


class Way(NamedTuple):
    """``on``: a plane, a hypothesis, or ``FREE``; ``face`` of its type's stable poses; ``weight`` in one state."""

    on: str
    face: str
    weight: float


def said(on: str, face: str) -> str:
    """``s1/2``: on what, and with which stable pose; ``free``."""
    return FREE if on == FREE else f"{on}/{face}"


@dataclass(frozen=True)
class Told:
    """What things stand on in a world: the image's state, and the stance of each that is present.

    ``Told("s1", {"h1": "s1/2", "h2": "h1/0", "h3": "free"})``.
    """

    state: str
    stances: dict[str, str]


def with_standing(row: WorldRow, told: Told | None) -> WorldRow:
    """The row of a world with what things stand on in it, where they are said to rest."""
    return row if told is None else {**row, "support": told.state, "stances": told.stances}


@dataclass(frozen=True)
class Standing:
    """A situation's choices of support."""

    situation: Situation
    support: Support

    @cached_property
    def states(self) -> dict[str, float]:
        """Each state with its prior share: planes as in the document, ``NONE``, and ``OTHER`` where it is left."""
        shares = {plane.name: bounded(plane.prior) for plane in self.support.planes} | {
            NONE: bounded(self.support.none)
        }
        whole = max(1.0, sum(shares.values()))
        left = 1.0 - sum(shares.values())
        return {name: p / whole for name, p in shares.items()} | ({OTHER: left} if left > SLACK else {})

    @cached_property
    def _stances(self) -> dict[str, list[Stance]]:
        return by_key((stance.hypothesis, stance) for stance in self.support.stances)

    @cached_property
    def _ids(self) -> frozenset[str]:
        return frozenset(h.id for h in self.situation.hypotheses)

    @cached_property
    def by_chance(self) -> dict[str, float]:
        """P(a hypothesis has a footing, given that it is absent), of those of which it is not 0."""
        return {name: bounded(e) for name, e in self.support.by_chance if e > 0.0}

    @cached_property
    def taking(self) -> dict[str, list[str]]:
        """Of each of ``by_chance`` the hypotheses that exclude it: one find, and its pose is one of theirs or none."""
        pairs = sorted(self.situation.overlaps | self.situation.exclusive)
        found = by_key((name, other) for x, y in pairs for name, other in ((x, y), (y, x)))
        return {name: list(dict.fromkeys(found.get(name, ()))) for name in self.by_chance}

    @cached_property
    def level(self) -> dict[tuple[str, str], float]:
        """Of a hypothesis and a plane, ln of how much likelier its pose is where it is free."""
        return {(name, plane): ratio for name, plane, ratio in self.support.level}

    @cached_property
    def posed(self) -> dict[str, None]:
        """The hypotheses whose poses are known, in the order of Δh: nothing is said of how others stand."""
        withheld = self.situation.withheld
        return dict.fromkeys(h.id for h in self.situation.hypotheses if h.id not in withheld)

    def stances(self, name: str, state: str) -> list[Stance]:
        """The stances of a hypothesis that there are in a state, on its plane or on other hypotheses."""
        mine = () if state == NONE else self._stances.get(name, ())
        return [stance for stance in mine if stance.on == state or stance.on in self._ids]

    def holders(self, name: str) -> list[str]:
        """The other hypotheses that it may stand on."""
        return list(dict.fromkeys(stance.on for stance in self.stances(name, OTHER)))

    def planes(self, name: str) -> list[str]:
        """The planes that it may stand on."""
        mine = {stance.on for stance in self._stances.get(name, ())}
        return [plane.name for plane in self.support.planes if plane.name in mine]

    def choice(self, name: str, state: str) -> list[Way]:
        """The alternative of a hypothesis that has a footing in a state; ``FREE`` is last. Nothing in ``NONE``."""
        if state == NONE or name not in self.posed:
            return []
        posterior, stances = self.situation.reading == "posterior", self.stances(name, state)
        chances = [bounded(stance.chance) for stance in stances]
        free = 1.0 - bounded(self.support.rests) if posterior else max(0.0, 1.0 - sum(chances))
        whole = max(1.0, sum(chances) + free)
        ratios = [exp(stance.log_ratio) if posterior else 1.0 for stance in stances]
        rows = zip(stances, chances, ratios, strict=True)
        above = exp(self.level.get((name, state), 0.0)) if posterior else 1.0
        return [*(Way(s.on, str(s.face), p * r / whole) for s, p, r in rows), Way(FREE, NONE, free * above / whole)]

    def ways(self, name: str, state: str, world: Collection[str]) -> list[Way]:
        """The same in a world; nothing that stands on what is absent."""
        found = self.choice(name, state)
        there = [way for way in found if way.on in world or way.on in (state, FREE)]
        if self.situation.reading == "score" and len(there) < len(found):
            there[-1] = there[-1]._replace(weight=there[-1].weight + sum(w.weight for w in found if w not in there))
        return there

    def log_factor(self, name: str, state: str, world: Collection[str], *, taken: bool | None = None) -> float:
        """Ln of what a hypothesis' stances change of the weight of a world in a state (posterior).

        ``taken``: whether one that excludes it is present, where it is not told by the ``world``.
        """
        if taken is None:
            taken = any(other in world for other in self.taking.get(name, ()))
        chance = 1.0 if name in world else 0.0 if taken else self.by_chance.get(name, 0.0)
        if state == NONE or not chance or name not in self.posed:
            return 0.0
        weight = 1.0 - chance + chance * fsum(way.weight for way in self.ways(name, state, world))
        return log(weight) if weight > 0.0 else -inf

    def log_weights(self, world: Collection[str]) -> dict[str, float]:
        """Ln of the weight of each state in a world: its share times the factors (posterior) of the hypotheses."""
        factors = self.posed if self.situation.reading == "posterior" else ()
        return {
            state: (log(share) if share > 0.0 else -inf) + sum(self.log_factor(name, state, world) for name in factors)
            for state, share in self.states.items()
        }

    def log_weight(self, world: Collection[str]) -> float:
        """Ln of what support changes of the weight of a world (posterior)."""
        return float(np.logaddexp.reduce(list(self.log_weights(world).values())))

    def told(self, world: Collection[str], state: str | None = None) -> Told:
        """The most probable state of a world, or this one, and given that the most probable stance of each there."""
        if state is None:
            logs = self.log_weights(world)
            state = max(logs, key=lambda name: logs[name])
        ways = {name: self.ways(name, state, world) for name in world}
        most = {name: max(some, key=lambda way: way.weight) for name, some in ways.items() if some}
        return Told(state, {name: said(way.on, way.face) for name, way in most.items()})
