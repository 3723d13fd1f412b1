"""What the occlusion relation of two objects predicts of their explanatory values, and where that fails.

A reason to doubt (§3.8).

| relation of x to y | prediction                                                                         |
|--------------------|------------------------------------------------------------------------------------|
| non_occludes       | ev(y given x) = ev(y), and the same of x                                           |
| partially_occludes | ev(x given y) = ev(x); ev(y given x) >= ev(y), if x hides no detected feature of y |
| totally_occludes   | ev(x given y) = ev(x); no feature of y is expected or detected                     |
| mutually_occludes  | ev(y given x) >= ev(y), if x hides no detected feature of y, and the same of x     |

ev(y given x) is taken in the world of y and x alone, in the situation's mode of reconsideration. Outlines and features
are two accounts of one geometry, and detections a third: where they contradict each other, a pose is wrong, or a
feature is not where its surface is, or a match is one of noise. Nothing is predicted of rivals, which never hide each
other, and a transparent object hides nothing.

``Doubt("totally_occludes", ("h1", "h2"), "h2 has no evidence either way", "1 feature expected, 2 detected", "roof/apex,
...")``
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple, Self

import numpy as np

from geometry.arrays import Mask
from plogic.facts.dependence import Scene
from plogic.facts.document import DoubtRow, Interpretation
from plogic.facts.situation import PairFact, Situation
from plogic.scene.readings.world_weights import cells, p_ev

SAME = 1e-9
"""Two values of ev that differ by less are the same: they are sums of the same numbers."""
NAMED = 3
"""Features that a doubt names."""


class Doubt(NamedTuple):
    """The ``relation`` of the pair ``args``, what it predicts, what is ``found``, and why that is so.

    ``evidence``: its probability by what is detected of both (§8, last paragraph), where that was asked.
    """

    relation: str
    args: tuple[str, str]
    expected: str
    found: str
    why: str
    evidence: float | None = None

    @classmethod
    def of(cls, row: DoubtRow) -> Self:
        """The doubt that a document tells."""
        x, y = row["args"]
        return cls(row["relation"], (x, y), row["expected"], row["found"], row["why"], row.get("evidence"))

    def document(self) -> DoubtRow:
        """As in ``interpretation.json``."""
        row: DoubtRow = {
            "relation": self.relation,
            "args": list(self.args),
            "expected": self.expected,
            "found": self.found,
            "why": self.why,
        }
        return row if self.evidence is None else {**row, "evidence": self.evidence}


def doubts(situation: Situation) -> tuple[Doubt, ...]:
    """Every prediction of §3.8 that fails, in the order of the relations."""
    scene = Scene(situation)
    alone = {h.id: _ev(scene, h.id) for h in situation.hypotheses}
    return tuple(
        doubt
        for fact in situation.relations
        if not scene.rival(fact.x, fact.y)
        for doubt in _of_pair(scene, fact, alone)
    )


def said(doubt: Doubt) -> str:
    """One line for people."""
    line = f"a reason to doubt {doubt.relation}({', '.join(doubt.args)}): expected {doubt.expected}, found {doubt.found}: {doubt.why}"
    return line if doubt.evidence is None else f"{line}; what is detected of both gives it {doubt.evidence:.3g}"


def weighed(found: Iterable[Doubt], document: Interpretation) -> list[Doubt]:
    """The doubts with the probabilities that the document tells of their relations."""
    told = {(row["relation"], *row["args"]): row.get("evidence") for row in document.get("doubts", ())}
    return [doubt._replace(evidence=told.get((doubt.relation, *doubt.args))) for doubt in found]


def _of_pair(scene: Scene, fact: PairFact, alone: Mapping[str, float]) -> Iterator[Doubt]:
    """What fails of what the relation of (x, y) says; what is its own converse is said of (y, x) by another fact."""
    if fact.relation == "non_occludes":
        yield from _unchanged(scene, fact, (fact.y, fact.x), alone[fact.y])
        return
    if fact.relation in ("partially_occludes", "totally_occludes"):
        yield from _unchanged(scene, fact, (fact.x, fact.y), alone[fact.x])
    if fact.relation == "totally_occludes":
        yield from _without_evidence(scene, fact)
    else:
        yield from _not_lower(scene, fact, alone[fact.y])


def _unchanged(scene: Scene, fact: PairFact, pair: tuple[str, str], alone: float) -> Iterator[Doubt]:
    subject, other = pair
    beside = _ev(scene, subject, other) if _bears_on(scene, subject, other) else alone
    if not (math.isnan(alone) and math.isnan(beside)) and not abs(alone - beside) <= SAME:
        hidden = _named(_hidden(scene, subject, other))
        why = f"{other} is nowhere in front of {subject}, and yet the line of sight to {hidden} meets it first"
        what = f"ev({subject} given {other}) = ev({subject}) = {_signed(alone)}"
        yield Doubt(fact.relation, (fact.x, fact.y), what, _signed(beside), why)


def _not_lower(scene: Scene, fact: PairFact, alone: float) -> Iterator[Doubt]:
    hidden = set(_hidden(scene, fact.y, fact.x))
    beside = _ev(scene, fact.y, fact.x) if _bears_on(scene, fact.y, fact.x) else alone
    detected = any(f.id in hidden and f.match is not None for f in scene.by_id[fact.y].features)
    if not detected and alone - beside > SAME:
        expected = f"ev({fact.y} given {fact.x}) >= ev({fact.y}) = {_signed(alone)}"
        why = f"{fact.x} hides no detected feature of {fact.y}"
        yield Doubt(fact.relation, (fact.x, fact.y), expected, _signed(beside), why)


def _without_evidence(scene: Scene, fact: PairFact) -> Iterator[Doubt]:
    if not scene.by_id[fact.x].opaque:
        return
    h, present = scene.by_id[fact.y], _present(scene, fact.y, fact.x)
    found = {f.id: cells(scene, h, f, present) for f in h.features if f.in_image}
    expected = [name for name, cell in found.items() if cell.expected[0]]
    detected = [name for name, cell in found.items() if cell.detected[0]]
    if expected or detected:
        some = _named(list(dict.fromkeys([*detected, *expected])))
        wanted = f"no feature of {fact.y} expected or detected given {fact.x}"
        why = f"{some} of {fact.y}, whose image {fact.x} covers, should be hidden"
        what = f"{len(expected)} expected, {len(detected)} detected"
        yield Doubt(fact.relation, (fact.x, fact.y), wanted, what, why)


def _bears_on(scene: Scene, name: str, other: str) -> bool:
    """Whether the presence of ``other`` may change a cell of ``name``: it hides a feature, or claims its appearance."""
    h, robbed = scene.by_id[name], scene.situation.reconsider == "reassign"
    return any(
        other in scene.hiders(h, f) or (robbed and any(g.id == other for g, _ in scene.robbers(h, f)))
        for f in h.features
    )


def _ev(scene: Scene, name: str, *others: str) -> float:
    """Ev of a hypothesis in the world of it and the others; NaN where it is undefined."""
    return 2.0 * float(p_ev(scene, scene.by_id[name], _present(scene, name, *others))[0]) - 1.0


def _present(scene: Scene, *names: str) -> dict[str, Mask]:
    return {h: np.array([h in names]) for h in scene.by_id}


def _hidden(scene: Scene, name: str, other: str) -> list[str]:
    """The features of a hypothesis, expected of it alone, that the other hides (D4)."""
    h = scene.by_id[name]
    return [f.id for f in h.features if f.in_image and h.expects(f) and other in scene.hiders(h, f)]


def _named(features: list[str]) -> str:
    more = len(features) - NAMED
    return ", ".join(features[:NAMED]) + (f" and {more} more" if more > 0 else "")


def _signed(ev: float) -> str:
    return "undefined" if math.isnan(ev) else f"{ev:+.3f}"
