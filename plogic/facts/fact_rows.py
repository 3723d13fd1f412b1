"""Shapes of the facts, ``space`` and ``gravity`` of ``interpretation/1``, and the plain values of all shapes."""

from typing import Annotated, Literal, NotRequired, TypedDict

from geometry.json_shapes import Range, Row, Size
from plogic.facts.spatial import View

Name = Annotated[str, Size(0, 10_000)]
Chance = Annotated[float, Range(0.0, 1.0)]
Slightly = Annotated[float, Range(-1e-6, 1.0 + 1e-6)]
"""A probability as floating-point sums come to it."""
Positive = Annotated[float, Range(0.0)]
Count = Annotated[int, Range(0)]
Point2 = Annotated[list[float], Size(2)]
Point3 = Annotated[list[float], Size(3)]
Interval = Annotated[list[Slightly], Size(2)]
Pair = Annotated[list[Name], Size(2)]


class PairRow(TypedDict):
    """Two hypotheses of which something excludes the one where the other is."""

    fact: Literal["rival", "exclusive"]
    args: Pair


class ExclusionRow(TypedDict):
    """Two hypotheses that share volume, m³, and how deep, m.

    ``depth_interval`` where that is known within bounds only.
    """

    args: Pair
    volume: NotRequired[Positive]
    depth: NotRequired[Positive]
    depth_interval: NotRequired[Annotated[list[Positive], Size(2)]]


class OverlapRow(ExclusionRow):
    """The same as a fact."""

    fact: Literal["overlap"]


class FootRow(TypedDict):
    """How high a body begins, m."""

    fact: Literal["foot"]
    args: Annotated[list[Name], Size(1)]
    low: float
    high: float


class OrderedRow(TypedDict):
    """The first rests on the second where both are present.

    Or is a feature, ``h1/roof/apex``, and the second is before it.
    """

    fact: Literal["rests_on", "behind"]
    args: Pair


class RelatedRow(TypedDict):
    """A relation of two; ``roc``: that of ROC-20, where it is told."""

    relation: Name
    args: Pair
    roc: NotRequired[Name]


class RelationFact(RelatedRow):
    """A relation of two hypotheses, decided by outlines and depth."""

    fact: Literal["relation"]


class PartRelationFact(RelatedRow):
    """The same of their parts; '' is the whole."""

    fact: Literal["part_relation"]
    parts: Pair


class StateRow(TypedDict):
    """The relation of ROC-20 of each pair, with the probability that these hold together."""

    probability: Slightly
    relations: list[Name]


class EvidenceRow(TypedDict):
    """What detections say of how hypotheses stand; ``withheld``: those of them whose poses are not known."""

    fact: Literal["evidence"]
    pairs: list[Pair]
    withheld: list[Name]
    states: Annotated[list[StateRow], Size(1, 10_000)]


Fact = PairRow | OverlapRow | FootRow | OrderedRow | RelationFact | PartRelationFact | EvidenceRow


class BodyRow(TypedDict):
    """Where one body is: m, camera frame."""

    id: Name
    middle: Point3
    nearest: Positive
    view: View


class SpaceRow(TypedDict):
    """``plogic.facts.spatial.Space`` without the volumes."""

    up: Point3 | None
    up_from: Name
    bodies: list[BodyRow]
    gaps: list[Annotated[list[str | float], Row(Name, Name, Positive)]]
    above: list[Pair]
    on: list[Pair]
    on_both: list[Annotated[list[Name], Size(3)]]


class GravityRow(TypedDict):
    """``plogic.facts.spatial.Gravity`` without its facts."""

    unknown_support: Chance
    ground: float | None
    silent: NotRequired[str]


class GravityKey(TypedDict):
    """Of a document, where gravity holds."""

    gravity: NotRequired[GravityRow | None]
