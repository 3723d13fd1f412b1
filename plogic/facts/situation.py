"""What one view leaves to decide: the typed description that the program text and the exact worlds are both made from.

Vocabulary, each with an example value:

* ``AppearanceFact``: one datum of Γ, ``AppearanceFact(id="a1", type="l_junction", uv=(312.4, 201.9), clutter=2e-5)``
* ``PairFact``: a relation that geometry computed of two posed objects, ``PairFact("partially_occludes", "h1", "h2",
  "partially_occludes_po")``
* ``TypeFact``: one object type as Σo describes it, ``TypeFact(features=(("roof/apex", "apex"), ...), ...)``
* ``EvidenceFact``: how hypotheses stand by what is detected, ``EvidenceFact((("h2", "h1"),), ((0.9,
  ("partially_occludes_po",)), (0.1, ("non_occludes_dc",))), withheld=("h2",))``
* ``Situation``: all of it, with the reading, the mode of reconsideration and the side tables.

Nothing here is computed from probabilities; everything here is plain data that goes into ``interpretation.json`` and
comes back. ``pair_facts`` gives a relation of ROC-20 as facts of the ordered pair that it is said of (§3.6, §3.7).
``names_of`` gives the table of a situation's names, each label with its atom (contract, "Names";
``plogic.logic.safety.atoms``): generated atoms are ``f1`` for a feature's path that is not plain, ``n1`` for the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import count
from typing import TYPE_CHECKING, Literal, NamedTuple

from geometry.visibility.roc import COARSE, ROC20, Roc, coarse, coarse_converse, converse, parts_of, rcc_converse
from plogic.facts.spatial import Space
from plogic.logic.safety.atoms import Names, is_plain, quoted

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.facts.document import Marks
    from plogic.facts.hypothesis import Hypothesis, PartFact
    from plogic.facts.spatial import Gravity
    from plogic.facts.stances import Support
    from plogic.logic.served.engine import Text

Reading = Literal["score", "posterior"]
Reconsider = Literal["to_B", "drop", "reassign"]
DvOver = Literal["types", "instances"]
"""What dv is counted over: the types of Σo, or the instances in Δ (§5.1)."""


OTHERS = "(others)"
"""Id and type of the feature that stands for those that are not told; no name of a knowledge base has parentheses."""


@dataclass(frozen=True)
class AppearanceFact:
    """One datum of Γ: ``uv`` in pixels.

    ``clutter`` is the density f of clutter of its type, per pixel² (§8, posterior).
    """

    id: str
    type: str
    uv: tuple[float, float]
    clutter: float


@dataclass(frozen=True)
class PairFact:
    """``relation`` holds of the ordered pair ``(x, y)`` of hypotheses, decided by outlines and depth (§3.5-3.7).

    ``roc`` is the relation of ROC-20 that it is the coarse form of, '' in documents that do not tell it. ``parts``: of
    which part of x, and of which part of y, it is said; '' is the whole.
    """

    relation: str
    x: str
    y: str
    roc: str = ""
    parts: tuple[str, str] = ("", "")


class LookFact(NamedTuple):
    """One way that a feature looks, and from where (§2.7): object frame, metres, radians; ``axis`` is a unit vector."""

    feature: str
    type: str
    axis: tuple[float, float, float]
    half_angle: float
    r_min: float
    r_max: float


@dataclass(frozen=True)
class TypeFact:
    """One object type as Σo describes it, whether or not anything is hypothesised of it.

    ``features``: path and type of each, ``parts``: the nodes of the tree that are no such features. ``facets``,
    ``faces``: the triangles and the faces of its surface whose corners are all features, by their paths (§4.2).
    """

    features: tuple[tuple[str, str], ...] = ()
    parts: tuple[PartFact, ...] = ()
    looks: tuple[LookFact, ...] = ()
    facets: tuple[tuple[str, ...], ...] = ()
    faces: tuple[tuple[str, ...], ...] = ()
    opaque: bool = True


@dataclass(frozen=True)
class EvidenceFact:
    """What detections say of how hypotheses stand to each other (§8 of the paper, last paragraph).

    ``states``: (probability, the relation of ROC-20 of each of the ``pairs``), jointly; they sum to 1. ``withheld``:
    those whose poses are not known, so that nothing else says how they stand.
    """

    pairs: tuple[tuple[str, str], ...]
    states: tuple[tuple[float, tuple[Roc, ...]], ...]
    withheld: tuple[str, ...] = ()

    def among(self, kept: frozenset[str]) -> EvidenceFact:
        """What it says of these hypotheses alone."""
        which = [i for i, pair in enumerate(self.pairs) if kept.issuperset(pair)]
        merged: dict[tuple[Roc, ...], float] = {}
        for share, relations in self.states:
            some = tuple(relations[i] for i in which)
            merged[some] = merged.get(some, 0.0) + share
        withheld = tuple(name for name in self.withheld if name in kept)
        return EvidenceFact(tuple(self.pairs[i] for i in which), tuple((p, s) for s, p in merged.items()), withheld)


@dataclass(frozen=True)
class Situation:
    """Everything that decides the probabilities of one image's worlds.

    ``overlaps``: unordered pairs that share volume (A4). ``rivals``: unordered pairs that never hide each other (§4.1):
    those that A4 excludes from one world and those that claim the same appearances; ``exclusive`` is the part of
    ``rivals`` that the constraints of the score reading forbid to be present together (an appearance serves one
    feature, D8). ``priors`` per type (posterior). ``smoothing`` ε replaces p by ε + (1 − 2ε) p in the *score* program's
    choices (trap c), never in the measures; 0 by default. ``dv`` per feature type, counted ``dv_over`` types or
    instances (§5.1), and ``rank`` per object type are side tables for queries, ``hit_rates`` per feature type of those
    of which nothing is expected here. ``relations`` are of whole hypotheses that can be present together,
    ``part_relations`` of a part of one and a part of another, or the whole of it. ``evidence`` is what detections say
    of relations. ``space`` says where bodies are, and ``types`` what Σo says of object types: they decide no
    probability of a world. ``gravity`` says who holds whom, which decides some (Σc); None where nobody said that it
    holds. ``support`` says what things may stand on (§9.9); None where nobody said that they rest. ``rules`` is the
    author's ``rules.pl``, ``own`` those of who asks, which no document holds. ``stopped`` says
    whether more time would have found more; it decides no probability of what was.
    """

    reading: Reading
    hypotheses: tuple[Hypothesis, ...]
    appearances: tuple[AppearanceFact, ...]
    reconsider: Reconsider = "to_B"
    overlaps: frozenset[tuple[str, str]] = frozenset()
    rivals: frozenset[tuple[str, str]] = frozenset()
    exclusive: frozenset[tuple[str, str]] = frozenset()
    relations: tuple[PairFact, ...] = ()
    space: Space = field(default_factory=Space)
    part_relations: tuple[PairFact, ...] = ()
    types: dict[str, TypeFact] = field(default_factory=dict, compare=False)
    evidence: tuple[EvidenceFact, ...] = ()
    gravity: Gravity | None = None
    support: Support | None = None
    priors: dict[str, float] = field(default_factory=dict)
    dv: dict[str, float] = field(default_factory=dict)
    dv_over: DvOver = "types"
    rank: dict[str, float] = field(default_factory=dict)
    hit_rates: dict[str, float] = field(default_factory=dict)
    smoothing: float = 0.0
    rules: str = ""
    own: Text | None = None
    stopped: Stopped = ""

    @property
    def withheld(self) -> frozenset[str]:
        """The hypotheses whose pose is not known."""
        return frozenset(name for fact in self.evidence for name in fact.withheld)


Stopped = Literal["", "search", "worlds"]
"""What a deadline came in, '' where it came in nothing (``plogic.scene.readings.unfinished``)."""
SEARCH: Stopped = "search"
WORLDS: Stopped = "worlds"


def stopped_in(document: Marks) -> Stopped:
    """What was stopped, '' in a finished interpretation; one that does not say it may lack anything."""
    return document.get("stopped", SEARCH) or SEARCH if document.get("unfinished") else ""


_FINE = {name: name for name in ROC20}
PARTLY = {parts_of(name)[0]: name for name in ROC20 if coarse(name) == "partially_occludes"}
"""RCC-8 of the images → the partial occlusion of that name."""


def pair_facts(
    relation: Roc, x: str, y: str, parts: tuple[str, str] = ("", ""), opaque: tuple[bool, bool] = (True, True)
) -> list[PairFact]:
    """A relation in the vocabulary of queries: ``x`` occluded by ``y`` is said of (y, x).

    What is its own converse when coarse, of both. ``relation`` is that of the outlines and of who is in front; what is
    not ``opaque`` occludes nothing (§3.5-3.7), and where ROC-20 has no name for what is left, none is told.
    """
    word, there, back = coarse(relation), (x, y, relation, parts), (y, x, converse(relation), parts[::-1])
    rcc, front = parts_of(relation)
    hides = front in ("x", "both") and opaque[0], front in ("y", "both") and opaque[1]
    if front != "nobody" and not any(hides):
        return [PairFact("non_occludes", x, y, "", parts), PairFact("non_occludes", y, x, "", parts[::-1])]
    if front == "both" and not all(hides):
        if not hides[0]:
            (x, y), parts, rcc = (y, x), parts[::-1], rcc_converse(rcc)
        return [PairFact("partially_occludes", x, y, PARTLY.get(rcc, ""), parts)]
    if word == coarse_converse(word):
        return [PairFact(word, *there), PairFact(word, *back)]
    if word.endswith("_occluded_by"):
        return [PairFact(coarse_converse(word), *back)]
    return [PairFact(word, *there)]


def both_ways(fact: PairFact) -> tuple[str, ...]:
    """The relation of ROC-20 of (x, y); and of (y, x), where no other fact tells it.

    None where the fact does not tell it.
    """
    if fact.roc not in _FINE:
        return ()
    other = converse(_FINE[fact.roc])
    return (fact.roc,) if coarse(other) == fact.relation else (fact.roc, other)


def names_of(situation: Situation) -> Names:
    """The table of one situation: deterministic, in the order in which the names appear there."""
    wanted = list(_labels(situation))
    taken = {label for label, _ in wanted}
    fresh = {kind: _fresh(kind, taken) for kind in "fn"}
    atoms: dict[str, str] = {}
    for label, kind in wanted:
        if label not in atoms:
            atoms[label] = quoted(label) if is_plain(label) else next(fresh[kind])
    return Names.of(atoms)


def _fresh(kind: str, taken: set[str]) -> Iterator[str]:
    return (atom for i in count(1) if (atom := f"{kind}{i}") not in taken)


def _labels(situation: Situation) -> Iterator[tuple[str, str]]:
    for hypothesis in situation.hypotheses:
        yield from ((label, "n") for label in (hypothesis.id, hypothesis.type, hypothesis.group))
        inner = [(part.id, part.type) for part in hypothesis.parts]
        for name, kind in inner + [(feature.id, feature.type) for feature in hypothesis.features]:
            yield from ((name, "f"), (kind, "n"))
    for name, fact in situation.types.items():
        yield name, "n"
        for path, word in (*fact.features, *((part.id, part.type) for part in fact.parts)):
            yield from ((path, "f"), (word, "n"))
        yield from ((look.type, "n") for look in fact.looks)
    for appearance in situation.appearances:
        yield from ((label, "n") for label in (appearance.id, appearance.type))
    for table in (situation.dv, situation.rank, situation.priors, situation.hit_rates):
        yield from ((label, "n") for label in table)
    for pair in (*situation.relations, *situation.part_relations):
        yield from ((label, "n") for label in (pair.relation, *both_ways(pair)))
    if situation.support is not None:
        yield from ((plane.name, "n") for plane in situation.support.planes)
    if situation.evidence:
        yield from ((label, "n") for label in (*ROC20, *COARSE))
