"""A situation is checked before anything is made of it: it may come from a file that a stranger wrote."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator

from geometry.errors import Keys, Mistake
from geometry.visibility.roc import ROC20, coarse
from plogic.base.errors import SituationError
from plogic.base.walk import by_key
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.facts.pixel_table import MOST_BEFORE, PixelTable
from plogic.facts.situation import EvidenceFact, PairFact, Situation
from plogic.facts.spatial import GROUND, Gravity, Space
from plogic.facts.stances import FREE, NONE, OTHER, Stance, Support

Ids = frozenset[str]
SUMS = 1e-6
"""By so much a sum of written probabilities may be off 1."""
MOST_TOLD = 600.0
"""Log-odds of pixels, or of a stance, that can be told, either way: e to that power is a number yet."""


def check(situation: Situation) -> None:
    """Raise SituationError with every fault of a situation."""
    wrong = tuple(fault.what for fault in faults(situation))
    if wrong:
        raise SituationError(*wrong)


def faults(situation: Situation) -> Iterator[Mistake]:
    """Every duplicate or unknown id, and every number that is out of its range, each a sentence of its own.

    Its place is that in the document of the situation, where a row is named by its id: ``("hypotheses", "h1")``.
    """
    ids, data = frozenset(h.id for h in situation.hypotheses), frozenset(a.id for a in situation.appearances)
    yield from _at(("hypotheses",), _twice("hypothesis", [h.id for h in situation.hypotheses]))
    yield from _at(("appearances",), _twice("appearance", [a.id for a in situation.appearances]))
    yield from _at(("facts",), _of_facts(situation, ids))
    yield from _at(("space",), _of_space(situation.space, ids))
    if situation.gravity is not None:
        yield from _at(("gravity",), _of_gravity(situation.gravity, ids))
    if situation.support is not None:
        yield from _at(("support_planes",), _of_support(situation.support, ids))
    for a in situation.appearances:
        yield from _at(("appearances", a.id), _number(f"appearance {a.id}: clutter", a.clutter, 0.0, math.inf))
    for h in situation.hypotheses:
        yield from _of_hypothesis(h, ids, data)
    for name, prior in situation.priors.items():
        yield from _at(("priors", name), _number(f"prior of {name}", prior, 0.0, 1.0))
    yield from _at(("smoothing",), _number("smoothing", situation.smoothing, 0.0, 0.5))


def _at(place: Keys, sentences: Iterable[str]) -> Iterator[Mistake]:
    return (Mistake(place, sentence) for sentence in sentences)


def _of_facts(situation: Situation, ids: Ids) -> Iterator[str]:
    for name in ("overlaps", "rivals", "exclusive"):
        for pair in sorted(getattr(situation, name)):
            yield from _unknown(name, pair, ids)
    nodes = {h.id: frozenset(part.id for part in h.parts) | {""} for h in situation.hypotheses}
    for relation in (*situation.relations, *situation.part_relations):
        yield from _of_relation(relation, ids, nodes)
    for evidence in situation.evidence:
        yield from _of_evidence(evidence, ids)


def _of_space(space: Space, ids: Ids) -> Iterator[str]:
    yield from _unknown("space", sorted(space.names()), ids)
    yield from _twice("space: body of hypothesis", [body.id for body in space.bodies])
    for body in space.bodies:
        yield from _number(f"space: {body.id}: nearest", body.nearest, 0.0, math.inf)
        yield from _numbers(((f"space: {body.id}: middle", m) for m in body.middle), -math.inf, math.inf)
    yield from _numbers(((f"space: gap of {x} and {y}", gap) for x, y, gap in space.gaps), 0.0, math.inf)
    shared = ((f"overlap of {s.x} and {s.y}", value) for s in space.shared for value in (s.volume, *s.depth))
    yield from _numbers(shared, 0.0, math.inf)


def _of_gravity(gravity: Gravity, ids: Ids) -> Iterator[str]:
    if GROUND in ids:
        yield f"hypothesis {GROUND!r}: so the ground is called, where gravity holds"
    feet = [foot.id for foot in gravity.feet]
    yield from _twice("gravity: foot of hypothesis", feet)
    yield from _unknown("gravity: foot", dict.fromkeys(feet), ids)
    yield from _unknown("gravity: rests_on", [x for x, _ in gravity.rests], ids)
    held = ids if gravity.ground is None else ids | {GROUND}
    yield from _unknown("gravity: rests_on", [y for _, y in gravity.rests], held)
    if not gravity.unknown_support > 0.0:
        yield f"gravity: unknown_support: {gravity.unknown_support!r} is not above 0"
    yield from _number("gravity: unknown_support", gravity.unknown_support, 0.0, 1.0)
    yield from _number("gravity: ground", gravity.ground or 0.0, -math.inf, math.inf)
    for foot in gravity.feet:
        yield from _number(f"gravity: foot of {foot.id}: low", foot.low, -math.inf, foot.high)
        yield from _number(f"gravity: foot of {foot.id}: high", foot.high, foot.low, math.inf)
    yield from (f"gravity: {x!r} rests on itself" for x, y in gravity.rests if x == y)


def _of_support(support: Support, ids: Ids) -> Iterator[str]:
    """Planes and ways to stand that are known, chances that sum to at most 1, and no ring of hypotheses."""
    planes = [plane.name for plane in support.planes]
    taken = ids | {GROUND, FREE, NONE, OTHER}
    yield from _twice("support: plane", planes)
    yield from (f"support: {name!r} is no name of a plane" for name in planes if name in taken or not name)
    yield from (f"support: hypothesis {name!r} has the name of a stance" for name in sorted(ids & {FREE, NONE, OTHER}))
    yield from _number("support: rests", support.rests, 0.0, 1.0)
    yield from _numbers((("support: none", support.none), *_priors(support)), 0.0, 1.0)
    if sum((support.none, *(plane.prior for plane in support.planes))) > 1.0 + SUMS:
        yield "support: priors of planes, with none, sum to more than 1"
    for plane in support.planes:
        place = f"support: {plane.name}"
        numbers = [*plane.normal, plane.offset, *(x for row in plane.covariance for x in row)]
        yield from _numbers(((place, x) for x in numbers), -math.inf, math.inf)
        if not abs(math.hypot(*plane.normal) - 1.0) <= SUMS:
            yield f"{place}: normal is {math.hypot(*plane.normal)!r} long, not 1"
    yield from _unknown("support: by_chance", dict(support.by_chance), ids)
    yield from _twice("support: by_chance", [name for name, _ in support.by_chance])
    yield from _numbers([(f"support: by_chance of {name}", e) for name, e in support.by_chance], 0.0, 1.0)
    yield from _unknown("support: level", dict.fromkeys(name for name, _, _ in support.level), ids)
    yield from _unknown(
        "support: level above", dict.fromkeys(plane for _, plane, _ in support.level), frozenset(planes)
    )
    above = [(f"support: level of {name} above {plane}", ratio) for name, plane, ratio in support.level]
    yield from _twice("support: level", [place for place, _ in above])
    yield from _numbers(above, 0.0, MOST_TOLD)
    yield from _of_stances(support, ids, frozenset(planes))


def _priors(support: Support) -> Iterator[tuple[str, float]]:
    return ((f"support: prior of {plane.name}", plane.prior) for plane in support.planes)


def _of_stances(support: Support, ids: Ids, planes: Ids) -> Iterator[str]:
    yield from _unknown("support: stance", dict.fromkeys(s.hypothesis for s in support.stances), ids)
    yield from _unknown("support: stance on", dict.fromkeys(s.on for s in support.stances), ids | planes)
    ways = [f"of {s.hypothesis} on {s.on}, face {s.face}" for s in support.stances]
    yield from _twice("support: stance", ways)
    for way, s in zip(ways, support.stances, strict=True):
        yield from _number(f"support: chance {way}", s.chance, 0.0, 1.0)
        yield from _number(f"support: log_ratio {way}", s.log_ratio, -MOST_TOLD, MOST_TOLD)
        if s.face < 0:
            yield f"support: stance {way}: face is below 0"
    for name, mine in by_key((s.hypothesis, s) for s in support.stances).items():
        on_others = sum(s.chance for s in mine if s.on in ids)
        on_planes = by_key((s.on, s.chance) for s in mine if s.on in planes)
        most = on_others + max((sum(some) for some in on_planes.values()), default=0.0)
        if most > support.rests + SUMS:
            yield f"support: chances of {name} sum to {most!r}, which is more than rests, {support.rests!r}"
    yield from _rings([s for s in support.stances if s.on in ids])


def _rings(stances: list[Stance]) -> Iterator[str]:
    """Who stands on what stands on it, over any number of others."""
    below = by_key((s.hypothesis, s.on) for s in stances)
    while lowest := {on for some in below.values() for on in some} - below.keys():
        below = {name: left for name, some in below.items() if (left := [on for on in some if on not in lowest])}
    if below:
        yield f"support: of {', '.join(sorted(below))} some stand on what stands on them"


def _of_relation(fact: PairFact, ids: Ids, nodes: dict[str, Ids]) -> Iterator[str]:
    """A part of a hypothesis that is there; and the case of ROC-20 belongs to the coarse relation."""
    yield from _unknown(f"relation {fact.relation}", (fact.x, fact.y), ids)
    fine = {name for name in ROC20 if coarse(name) == fact.relation}
    if fact.roc and fact.roc not in fine:
        cases = ", ".join(sorted(fine)) or "nothing"
        yield f"relation {fact.relation}: {fact.roc!r} is no case of it, as {cases} would be"
    for name, part in zip((fact.x, fact.y), fact.parts, strict=True):
        if name in nodes:
            yield from _unknown(f"relation {fact.relation}: parts of {name}", (part,), nodes[name])


def _of_evidence(fact: EvidenceFact, ids: Ids) -> Iterator[str]:
    """Known hypotheses and relations, one to each pair, and probabilities that sum to 1."""
    yield from _unknown("evidence", [*fact.withheld, *(name for pair in fact.pairs for name in pair)], ids)
    yield from (f"evidence: {x!r} is paired with itself" for x, y in fact.pairs if x == y)
    shares = [share for share, _ in fact.states]
    yield from _numbers((("evidence: probability", share) for share in shares), 0.0, 1.0)
    if not abs(sum(shares) - 1.0) <= SUMS:
        yield f"evidence: probabilities sum to {sum(shares)!r}, not to 1"
    for _, relations in fact.states:
        if len(relations) != len(fact.pairs):
            yield f"evidence: {len(relations)} relations of {len(fact.pairs)} pairs"
        yield from (f"evidence: {name!r} is no relation of ROC-20" for name in relations if name not in ROC20)


def _of_hypothesis(h: Hypothesis, ids: Ids, data: Ids) -> Iterator[Mistake]:
    here: Keys = ("hypotheses", h.id)
    yield from _at(here, _twice(f"hypothesis {h.id}: feature", [f.id for f in h.features]))
    matched = [f.match for f in h.features if f.match is not None]
    yield from _at(here, _twice(f"hypothesis {h.id}: appearance that is matched", matched))
    if h.pixel_table is not None:
        yield from _at(
            (*here, "pixels_beside"), _of_pixels(f"hypothesis {h.id}: pixels_beside", h.pixel_table, ids - {h.id})
        )
    for f in h.features:
        sentences = _of_feature(f"hypothesis {h.id}: feature {f.id}", f, ids, data)
        yield from _at((*here, "features", f.id), sentences)


def _of_pixels(place: str, table: PixelTable, others: Ids) -> Iterator[str]:
    """A number for every set of a few others."""
    yield from _unknown(place, table.names, others)
    if any(math.isnan(odds) for odds in table.odds):
        yield f"{place}: should tell every set of those before it, {MOST_BEFORE} at most, once"
    else:
        yield from _numbers(((place, odds) for odds in table.odds), -MOST_TOLD, MOST_TOLD)


def _of_feature(place: str, f: FeatureFact, ids: Ids, data: Ids) -> Iterator[str]:
    yield from _unknown(f"{place}: hidden_by", f.hidden_by, ids)
    if f.match is not None:
        yield from _unknown(f"{place}: match", (f.match,), data)
    yield from _numbers(((f"{place}: dv", f.dv), (f"{place}: density", f.density)), 0.0, math.inf)
    yield from _number(f"{place}: hit_rate", f.hit_rate, 0.0, 1.0)


def _twice(what: str, ids: list[str]) -> Iterator[str]:
    if len(set(ids)) < len(ids):
        yield from (f"{what} {name!r} occurs twice" for name, times in Counter(ids).items() if times > 1)


def _unknown(place: str, names: Iterable[str], ids: Ids) -> Iterator[str]:
    yield from (f"{place}: {name!r} is unknown" for name in names if name not in ids)


def _numbers(rows: Iterable[tuple[str, float]], low: float, high: float) -> Iterator[str]:
    for place, value in rows:
        yield from _number(place, value, low, high)


def _number(place: str, value: float, low: float, high: float) -> Iterator[str]:
    if not (low <= value <= high and math.isfinite(value)):
        yield f"{place}: {value!r} is not a number from {low} to {high}"
