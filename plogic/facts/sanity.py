"""A situation is checked before anything is made of it: it may come from a file that a stranger wrote."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from geometry.visibility.roc import ROC20, coarse
from plogic.base.errors import SituationError
from plogic.facts.gravity import GROUND

if TYPE_CHECKING:
    from collections.abc import Iterable

    from plogic.facts.gravity import Gravity
    from plogic.facts.hypothesis import FeatureFact, Hypothesis
    from plogic.facts.situation import PairFact, Situation
    from plogic.facts.spatial import Space


def check(situation: Situation) -> None:
    """Raise SituationError at the first duplicate or unknown id, and at the first number that is out of its range."""
    ids = _unique("hypothesis", [h.id for h in situation.hypotheses])
    data = _unique("appearance", [a.id for a in situation.appearances])
    for pairs, name in (
        (situation.overlaps, "overlaps"),
        (situation.rivals, "rivals"),
        (situation.exclusive, "exclusive"),
    ):
        for pair in sorted(pairs):
            _known(name, pair, ids)
    for relation in (*situation.relations, *situation.part_relations):
        _known(f"relation {relation.relation}", (relation.x, relation.y), ids)
        _check_relation(relation)
    _check_space(situation.space, ids)
    if situation.gravity is not None:
        _check_gravity(situation.gravity, ids)
    nodes = {h.id: frozenset(part.id for part in h.parts) | {""} for h in situation.hypotheses}
    for relation in situation.part_relations:
        for name, part in zip((relation.x, relation.y), relation.parts, strict=True):
            _known(f"relation {relation.relation}: parts of {name}", (part,), nodes[name])
    for a in situation.appearances:
        _number(f"appearance {a.id}: clutter", a.clutter, 0.0, math.inf)
    for h in situation.hypotheses:
        _check_hypothesis(h, ids, data)
    for name, prior in situation.priors.items():
        _number(f"prior of {name}", prior, 0.0, 1.0)
    _number("smoothing", situation.smoothing, 0.0, 0.5)


def _check_space(space: Space, ids: frozenset[str]) -> None:
    _known("space", sorted(space.names()), ids)
    _unique("space: body of hypothesis", [body.id for body in space.bodies])
    for body in space.bodies:
        _number(f"space: {body.id}: nearest", body.nearest, 0.0, math.inf)
        for metres in body.middle:
            _number(f"space: {body.id}: middle", metres, -math.inf, math.inf)
    for x, y, gap in space.gaps:
        _number(f"space: gap of {x} and {y}", gap, 0.0, math.inf)
    for shared in space.shared:
        for value in (shared.volume, *shared.depth):
            _number(f"overlap of {shared.x} and {shared.y}", value, 0.0, math.inf)


def _check_gravity(gravity: Gravity, ids: frozenset[str]) -> None:
    if GROUND in ids:
        raise SituationError(f"hypothesis {GROUND!r}: so the ground is called, where gravity holds")
    _known("gravity: foot", _unique("gravity: foot of hypothesis", [foot.id for foot in gravity.feet]), ids)
    _known("gravity: rests_on", [x for x, _ in gravity.rests], ids)
    _known("gravity: rests_on", [y for _, y in gravity.rests], ids if gravity.ground is None else ids | {GROUND})
    if not gravity.unknown_support > 0.0:
        raise SituationError(f"gravity: unknown_support: {gravity.unknown_support!r} is not above 0")
    _number("gravity: unknown_support", gravity.unknown_support, 0.0, 1.0)
    _number("gravity: ground", gravity.ground or 0.0, -math.inf, math.inf)
    for foot in gravity.feet:
        _number(f"gravity: foot of {foot.id}: low", foot.low, -math.inf, foot.high)
        _number(f"gravity: foot of {foot.id}: high", foot.high, foot.low, math.inf)
    for x, y in gravity.rests:
        if x == y:
            raise SituationError(f"gravity: {x!r} rests on itself")


def _check_relation(fact: PairFact) -> None:
    """What is told of ROC-20 is the coarse relation in full."""
    fine = {name for name in ROC20 if coarse(name) == fact.relation}
    if fact.roc and fact.roc not in fine:
        raise SituationError(
            f"relation {fact.relation}: {fact.roc!r} is no case of it, as {', '.join(sorted(fine)) or 'nothing'} would be"
        )


def _check_hypothesis(h: Hypothesis, ids: frozenset[str], data: frozenset[str]) -> None:
    _unique(f"hypothesis {h.id}: feature", [f.id for f in h.features])
    _unique(f"hypothesis {h.id}: appearance that is matched", [f.match for f in h.features if f.match is not None])
    for f in h.features:
        _check_feature(f"hypothesis {h.id}: feature {f.id}", f, ids, data)


def _check_feature(place: str, f: FeatureFact, ids: frozenset[str], data: frozenset[str]) -> None:
    _known(f"{place}: hidden_by", f.hidden_by, ids)
    if f.match is not None:
        _known(f"{place}: match", (f.match,), data)
    _number(f"{place}: dv", f.dv, 0.0, math.inf)
    _number(f"{place}: density", f.density, 0.0, math.inf)
    _number(f"{place}: hit_rate", f.hit_rate, 0.0, 1.0)


def _unique(what: str, ids: list[str]) -> frozenset[str]:
    seen: set[str] = set()
    for name in ids:
        if name in seen:
            raise SituationError(f"{what} {name!r} occurs twice")
        seen.add(name)
    return frozenset(seen)


def _known(place: str, names: Iterable[str], ids: frozenset[str]) -> None:
    for name in names:
        if name not in ids:
            raise SituationError(f"{place}: {name!r} is unknown")


def _number(place: str, value: float, low: float, high: float) -> None:
    if not (low <= value <= high and math.isfinite(value)):
        raise SituationError(f"{place}: {value!r} is not a number from {low} to {high}")
