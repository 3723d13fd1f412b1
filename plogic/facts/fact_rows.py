"""Shapes of facts, ``space``, ``gravity`` and support of ``interpretation/1``, and the plain values of all shapes."""

from typing import Annotated, Literal, NotRequired, TypedDict

from geometry.json_shapes import Range, Row, Size
from plogic.facts.spatial import View

Name = Annotated[str, Size(0, 10_000)]
Chance = Annotated[float, Range(0.0, 1.0)]
Slightly = Annotated[float, Range(-1e-6, 1.0 + 1e-6)]
"""A probability as floating-point sums come to it."""
Positive = Annotated[float, Range(0.0)]
Pixels = Annotated[float, Range(0.0, 1e9)]
Count = Annotated[int, Range(0)]
Point2 = Annotated[list[float], Size(2)]
Point3 = Annotated[list[float], Size(3)]
Interval = Annotated[list[Slightly], Size(2)]
Pair = Annotated[list[Name], Size(2)]


class PairRow(TypedDict):
    """Two hypotheses of which something excludes the one where the other is."""

    fact: Annotated[
        Literal["rival", "exclusive"], "Rivals explain the same data; exclusive ones cannot stand together."
    ]
    args: Annotated[Pair, "The two hypotheses."]


class ExclusionRow(TypedDict):
    """Two hypotheses that share volume, m³, and how deep, m.

    ``depth_interval`` where that is known within bounds only.
    """

    args: Annotated[Pair, "The two hypotheses."]
    volume: NotRequired[Annotated[Positive, "Volume that they share, m³."]]
    depth: NotRequired[Annotated[Positive, "How deep one is in the other, m."]]
    depth_interval: NotRequired[
        Annotated[list[Positive], Size(2), "Bounds of the depth, m, where it is known within bounds only."]
    ]


class OverlapRow(ExclusionRow):
    """The same as a fact."""

    fact: Literal["overlap"]


class FootRow(TypedDict):
    """How high a body begins, m."""

    fact: Literal["foot"]
    args: Annotated[list[Name], Size(1), "The hypothesis."]
    low: Annotated[float, "The least height of its lowest point, m."]
    high: Annotated[float, "The greatest height of its lowest point, m."]


class OrderedRow(TypedDict):
    """The first rests on the second where both are present.

    Or is a feature, ``h1/roof/apex``, and the second is before it.
    """

    fact: Annotated[
        Literal["rests_on", "behind"],
        "The first rests on the second, or the first, a feature, is hidden by the second.",
    ]
    args: Annotated[Pair, "The two hypotheses, or a feature, as `h1/roof/apex`, and the hypothesis that hides it."]


class RelatedRow(TypedDict):
    """A relation of two; ``roc``: that of ROC-20, where it is told."""

    relation: Annotated[Name, "Name of the relation, as in queries (docs/vocabulary.md)."]
    args: Annotated[Pair, "The two hypotheses."]
    roc: NotRequired[Annotated[Name, "The relation of ROC-20 that it is a case of."]]


class RelationFact(RelatedRow):
    """A relation of two hypotheses, decided by outlines and depth."""

    fact: Literal["relation"]


class PartRelationFact(RelatedRow):
    """The same of their parts; '' is the whole."""

    fact: Literal["part_relation"]
    parts: Annotated[Pair, "The parts of the two that are related; an empty text is the whole."]


class StateRow(TypedDict):
    """The relation of ROC-20 of each pair, with the probability that these hold together."""

    probability: Annotated[Slightly, "Chance that these relations hold together."]
    relations: Annotated[list[Name], "The relation of each pair, in the order of `pairs`."]


class EvidenceRow(TypedDict):
    """What detections say of how hypotheses stand; ``withheld``: those of them whose poses are not known."""

    fact: Literal["evidence"]
    pairs: Annotated[list[Pair], "Pairs of hypotheses."]
    withheld: Annotated[list[Name], "Those of them whose poses are not known."]
    states: Annotated[list[StateRow], Size(1, 10_000), "What detections say of how they stand."]


Fact = PairRow | OverlapRow | FootRow | OrderedRow | RelationFact | PartRelationFact | EvidenceRow


class BodyRow(TypedDict):
    """Where one body is: m, camera frame."""

    id: Annotated[Name, "The hypothesis."]
    middle: Annotated[Point3, "Middle of its body, camera frame, m."]
    nearest: Annotated[Positive, "Distance from the camera to its nearest point, m."]
    view: Annotated[View, "Whether the image shows all of it, a part, or nothing."]


