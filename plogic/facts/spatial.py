"""Where the bodies of one view are, who may hold whom, and which of them A4 keeps apart.

* ``BodyFact``: one hypothesis' body, ``BodyFact("h1", middle=(0.1, 0.0, 0.9), nearest=0.85, view="inside")``
* ``SharedFact``: two bodies that A4 keeps apart, ``SharedFact("h1", "h3", volume=2.1e-5, depth=(0.012, 0.012))``
* ``Space``: all of it, as the rules of ``left_of``, ``above``, ``on``, ``near`` and the like read it. A hypothesis that
  it does not know is a point at its origin: so is everything in a file that was written without.
* ``Foot``: how high a body begins, as far as its pose tells, ``Foot("h2", 0.11, 0.13)``
* ``Gravity``: support (Σc), ``Gravity(0.1, feet=(Foot(...), ...), rests=(("h2", "h1"),))``: where gravity holds, what
  nothing holds floats, and that is improbable. ``Situation.gravity`` is None where nobody said that gravity holds.

Everything here is plain data, of metres, in the camera frame but for the heights of feet; ``plogic.cycle.placing`` and
``plogic.cycle.placing`` make it by geometry, and it comes back from ``interpretation.json``.

``exclusions``, ``exclusion_lines`` and ``apart_of`` tell, in numbers and in words, which hypotheses A4 keeps out of
each other's worlds: the volume that they share, and how deep.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NamedTuple, cast

from plogic.base.walk import by_key

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from plogic.facts.document import Interpretation
    from plogic.facts.fact_rows import (
        ExclusionRow,
        Fact,
        FootRow,
        GravityKey,
        GravityRow,
        OrderedRow,
        OverlapRow,
        SpaceRow,
    )

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
    """Pairs of hypotheses of which the one's presence may decide whether the other floats.

    Who may hold whom, who is lower than whom.
    """
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


def gravity_facts(gravity: Gravity | None) -> list[FootRow | OrderedRow]:
    """Its facts, for ``facts`` of the document.

    ``{"fact": "foot", "args": ["h1"], "low": 0.0, "high": 0.02}``, ``{"fact": "rests_on", ...}``.
    """
    if gravity is None:
        return []
    rows: list[FootRow | OrderedRow] = []
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


View = Literal["inside", "cut", "outside"]
Pair = tuple[str, str]


@dataclass(frozen=True)
class BodyFact:
    """``middle`` (3) of its bounding box, ``nearest``: from the camera's centre to its surface.

    ``view``: its outline, in the image or not.
    """

    id: str
    middle: tuple[float, float, float]
    nearest: float
    view: View


@dataclass(frozen=True)
class SharedFact:
    """``volume`` m³ that ``x`` and ``y`` share.

    ``depth`` low and high, m: how far one must be moved to be free of the other.
    """

    x: str
    y: str
    volume: float
    depth: tuple[float, float]


@dataclass(frozen=True)
class Space:
    """``up`` (3): against gravity, ``up_from`` what says so.

    None where nothing does, and then nothing is above anything.

    ``gaps``: metres between the surfaces of two bodies, each unordered pair once. ``above``: ordered pairs; ``on``:
    ordered pairs, the first standing on the second alone; ``on_both``: the first on the other two together, not on
    either alone. ``shared``: of ``Situation.overlaps``.
    """

    up: tuple[float, float, float] | None = None
    up_from: str = ""
    bodies: tuple[BodyFact, ...] = ()
    gaps: tuple[tuple[str, str, float], ...] = ()
    above: tuple[Pair, ...] = ()
    on: tuple[Pair, ...] = ()
    on_both: tuple[tuple[str, str, str], ...] = ()
    shared: tuple[SharedFact, ...] = ()

    def among(self, kept: Iterable[str]) -> Space:
        """What it says of these hypotheses alone."""
        ids = frozenset(kept)
        return replace(
            self,
            bodies=tuple(b for b in self.bodies if b.id in ids),
            gaps=tuple(g for g in self.gaps if ids.issuperset(g[:2])),
            above=tuple(p for p in self.above if ids.issuperset(p)),
            on=tuple(p for p in self.on if ids.issuperset(p)),
            on_both=tuple(t for t in self.on_both if ids.issuperset(t)),
            shared=tuple(s for s in self.shared if ids.issuperset((s.x, s.y))),
        )

    def names(self) -> frozenset[str]:
        """Whom it speaks of."""
        rows = [(b.id,) for b in self.bodies] + [g[:2] for g in self.gaps] + [(s.x, s.y) for s in self.shared]
        return frozenset(name for row in (*rows, *self.above, *self.on, *self.on_both) for name in row)

    def sharing(self, x: str, y: str) -> SharedFact | None:
        """What is known of the volume that two share, in either order."""
        return next((s for s in self.shared if {s.x, s.y} == {x, y}), None)


def space_document(space: Space) -> SpaceRow:
    """``space`` of ``interpretation.json``, without ``shared``, which its overlap facts carry."""
    return {
        "up": None if space.up is None else list(space.up),
        "up_from": space.up_from,
        "bodies": [{"id": b.id, "middle": list(b.middle), "nearest": b.nearest, "view": b.view} for b in space.bodies],
        "gaps": [list(row) for row in space.gaps],
        "above": [list(row) for row in space.above],
        "on": [list(row) for row in space.on],
        "on_both": [list(row) for row in space.on_both],
    }


def overlap_document(pair: Pair, space: Space) -> OverlapRow:
    """An overlap fact with its volume, m³, and depth, m, where they are known.

    ``depth_interval`` where it is known within bounds only.
    """
    row: OverlapRow = {"fact": "overlap", "args": list(pair)}
    if found := space.sharing(*pair):
        low, high = found.depth
        row |= {"volume": found.volume, "depth": high}
        row |= {} if low == high else {"depth_interval": [low, high]}
    return row


def space_of(document: SpaceRow | None, facts: Sequence[Fact]) -> Space:
    """The typed space of an interpretation's ``space`` and ``facts``.

    Without the one, and without volumes, an empty one.
    """
    shared = shared_of(facts)
    if document is None:
        return Space(shared=shared)
    up = document["up"]
    return Space(
        up=None if up is None else _triple(up),
        up_from=document["up_from"],
        bodies=tuple(
            BodyFact(b["id"], _triple(b["middle"]), float(b["nearest"]), b["view"]) for b in document["bodies"]
        ),
        gaps=tuple((str(x), str(y), float(gap)) for x, y, gap in document["gaps"]),
        above=tuple((x, y) for x, y in document["above"]),
        on=tuple((x, y) for x, y in document["on"]),
        on_both=tuple((x, y, z) for x, y, z in document["on_both"]),
        shared=shared,
    )


def shared_of(facts: Sequence[Fact]) -> tuple[SharedFact, ...]:
    """The volumes that overlap facts tell."""
    return tuple(_shared(f) for f in facts if f["fact"] == "overlap" and "volume" in f)


def _shared(fact: OverlapRow) -> SharedFact:
    x, y = fact["args"]
    depth = fact.get("depth", 0.0)
    low, high = fact.get("depth_interval") or (depth, depth)
    return SharedFact(x, y, float(fact["volume"]), (float(low), float(high)))


def _triple(row: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = row
    return float(x), float(y), float(z)


def words_of_shared(fact: SharedFact) -> str:
    """``2.1e-05 m3, 12 mm deep``; a depth that is known within bounds has both."""
    low, high = (f"{1000.0 * depth:.3g}" for depth in fact.depth)
    return f"{fact.volume:.3g} m3, {high if low == high else f'{low} to {high}'} mm deep"


LISTED = 5
"""Pairs that are told in words, the deepest first; the others are counted."""


def exclusions(document: Interpretation) -> list[ExclusionRow]:
    """The overlap facts of an interpretation.

    ``{"args": ["h1", "h3"], "volume": 2.1e-05, "depth": 0.012}``, as far as they are known.
    """
    return [
        cast("ExclusionRow", {key: value for key, value in fact.items() if key != "fact"})
        for fact in document["facts"]
        if fact["fact"] == "overlap"
    ]


def exclusion_lines(document: Interpretation) -> list[str]:
    """``h1 and h3 are never together (A4): they share 2.1e-05 m3, 12 mm deep``, by depth."""
    shared = sorted(shared_of(document["facts"]), key=lambda s: (-s.depth[1], s.x, s.y))
    names = {h["id"]: f"{h.get('label') or h['type']} {h['id']}" for h in document["hypotheses"]}
    lines = [
        f"{names.get(s.x, s.x)} and {names.get(s.y, s.y)} are never together (A4): they share {words_of_shared(s)}"
        for s in shared[:LISTED]
    ]
    left = len(shared) - len(lines)
    return [*lines, f"{left} more pairs are never together (A4); --json has them all"] if left else lines


def apart_of(space: Space, types: Mapping[str, str]) -> dict[str, list[str]]:
    """Sentences on the hypotheses that A4 keeps out of each one's worlds, the deepest first, a few.

    ``types``: each hypothesis' type by id.
    """
    told = by_key(
        (me, f"Never together with {types[other]} {other} (A4): they share {words_of_shared(fact)}.")
        for fact in sorted(space.shared, key=lambda s: (-s.depth[1], s.x, s.y))
        for me, other in ((fact.x, fact.y), (fact.y, fact.x))
    )
    return {name: lines[:LISTED] for name, lines in told.items()}
