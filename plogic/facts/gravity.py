"""Support (Σc): where gravity holds, what nothing holds floats, and that is improbable.

The facts that say who may hold whom.

* ``Foot``: how high a body begins, as far as its pose tells, ``Foot("h2", 0.11, 0.13)``
* ``Gravity``: all of it, ``Gravity(0.1, feet=(Foot(...), ...), rests=(("h2", "h1"),))``

Everything here is plain data; ``plogic.cycle.placing`` makes it by geometry, and it comes back from
``interpretation.json``. ``Situation.gravity`` is None where nobody said that gravity holds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from plogic.facts.fact_rows import Fact, FootRow, GravityKey, GravityRow, RestsRow

GROUND = "ground"
"""Its name in facts and queries; no hypothesis may have it."""


class Foot(NamedTuple):
    """The lowest place of a body is between ``low`` and ``high`` m, world z, as far as its pose is known."""

    id: str
    low: float
    high: float


@dataclass(frozen=True)
class Gravity:
    """``unknown_support``: P(something unknown holds what floats).

    ``feet``: of the hypotheses that it speaks of; no other floats.

    ``rests``: ordered pairs, the first rests on the second if both are present; ``rests`` on ``GROUND`` where the
    ground's height ``ground``, m, is told. Where it is None, the ground is at the height of the lowest foot of the
    world: what may be no higher than it rests on the ground. ``silent``: why it speaks of nobody, '' where it does not
    keep silent.
    """

    unknown_support: float
    ground: float | None = None
    feet: tuple[Foot, ...] = ()
    rests: tuple[tuple[str, str], ...] = ()
    silent: str = ""

    def among(self, kept: Iterable[str]) -> Gravity:
        """What it says of these hypotheses alone."""
        ids = frozenset(kept) | {GROUND}
        return replace(
            self,
            feet=tuple(f for f in self.feet if f.id in ids),
            rests=tuple(r for r in self.rests if ids.issuperset(r)),
        )

    def holders(self, name: str) -> list[str]:
        """Whom it may rest on, the ground among them where that is told."""
        return [y for x, y in self.rests if x == name]

    def lower(self, name: str) -> list[str]:
        """Those that are surely lower: where one of them is present, this one does not stand on the lowest ground.

        None where that is told.
        """
        mine = next((foot for foot in self.feet if foot.id == name), None)
        return (
            [] if mine is None or self.ground is not None else [foot.id for foot in self.feet if foot.high < mine.low]
        )

    def floating(self, name: str, world: Iterable[str]) -> bool:
        """Whether it is in the world and nothing there holds it."""
        present = frozenset(world)
        if name not in present or all(foot.id != name for foot in self.feet):
            return False
        grounded = (
            GROUND in self.holders(name) if self.ground is not None else not present.intersection(self.lower(name))
        )
        return not grounded and not present.intersection(self.holders(name))


def linked(gravity: Gravity) -> list[tuple[str, str]]:
    """Pairs of hypotheses of which the one's presence may decide whether the other floats: who may hold whom, who is lower than whom."""
    held = [(x, y) for x, y in gravity.rests if y != GROUND]
    return held + [(foot.id, lower) for foot in gravity.feet for lower in gravity.lower(foot.id)]


def gravity_document(gravity: Gravity | None) -> GravityKey:
    """``{"gravity": {...}}`` of ``interpretation.json``, whose facts are elsewhere.

    Nothing where nobody said that it holds.
    """
    if gravity is None:
        return {}
    told: GravityRow = {"unknown_support": gravity.unknown_support, "ground": gravity.ground}
    return {"gravity": {**told, "silent": gravity.silent} if gravity.silent else told}


def gravity_facts(gravity: Gravity | None) -> list[FootRow | RestsRow]:
    """Its facts, for ``facts`` of the document: ``{"fact": "foot", "args": ["h1"], "low": 0.0, "high": 0.02}``, ``{"fact": "rests_on", ...}``."""
    if gravity is None:
        return []
    rows: list[FootRow | RestsRow] = []
    rows += [{"fact": "foot", "args": [foot.id], "low": foot.low, "high": foot.high} for foot in gravity.feet]
    rows += [{"fact": "rests_on", "args": list(pair)} for pair in gravity.rests]
    return rows


def gravity_of(document: GravityRow | None, facts: Sequence[Fact]) -> Gravity | None:
    """The typed form of both."""
    if document is None:
        return None
    ground = document["ground"]
    return Gravity(
        unknown_support=float(document["unknown_support"]),
        ground=None if ground is None else float(ground),
        feet=tuple(Foot(f["args"][0], float(f["low"]), float(f["high"])) for f in facts if f["fact"] == "foot"),
        rests=tuple((f["args"][0], f["args"][1]) for f in facts if f["fact"] == "rests_on"),
        silent=document.get("silent", ""),
    )