class SpaceRow(TypedDict):
    """``plogic.facts.spatial.Space`` without the volumes."""

    up: Annotated[Point3 | None, "Direction of up in the camera frame; null where it is not known."]
    up_from: Annotated[Name, "What told which way is up."]
    bodies: Annotated[list[BodyRow], "Where each body is."]
    gaps: Annotated[
        list[Annotated[list[str | float], Row(Name, Name, Positive)]],
        "Two hypotheses and the distance between them, m.",
    ]
    above: Annotated[list[Pair], "Pairs of which the first is above the second."]
    on: Annotated[list[Pair], "Pairs of which the first stands on the second."]
    on_both: Annotated[list[Annotated[list[Name], Size(3)]], "Triples of which the first stands on both others."]


class GravityRow(TypedDict):
    """``plogic.facts.spatial.Gravity`` without its facts."""

    unknown_support: Annotated[Chance, "Chance that something unknown holds what floats."]
    ground: Annotated[float | None, "Height of the ground, world z, m; null where nobody stated it."]
    silent: NotRequired[Annotated[str, "Why nothing is said of what rests on what."]]


class GravityKey(TypedDict):
    """Of a document, where gravity holds."""

    gravity: NotRequired[Annotated[GravityRow | None, "What rests on what, where gravity holds."]]


class PlaneRow(TypedDict):
    """The plane normal·x = offset."""

    normal: Annotated[Point3, "Unit vector, camera frame, upwards: against gravity."]
    offset: Annotated[float, "normal·x of its points, m: minus the camera's height above it."]


class SupportPlaneRow(TypedDict):
    """One plane that things may stand on."""

    name: Annotated[Name, "Its name: `s1`."]
    plane: Annotated[PlaneRow, "Where it is."]
    covariance: Annotated[
        list[Point3], Size(3), "Of its tilts about the camera's x and y, rad, and of its offset, m: rows of 3."
    ]
    prior: Annotated[Chance, "Its prior share in the one choice of a plane."]
    probability: Annotated[Slightly, "Probability that things stand on it: `support_plane(s1)`."]
    standing: NotRequired[Annotated[dict[Name, Slightly], "Who may stand there, each with its probability."]]


class RestingRow(TypedDict):
    """``plogic.facts.stances.Support`` without its planes and stances."""

    rests: Annotated[Chance, "Chance that a thing rests on another, or on a plane."]
    none: Annotated[Chance, "Prior chance that nothing says where things stand."]


class StandingKeys(TypedDict):
    """Of a document, where things are said to rest."""

    support_planes: NotRequired[Annotated[list[SupportPlaneRow], "The planes that things may stand on."]]
    resting: NotRequired[Annotated[RestingRow, "What is assumed of how things stand."]]


class StanceRow(TypedDict):
    """One way of a hypothesis to stand."""

    on: Annotated[Name, "The plane, or the other hypothesis."]
    face: Annotated[Count, "Which of its type's stable poses it stands in, from 0."]
    chance: Annotated[Chance, "Prior chance of this way, where what it stands on is there."]
    log_ratio: Annotated[float, "Logarithm of how much likelier its pose is where it stands so than where it is free."]
    probability: NotRequired[Annotated[Slightly, "Probability that it is present and stands so."]]


class StancesKeys(TypedDict):
    """Of a hypothesis, where things are said to rest."""

    stances: NotRequired[Annotated[list[StanceRow], "Its ways to stand."]]
    free: NotRequired[Annotated[Slightly, "Probability that it is present and stands on nothing known."]]
    level: NotRequired[
        Annotated[
            dict[Name, float],
            "Logarithm of how much likelier its pose is, where it is free, above each plane: it may rest level above it on "
            "something unknown; 0 where not told.",
        ]
    ]
    stands_by_chance: NotRequired[
        Annotated[
            Chance,
            "Chance that its pose stands as if it were there, where neither it is nor what excludes it; 0 where not told.",
        ]
    ]


class PixelRow(TypedDict):
    """What the photo's pixels say of a hypothesis where these and no others are before it."""

    present: Annotated[list[Name], "Who is present of those that hide some of it."]
    pixels: Annotated[float, "Logarithm of how much likelier the rest of its pixels are with it than without."]


class PixelKeys(TypedDict):
    """What a photo says of a hypothesis; there are no such keys where it was not asked."""

    pixels: NotRequired[
        Annotated[float, "Logarithm of how much likelier its pixels are with it than without, beside what is accepted."]
    ]
    pixels_beside: NotRequired[
        Annotated[
            list[PixelRow], Size(1, 64), "The same by who is present of those before it: a factor of the posterior."
        ]
    ]
    pixels_left_out: NotRequired[
        Annotated[list[Name], "Who else is before it, and is not looked at, since at most six are."]
    ]
    pose_probability: NotRequired[
        Annotated[
            Chance, "P(its pose is within a tenth of its diameter of the true one (ADD), given that it is present)."
        ]
    ]
