"""Families of situations to measure with.

Deterministic by seed, as many hypotheses as asked, numbers as real scenes have them.

Every hypothesis has eight candidate features; there are two appearances a hypothesis. Rates are those of the knowledge
base ``towers``. ``clusters``: what hangs together is small, but conflicts in every way. ``grid``: everything hangs
together, treewidth the shorter side.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations
from math import exp, pi
from random import Random
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import from_rotation_translation
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.facts.situation import AppearanceFact, Situation

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from plogic.facts.situation import Reading

POSE = from_rotation_translation(np.eye(3), [0.0, 0.0, 5.0])
SIGMA, TOLERANCE, CLUTTER = 0.5, 3.0, 8.0 / (640 * 480)
"""Location noise and match tolerance in pixels; clutter per pixel²."""
KINDS = (("apex", 0.95, 0.99), ("corner", 0.8, 0.86), ("patch", 0.95, 0.15))
"""Feature type, hit rate, dv (the towers' composition, §5.6)."""
CANDIDATES = 8
"""Features a hypothesis that are expected where nothing hides them."""
OWN = 0.6
"""Share of a grid's hypotheses that have an appearance of their own."""
PER_HYPOTHESIS = 2
"""Appearances a hypothesis."""


@dataclass
class _Draft:
    """One situation in the making."""

    random: Random
    features: dict[str, list[FeatureFact]] = field(default_factory=dict)
    group: dict[str, str] = field(default_factory=dict)
    overlaps: set[tuple[str, str]] = field(default_factory=set)
    rivals: set[tuple[str, str]] = field(default_factory=set)

    def hypothesis(self, name: str, group: str) -> None:
        """A hypothesis without features as yet."""
        self.features[name], self.group[name] = [], group

    def feature(
        self, h: str, match: str | None, *, good: bool = True, candidate: bool = True, hidden_by: Iterable[str] = ()
    ) -> None:
        """Return the ids of the appearances that nothing accepted causes in the most probable world, in Γ's order."""
        kind, hit, dv = self.random.choices(KINDS, weights=(1, 4, 4))[0]
        residual = None if match is None else self._residual(good=good)
        self.features[h].append(
            FeatureFact(
                id=f"f{len(self.features[h]) + 1}",
                type=kind,
                at=(0.0, 0.0, 5.0),
                uv=(1.0, 1.0),
                dv=dv,
                in_image=True,
                in_lobe=candidate,
                self_hidden=False,
                hidden_by=tuple(hidden_by),
                match=match,
                residual=residual,
                density=0.0 if residual is None else exp(-0.5 * (residual / SIGMA) ** 2) / (2 * pi * SIGMA**2),
                hit_rate=hit,
            )
        )

    def _residual(self, *, good: bool) -> float:
        if not good:
            return round(TOLERANCE * self.random.random() ** 0.5, 3)
        return round(min(TOLERANCE, SIGMA * self.random.weibullvariate(2**0.5, 2.0)), 3)

    def situation(self, reading: Reading, appearances: int) -> Situation:
        """The whole. In the score reading, pairs that exclude each other do so by their shared data too."""
        hypotheses = tuple(
            Hypothesis(
                "t1" if int(name[1:]) % 2 else "t2",
                POSE,
                id=name,
                opaque=True,
                group=self.group[name],
                features=tuple(features),
            )
            for name, features in self.features.items()
        )
        return Situation(
            reading=reading,
            hypotheses=hypotheses,
            appearances=tuple(
                AppearanceFact(f"a{i}", "l_junction", (1.0, 1.0), CLUTTER) for i in range(1, appearances + 1)
            ),
            overlaps=frozenset(self.overlaps),
            rivals=frozenset(self.overlaps | self.rivals),
            exclusive=frozenset(self.overlaps | self.rivals),
            priors={"t1": 0.5, "t2": 0.5},
            dv={kind: dv for kind, _, dv in KINDS},
        )


def _random(seed: str) -> Random:
    return Random(seed)  # noqa: S311 - no secret is made of it


def cluster_sizes(number: int, random: Random) -> list[int]:
    """Sizes from 3 to 6 that sum to ``number`` (at least 3)."""
    sizes: list[int] = []
    left = number
    while left:
        fits = [n for n in range(3, 7) if left - n == 0 or left - n >= 3]
        sizes.append(random.choice(fits))
        left -= sizes[-1]
    return sizes


def clusters(number: int, seed: int, reading: Reading = "posterior") -> Situation:
    """Local clusters of 3 to 6 hypotheses.

    Rivals for one instance, A4, shared appearances, and who stands before hides who stands behind.
    """
    draft = _Draft(_random(f"clusters {number} {seed}"))
    first = 1
    for size in cluster_sizes(number, draft.random):
        members = [f"h{i}" for i in range(first, first + size)]
        data = [f"a{i}" for i in range(PER_HYPOTHESIS * (first - 1) + 1, PER_HYPOTHESIS * (first - 1 + size) + 1)]
        _cluster(draft, members, f"c{first}", data)
        first += size
    return draft.situation(reading, PER_HYPOTHESIS * number)


def _cluster(draft: _Draft, members: Sequence[str], name: str, data: Sequence[str]) -> None:
    """The members from front to back; each instance has one to three rivals, the first of which fits well."""
    random = draft.random
    instances = _instances(members, random)
    for i, instance in enumerate(instances):
        for h in instance:
            draft.hypothesis(h, f"{name}_{i}")
        draft.rivals |= set(combinations(instance, 2))
    of = {h: i for i, instance in enumerate(instances) for h in instance}
    for x, y in combinations(members, 2):
        if of[x] != of[y] and random.random() < 0.3:
            draft.overlaps.add((x, y))
    for place, h in enumerate(members):
        before = [g for g in members[:place] if of[g] != of[h]]
        _features(draft, h, data, before, good=h == instances[of[h]][0])


def _instances(members: Sequence[str], random: Random) -> list[list[str]]:
    """Shared out to instances of one to three rivals each, at least two instances."""
    left = list(members)
    found: list[list[str]] = []
    while left:
        size = random.randint(1, min(3, len(left), len(members) - 1))
        found.append([left.pop(random.randrange(len(left))) for _ in range(size)])
    return found


def _features(draft: _Draft, h: str, data: Sequence[str], before: Sequence[str], *, good: bool) -> None:
    """Eight candidates, of which most of a good one's are detected and half of another's.

    Then two that are not in view.

    The last candidate is missed by all: P(ev) of 1 would be dogmatic, and rivals that are certain leave no world (§8,
    trap c).
    """
    random = draft.random
    share = 0.85 if good else 0.5
    taken = random.sample(list(data), min(len(data), CANDIDATES))
    for i in range(CANDIDATES):
        match = taken.pop() if taken and i < CANDIDATES - 1 and random.random() < share else None
        hidden_by = [g for g in before if random.random() < 0.2]
        draft.feature(h, match, good=good, hidden_by=hidden_by)
    for _ in range(2):
        draft.feature(h, None, candidate=False)


def grid(number: int, columns: int, seed: int, reading: Reading = "posterior") -> Situation:
    """Hypotheses row by row.

    Each shares an appearance with the one to its right, and volume (A4) with the one below it.

    Most have an appearance of their own, too. The treewidth is that of the grid: the shorter side, when it is full.
    Every hypothesis stands for an instance of its own.
    """
    draft = _Draft(_random(f"grid {number} {columns} {seed}"))
    for i in range(1, number + 1):
        draft.hypothesis(f"h{i}", f"i{i}")
        left = i - 1 if i % columns != 1 and columns > 1 else None
        own = [f"a{2 * i - 1}"] if draft.random.random() < OWN else []
        claims = [*own, f"a{2 * i}", *([f"a{2 * left}"] if left else [])]
        for match in [*claims, *[None] * (CANDIDATES - len(claims))]:
            draft.feature(f"h{i}", match)
        if i > columns:
            draft.overlaps.add((f"h{i - columns}", f"h{i}"))
        if left:
            draft.rivals.add((f"h{left}", f"h{i}"))
    return draft.situation(reading, PER_HYPOTHESIS * number)
