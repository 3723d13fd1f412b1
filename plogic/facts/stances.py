"""What the things of one view stand on, and how (§9.9): planes, stable poses and their prior choices, as plain data.

It comes back from ``interpretation.json``.

Vocabulary, each with an example value:

* ``SupportPlane("s1", (0.0, -0.8, -0.6), -0.9, covariance, prior=0.7)``: a plane of the camera's frame.
* ``Stance("h1", "s1", 2, chance=0.3, log_ratio=4.1)``: h1 stands on s1 with the third of its type's stable poses.
* ``Support(rests=0.9, none=0.05, planes, stances, (("h1", 0.03),))``: all of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from plogic.base.walk import by_key

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from plogic.facts.document import HypothesisRow, Interpretation
    from plogic.facts.fact_rows import StanceRow, StancesKeys, StandingKeys, SupportPlaneRow

FREE, NONE, OTHER = "free", "none", "other"
"""The stance of what rests on nothing known; that nothing says where things stand; a plane that is not named."""

Row = tuple[float, float, float]
"""Three numbers: a vector, or a row of a 3×3 matrix."""


@dataclass(frozen=True)
class SupportPlane:
    """A plane that things may stand on: ``normal``·x = ``offset`` in the camera's frame, metres.

    ``normal`` is a unit vector that points upwards, against gravity; the camera is ``-offset`` above the plane.
    ``covariance`` is over the tilts about x and y (rad) and the offset (m). ``prior`` is its share of the one choice
    that an image makes among planes.
    """

    name: str
    normal: Row
    offset: float
    covariance: tuple[Row, Row, Row]
    prior: float


@dataclass(frozen=True)
class Stance:
    """One way of standing: ``hypothesis`` stands on a plane, or on another hypothesis, by name.

    ``face`` says which of its type's stable poses. ``chance`` is the prior chance of this way given that what it stands
    on is there. ``log_ratio`` is ln ρ, from -600 to 600: how much better the pose fits this way than that of a free
    body. A way that the pose does not fit at all need not be told.
    """

    hypothesis: str
    on: str
    face: int
    chance: float
    log_ratio: float


@dataclass(frozen=True)
class Support:
    """The choice of one plane for an image, and of one way of standing for each hypothesis that has a footing.

    ``rests``: the chance that a present object rests on something known or on a plane. ``none``: the chance that
    nothing says where things stand. What is left beside ``none`` and the planes' priors is the chance of a plane that
    is none of those named.

    ``by_chance``: hypothesis → e, P(its pose stands as if it were there, given that neither it is nor one that excludes
    it); 0 of those not named. Who is present has a footing, and with probability e who is absent so.

    ``level``: of a hypothesis and a plane, by how much likelier its pose is where it is free and that plane holds, for
    it may rest level above it on something unknown (a logarithm, 0 of those not named).
    """

    rests: float
    none: float
    planes: tuple[SupportPlane, ...]
    stances: tuple[Stance, ...]
    by_chance: tuple[tuple[str, float], ...] = ()
    level: tuple[tuple[str, str, float], ...] = ()

    def among(self, kept: Iterable[str]) -> Support:
        """What it says of these hypotheses alone."""
        known = frozenset(kept)
        there = known | {plane.name for plane in self.planes}
        stances = tuple(s for s in self.stances if s.hypothesis in known and s.on in there)
        by_chance = tuple(row for row in self.by_chance if row[0] in known)
        level = tuple(row for row in self.level if row[0] in known)
        return replace(self, stances=stances, by_chance=by_chance, level=level)


class Stood(NamedTuple):
    """P(support_plane) by name, P(it is present and stands so) of each stance in its order, and P(free) by id."""

    planes: dict[str, float]
    stances: tuple[float, ...]
    free: dict[str, float]


def standing_document(support: Support | None, found: Stood | None) -> StandingKeys:
    """``support_planes`` and ``resting`` of ``interpretation.json``; nothing where nobody said that things rest."""
    if support is None or found is None:
        return {}
    planes = [_plane_row(plane, found.planes[plane.name], support, found) for plane in support.planes]
    return {"support_planes": planes, "resting": {"rests": support.rests, "none": support.none}}


def stances_document(hypothesis: str, support: Support | None, found: Stood | None) -> StancesKeys:
    """The ways of one hypothesis to stand, with their probabilities; nothing where nobody said that things rest."""
    if support is None or found is None:
        return {}
    rows: list[StanceRow] = [
        {"on": s.on, "face": s.face, "chance": s.chance, "log_ratio": s.log_ratio, "probability": p}
        for s, p in zip(support.stances, found.stances, strict=True)
        if s.hypothesis == hypothesis
    ]
    told: StancesKeys = {"stances": rows}
    if hypothesis in found.free:
        told["free"] = found.free[hypothesis]
    if level := {plane: ratio for name, plane, ratio in support.level if name == hypothesis}:
        told["level"] = level
    if e := dict(support.by_chance).get(hypothesis):
        told["stands_by_chance"] = e
    return told


def support_of(document: Interpretation) -> Support | None:
    """The typed form of a document's support; None where nobody said that things rest."""
    told = document.get("resting")
    if told is None:
        return None
    planes = tuple(_plane(row) for row in document.get("support_planes", ()))
    rows = [h for h in document["hypotheses"] if h["status"] != "rejected"]
    by_chance = tuple((h["id"], float(h["stands_by_chance"])) for h in rows if "stands_by_chance" in h)
    level = tuple((h["id"], plane, float(ratio)) for h in rows for plane, ratio in h.get("level", {}).items())
    return Support(float(told["rests"]), float(told["none"]), planes, tuple(_stances(rows)), by_chance, level)


def _stances(hypotheses: Sequence[HypothesisRow]) -> Iterator[Stance]:
    for h in hypotheses:
        for s in h.get("stances", ()):
            yield Stance(h["id"], s["on"], s["face"], float(s["chance"]), float(s["log_ratio"]))


def _plane_row(plane: SupportPlane, probability: float, support: Support, found: Stood) -> SupportPlaneRow:
    there: dict[str, float] = {}
    for s, p in zip(support.stances, found.stances, strict=True):
        if s.on == plane.name:
            there[s.hypothesis] = there.get(s.hypothesis, 0.0) + p
    return {
        "name": plane.name,
        "plane": {"normal": list(plane.normal), "offset": plane.offset},
        "covariance": [list(row) for row in plane.covariance],
        "prior": plane.prior,
        "probability": probability,
        "standing": there,
    }


def _plane(row: SupportPlaneRow) -> SupportPlane:
    first, second, third = (_row(some) for some in row["covariance"])
    normal, offset = _row(row["plane"]["normal"]), float(row["plane"]["offset"])
    return SupportPlane(row["name"], normal, offset, (first, second, third), float(row["prior"]))


def _row(numbers: Sequence[float]) -> Row:
    x, y, z = numbers
    return float(x), float(y), float(z)


def words_of_standing(support: str | None, stances: Mapping[str, str]) -> str:
    """What things stand on in a world: ``s1: h1, h2; h1: h3; free: h4``; a plane that nothing stands on is named."""
    if support is None:
        return ""
    on = by_key((stance.rpartition("/")[0] or stance, name) for name, stance in stances.items())
    first: dict[str, list[str]] = {} if support in on else {support: []}
    return "; ".join(f"{what}: {', '.join(who)}" if who else what for what, who in {**first, **on}.items())
