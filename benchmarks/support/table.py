"""What ``plogic bench support`` prints: both sides' counts, planes, who is told to stand on what, and the claims."""

from __future__ import annotations

from collections import Counter
from statistics import median
from typing import TYPE_CHECKING, Any

from benchmarks.photos import told
from benchmarks.photos.score import Counts
from benchmarks.photos.table import row
from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from benchmarks.photos.told import Forecast
    from benchmarks.support.score import Judged, Thing

WITH, WITHOUT = "with support", "without"
SIDES = WITH, WITHOUT
PRINTED, PLAIN = "printed", "plain"
"""How the names of groups begin."""
ENOUGH = 3
"""Things that stand from which on the plane is to be first."""
FIRST, TOLD, CALIBRATED, MORE, DEEP = 0.97, 0.95, 0.03, 4 / 3, 0.6
"""What the issue on support asks for."""
BANDS = 10, 30, 55, 80
"""Degrees between the view and the table, between which things are counted apart."""
Sides = dict[str, "list[Judged]"]
"""Each side's pictures, in the same order."""


def rows(sides: Sides) -> list[dict[str, Any]]:
    """A row for each side and group, and for all of a side."""
    return [line for side, some in sides.items() for line in _rows(side, some)]


def _rows(side: str, some: Sequence[Judged]) -> Iterator[dict[str, Any]]:
    seconds = median(one.seconds for one in some)
    for group in (*dict.fromkeys(group for one in some for group in one.counts), None):
        own = [thing for one in some for thing in one.things if group in (None, thing.group)]
        free = [thing for thing in own if thing.kind == "free"]
        depths = [thing.depth for thing in own if thing.depth is not None]
        yield row(f"{group or 'all'}, {side}", _total(some, group or ""), seconds) | {
            "depth off, mm": round(1000.0 * median(depths), 1) if depths else None,
            "free": f"{sum(thing.row.found for thing in free)} of {len(free)}",
        }


def _total(some: Sequence[Judged], begins: str) -> Counts:
    """The counts of the groups whose names begin so."""
    return sum((c for one in some for group, c in one.counts.items() if group.startswith(begins)), Counts())


def more(sides: Sides) -> dict[str, list[dict[str, Any]]]:
    """Further tables, by name."""
    claimed = {side: _claimed(some) for side, some in sides.items()}
    tables = {
        "by tilt": by(sides, "degrees", _band),
        "by stance": by(sides, "stance", lambda _, thing: thing.kind),
        "plane first": planes(sides[WITH]),
        "said of what is found": confusion(sides[WITH]),
        "free, found without support alone": lost(sides),
        "claimed": [line for side, some in claimed.items() for line in told.rows(side, some)],
        "reliability": told.bins(WITH, claimed[WITH], (told.NAMED, told.STANDS)),
    }
    return {name: table for name, table in tables.items() if table}


def by(sides: Sides, name: str, key: Callable[[Judged, Thing], str]) -> list[dict[str, Any]]:
    """How many things are there, found and right on each side, by something."""
    found: dict[str, Counter[str]] = {}
    for side, some in sides.items():
        for one in some:
            for thing in one.things:
                count = found.setdefault(key(one, thing), Counter())
                count["there"] += side == WITH
                count[f"found, {side}"] += thing.row.found
                count[f"right, {side}"] += thing.row.right
    return [{name: value, **found[value]} for value in sorted(found)]


def _band(one: Judged, _: Thing) -> str:
    high = next((i for i, bound in enumerate(BANDS[1:-1], 1) if one.tilt < bound), len(BANDS) - 1)
    return f"{BANDS[high - 1]} to {BANDS[high]}"


def planes(some: Sequence[Judged]) -> list[dict[str, Any]]:
    """In how many pictures the first plane is right, by how many things stand there."""
    said = [one for one in some if one.plane is not None]
    return [
        {"standing": n, "pictures": len(own), "plane first": sum(bool(one.plane) for one in own)}
        for n in sorted({one.standing for one in said})
        if (own := [one for one in said if one.standing == n])
    ]


def confusion(some: Sequence[Judged]) -> list[dict[str, Any]]:
    """How what is found is held, and what is said of it; what stands on a thing that is not found, apart."""
    told_of: dict[str, Counter[str]] = {}
    for thing in (thing for one in some for thing in one.things if thing.says is not None):
        kind = thing.kind if thing.told is not None else f"{thing.kind}, on what is not found"
        told_of.setdefault(kind, Counter())[str(thing.says)] += 1
    kinds = "standing", "stacked", "free"
    return [{"true": kind, **{said: told_of[kind][said] for said in kinds}} for kind in sorted(told_of)]


def lost(sides: Sides) -> list[dict[str, Any]]:
    """The free ones that are found without support, and not with it."""
    pairs = zip(_things(sides[WITH]), _things(sides[WITHOUT]), strict=True)
    return [
        {"picture": without.picture, "number": without.row.obj_id, "of": without.group}
        for rests, without in pairs
        if without.kind == "free" and without.row.found and not rests.row.found
    ]


def claims(sides: Sides) -> list[Claim]:
    """What the issue asks for; None where it could not be measured."""
    rests, without = sides[WITH], sides[WITHOUT]
    firsts = [one.plane for one in rests if one.standing >= ENOUGH and one.plane is not None]
    told_right = [thing.told for thing in _things(rests) if thing.told is not None]
    claimed = _claimed(rests)
    return [
        Claim(f"plane first, share of {len(firsts)} pictures where three stand or more", ">=", FIRST, _share(firsts)),
        Claim(f"standing, stacked, free told right, share of {len(told_right)}", ">=", TOLD, _share(told_right)),
        *told.claims(WITH, claimed, CALIBRATED, (told.STANDS, told.NAMED), none=None),
        Claim("plain: right, of those without support", ">=", MORE, _ratio(rests, without)),
        Claim("printed: median depth error, of that without support", "<=", DEEP, _depths(rests, without)),
        Claim("free: found without support alone", "<=", 0, len(lost(sides))),
    ]


def _ratio(rests: Sequence[Judged], without: Sequence[Judged]) -> float | None:
    before = _total(without, PLAIN).right
    return _total(rests, PLAIN).right / before if before else None


def _depths(rests: Sequence[Judged], without: Sequence[Judged]) -> float | None:
    """Of the printed ones that are found on both sides."""
    pairs = [
        (one.depth, other.depth)
        for one, other in zip(_things(rests), _things(without), strict=True)
        if one.group.startswith(PRINTED) and one.depth is not None and other.depth is not None
    ]
    before = median(other for _, other in pairs) if pairs else 0.0
    return median(one for one, _ in pairs) / before if before else None


def _things(some: Sequence[Judged]) -> list[Thing]:
    return [thing for one in some for thing in one.things]


def _claimed(some: Sequence[Judged]) -> list[Forecast]:
    return [forecast for one in some for forecast in one.claimed]


def _share(some: Sequence[bool]) -> float | None:
    return sum(some) / len(some) if some else None


def missing(sides: Mapping[str, Sequence[Judged]]) -> list[str]:
    """What could not be judged, in words."""
    silent = all(one.plane is None for one in sides[WITH])
    return ["no interpretation has `support_planes`: what is said of support is not judged"] if silent else []
