"""The shapes of ``interpretation/1`` and ``truth/1``: every object of a document, with its keys, types and bounds.

The classes are types of what ``json`` reads and writes: a document is checked against them once, where it is read
(``geometry.json_checks``), and every function that takes one says which. Keys that older documents lack, and those that
only a writer needs, are not required; the writer tells all of them.
"""

from typing import Annotated, Literal, NotRequired, TypedDict

from geometry.camera_row import CameraRow, Pose
from geometry.json_shapes import Range, Size
from plogic.facts.carried_rows import AssetsRow, TypeRow
from plogic.facts.fact_rows import (
    Chance,
    Count,
    Fact,
    GravityRow,
    Interval,
    Name,
    Pair,
    PixelKeys,
    Pixels,
    Point2,
    Point3,
    Positive,
    RelatedRow,
    Slightly,
    SpaceRow,
    StancesKeys,
    StandingKeys,
)
from plogic.facts.situation import DvOver, Reading, Reconsider, Stopped

Case = Literal["A", "B", "C", "D"]
Status = Literal["accepted", "rival", "open"]


class KBRow(TypedDict):
    """The knowledge base that was perceived with."""

    name: Annotated[Name, "Its name."]
    digest: Annotated[Name, "SHA-256 of its files."]


class AppearanceRow(TypedDict):
    """One datum of Γ; ``clutter`` per pixel²."""

    id: Annotated[Name, "Its name."]
    type: Annotated[Name, "Its appearance type."]
    uv: Annotated[Point2, "Its place in the image, pixels."]
    clutter: Annotated[Positive, "Rate of noise of this type, per pixel²."]
    detector: NotRequired[Annotated[Name, "What reported it."]]
    angle: NotRequired[Annotated[float, "Its direction on the screen, radians, clockwise from +x."]]
    scale: NotRequired[Annotated[float, "Its diameter, pixels."]]
    score: NotRequired[Annotated[float, "The detector's confidence."]]
    arms: NotRequired[Annotated[list[float], Size(0, 64), "Directions of the edges that meet there; as `angle`."]]
    depth: NotRequired[Annotated[float, "Its depth along the camera's z axis, m."]]
    depth_sigma: NotRequired[Annotated[float, "The standard deviation of the depth, m."]]


class StandsKey(TypedDict):
    """For how many features one stands, where it is not for itself."""

    stands_for: NotRequired[Annotated[Count, "For how many features this one stands, itself among them."]]


class LearnedKey(TypedDict):
    """How often a feature of a learned type was found when it was learned."""

    learned_rate: NotRequired[Annotated[Chance, "How often it was found, from there, when its type was learned."]]


class SeenRow(StandsKey, LearnedKey):
    """What is told of any feature; ``case`` beside Δi."""

    id: Annotated[Name, "The feature's name, with the parts that it is in: `roof/apex`."]
    type: Annotated[Name, "Its feature type."]
    uv: Annotated[
        Point2 | None,
        "Its predicted place in the image, pixels; null: it has none, behind the camera or past the lens' fold.",
    ]
    in_image: Annotated[bool, "Whether that lies in the image."]
    in_lobe: Annotated[bool, "Whether the camera is where the feature can be seen from."]
    self_hidden: Annotated[bool, "Whether its own object hides it."]
    hidden_by: Annotated[list[Name], "The hypotheses that hide it."]
    match: Annotated[Name | None, "The appearance that it is matched with; null: none."]
    case: NotRequired[
        Annotated[
            Case | None,
            "A: expected and detected, B: neither, C: missed, D: detected alone.",
        ]
    ]


class FeatureRow(SeenRow):
    """One feature of a hypothesis of Δh; ``expected`` and ``detected`` beside Δi."""

    at: Annotated[Point3, "Its place in the camera's frame, m."]
    dv: Annotated[Positive, "Distinctiveness of its type."]
    residual: Annotated[float | None, "Distance from its predicted place to its match, pixels; null: no match."]
    density: Annotated[Positive, "Density of a match at that distance, per pixel²."]
    hit_rate: Annotated[Chance, "Chance that it is detected where it is expected."]
    expected: NotRequired[Annotated[bool, "Whether it is expected beside the accepted hypotheses."]]
    detected: NotRequired[Annotated[bool, "Whether it is detected."]]


class LookedRow(SeenRow):
    """One feature of a rejected hypothesis: to be looked at, nothing is computed from it."""

    expected: Annotated[bool, "Whether it was expected."]
    detected: Annotated[bool, "Whether it was detected."]
    at: NotRequired[Annotated[Point3, "Its place in the camera's frame, m."]]
    dv: NotRequired[Annotated[Positive, "Distinctiveness of its type."]]
    residual: NotRequired[
        Annotated[float | None, "Distance from its predicted place to its match, pixels; null: no match."]
    ]
    density: NotRequired[Annotated[Positive, "Density of a match at that distance, per pixel²."]]
    hit_rate: NotRequired[Annotated[Chance, "Chance that it is detected where it is expected."]]


class PartRow(TypedDict):
    """One node of the part-whole tree."""

    id: Annotated[Name, "Its name within the object."]
    parent: Annotated[Name, "The node that it is a part of; an empty text is the object."]
    kind: Annotated[Literal["object", "feature"], "Whether it is an object or a feature."]
    type: Annotated[Name, "Its type."]


class Cells(TypedDict):
    """The four cells of §4.2; ``weights`` where visual words of many types are summed up."""

    expected_detected: Annotated[Count, "Features that are expected and detected."]
    expected_missed: Annotated[Count, "Features that are expected and missed."]
    hidden_missed: Annotated[Count, "Features that are neither expected nor detected."]
    hidden_detected: Annotated[Count, "Features that are detected though not expected."]
    weights: NotRequired[
        Annotated[dict[Name, float], "Weights of the cells, where visual words of many types are summed up."]
    ]


class LeftOut(TypedDict):
    """Features of a learned type that are not told one by one."""

    in_image: Annotated[Count, "Features in the image that are not told one by one."]
    outside_image: Annotated[Count, "Features outside of it."]


class Verdict(PixelKeys):
    """The keys that the cycle decides, of any hypothesis."""

    left_out: NotRequired[Annotated[LeftOut, "Features of a learned type that are not told one by one."]]
    why: NotRequired[Annotated[str, "Why it was decided so."]]
    ev: NotRequired[Annotated[float | None, "Explanatory value, from -1 to 1."]]
    p_ev: NotRequired[Annotated[float | None, "P(ev), from 0 to 1."]]
    ev_reconsidered: NotRequired[Annotated[float | None, "The explanatory value beside the accepted hypotheses."]]
    log_likelihood_ratio: NotRequired[
        Annotated[float, "Natural logarithm of how many times more probable the data are with it than without."]
    ]
    support: NotRequired[Annotated[dict[Name, Cells], "The four cells by feature type."]]
    outline: NotRequired[
        Annotated[list[Annotated[list[Point2], Size(1, 1_000_000)]], "Polygons of its outline, pixels."]
    ]
    probability: NotRequired[Annotated[Slightly, "Probability that it is present."]]
    interval: NotRequired[Annotated[Interval, "Bounds of the probability, where a deadline left something open."]]


class PosedRow(TypedDict):
    """What is told of any hypothesis, tried or of Δh."""

    id: Annotated[Name, "Its name: `h1`."]
    type: Annotated[Name, "Its object type."]
    T_camera_object: Annotated[Pose, "Its pose: maps object coordinates to the camera's; row-major, metres."]
    opaque: Annotated[bool, "Whether it hides what is behind it."]
    parts: Annotated[list[PartRow], "The nodes of its part-whole tree."]


class HypothesisFacts(PosedRow):
    """One hypothesis of Δh, without its verdict."""

    group: Annotated[Name, "Hypotheses of one group are rivals for the same data."]
    features: Annotated[list[FeatureRow], "Its features."]


class ApartKey(TypedDict):
    """A sentence for each hypothesis that A4 keeps out of the worlds of this one, the deepest first, a few."""

    apart: NotRequired[Annotated[list[str], "Sentences on the hypotheses that cannot stand where it stands."]]


class HypothesisRow(HypothesisFacts, Verdict, ApartKey, StancesKeys):
    """One hypothesis of Δh."""

    label: NotRequired[Annotated[Name, "The author's name of the type, where the atom is another."]]
    status: Annotated[Status, "What the search decided."]


class RejectedRow(PosedRow, Verdict):
    """One hypothesis that was tried and dropped: told, and no part of Δh."""

    group: Annotated[None, "None: it is in no world."]
    features: Annotated[list[LookedRow], "Its features, to be looked at."]
    label: NotRequired[Annotated[Name, "The author's name of the type, where the atom is another."]]
    status: Literal["rejected"]


class WorldRow(TypedDict):
    """One possible world; ``causes`` by appearance, ``support`` and ``stances`` where things are said to rest."""

    probability: Annotated[Slightly, "Probability of the world."]
    present: Annotated[list[Name], "The hypotheses that are present in it."]
    causes: NotRequired[
        Annotated[dict[Name, Name], "The cause of each appearance: a feature, `noise`, or an unknown object."]
    ]
    support: NotRequired[
        Annotated[Name, "What things stand on: a plane; `none`, nothing says where; `other`, a plane without a name."]
    ]
    stances: NotRequired[
        Annotated[dict[Name, Name], "How each hypothesis stands: `s1/2`, on s1 in stable pose 2; `h1/0`; or `free`."]
    ]
    interval: NotRequired[Annotated[Interval, "Bounds of the probability, where a deadline left something open."]]


class RelationRow(RelatedRow):
    """P(a relation holds of two that are both present)."""

    probability: Annotated[Slightly, "Probability that it holds."]
    interval: NotRequired[Annotated[Interval, "Bounds of the probability, where a deadline left something open."]]


class DoubtRow(TypedDict):
    """One prediction of §3.8 that fails; ``evidence``: the relation's probability by what is detected."""

    relation: Annotated[Name, "Name of the relation."]
    args: Annotated[Pair, "The two hypotheses."]
    expected: Annotated[str, "What was predicted."]
    found: Annotated[str, "What was found."]
    why: Annotated[str, "Why that is in doubt."]
    evidence: NotRequired[Annotated[Chance, "Probability of the relation by what is detected."]]


class CameraDoubtRow(TypedDict):
    """That the accepted objects fit another focal length than the camera's, in pixels."""

    focal: Annotated[float, "The focal length that they fit."]
    standard_error: Annotated[float, "Its standard error."]
    stated: Annotated[float, "The camera's."]
    why: Annotated[str, "The same in words."]


class SharesRow(TypedDict):
    """P(dv) by feature type; where dv is over the instances in Δ, that over the types of Σo as well (§5.1)."""

    p_dv: NotRequired[Annotated[dict[Name, Positive], "P(dv) by feature type."]]
    dv_over: NotRequired[Annotated[DvOver, "What distinctiveness is counted over."]]
    dv_types: NotRequired[
        Annotated[dict[Name, Positive], "Distinctiveness over the types of the KB, where it is counted over instances."]
    ]


class MeasuresRow(SharesRow):
    """dv by feature type, rank by object type."""

    dv: Annotated[dict[Name, Positive], "Distinctiveness by feature type."]
    rank: Annotated[dict[Name, Positive], "Rank by object type."]


class SensingRow(TypedDict):
    """What holds of the detector."""

    f_ref: Annotated[float, Range(1e-6, 1e9), "Focal length that the lobes' ranges hold for, pixels."]
    match_tolerance: Annotated[Pixels, "How far from its predicted place a feature may be found, pixels."]
    clutter: Annotated[dict[Name, Positive], "Appearances of noise per image, by appearance type."]


class StepRow(TypedDict):
    """One step of the trace."""

    step: Annotated[Count, "Its number."]
    event: Annotated[Name, "What happened."]
    hypothesis: Annotated[Name | None, "The hypothesis that it is about."]
    type: Annotated[Name | None, "The object type that it is about."]
    ev: Annotated[float | None, "Explanatory value of the hypothesis."]
    why: Annotated[str, "Why it happened."]


class MomentRow(TypedDict):
    """Which frame of a stream it is."""

    input: Annotated[str, "The stream as it was named."]
    number: Annotated[Count, "The frame's number in the stream; the first is 0."]
    seconds: Annotated[
        float | None,
        "When it is shown, or was taken, after the first one; null for pictures of a pipe, which do not tell.",
    ]
    skipped: Annotated[Count, "Frames just before it that were left out since newer ones had come."]


class Marks(TypedDict):
    """The keys of a document that a deadline left unfinished; a finished one has none of them."""

    unfinished: NotRequired[Annotated[bool, "True where a deadline left something open."]]
    stopped: NotRequired[
        Annotated[Stopped, "What the deadline stopped: the search for hypotheses, or the ranking of worlds."]
    ]


class Listed(TypedDict):
    """The listed worlds; ``causes_else``: what the cause of an appearance is that none of them names."""

    worlds: NotRequired[Annotated[list[WorldRow], "The most probable worlds, best first."]]
    causes_else: NotRequired[
        Annotated[Literal["noise"], "The cause of each appearance that a world's causes do not name."]
    ]
    unlisted_mass: NotRequired[Annotated[Interval, "Bounds of the probability of all worlds that are not listed."]]


class UnweighedKey(TypedDict):
    """What is left out of the worlds; it is there where something is."""

    unweighed: NotRequired[
        Annotated[
            dict[Name, Count], "By accepted hypothesis, how many of its rivals are in no world: too many to weigh."
        ]
    ]


class Interpretation(Marks, Listed, StandingKeys, UnweighedKey):
    """The document ``interpretation/1`` of one image."""

    format: Literal["interpretation/1"]
    moment: NotRequired[Annotated[MomentRow, "Which frame it is of, where `watch` wrote it."]]
    reading: Annotated[Reading, "How probabilities are read: as scores or as a posterior."]
    camera: NotRequired[Annotated[CameraRow, "The camera of the image."]]
    facts: Annotated[list[Fact], "What holds between hypotheses."]
    sensing: NotRequired[Annotated[SensingRow, "What holds of the detectors."]]
    types: NotRequired[Annotated[dict[Name, TypeRow], "How each object type is seen."]]
    assets: NotRequired[Annotated[AssetsRow, "What is carried along to be looked at."]]
    reconsider: Annotated[Reconsider, "What becomes of a feature that an accepted hypothesis hides."]
    smoothing: Annotated[float, "Added to each count before P(ev)."]
    kb: NotRequired[Annotated[KBRow, "The knowledge base that was perceived with."]]
    appearances: Annotated[list[AppearanceRow], Size(0, 1_000_000), "What was detected."]
    hypotheses: Annotated[list[HypothesisRow | RejectedRow], "What may be there, and what was tried and dropped."]
    relations: NotRequired[Annotated[list[RelationRow], "Relations of two hypotheses, each with its probability."]]
    doubts: NotRequired[Annotated[list[DoubtRow], "Predictions that fail."]]
    camera_doubt: NotRequired[Annotated[CameraDoubtRow, "That they contradict the camera; left out where they do not."]]
    space: NotRequired[Annotated[SpaceRow | None, "Where bodies are and what is above, on and beside what."]]
    gravity: NotRequired[Annotated[GravityRow | None, "What is assumed of gravity; null: nothing."]]
    measures: Annotated[MeasuresRow, "Measures of the types."]
    priors: Annotated[dict[Name, float], "Prior of an instance, by object type."]
    rules: Annotated[str, "The KB's own rules, ProbLog."]
    labels: NotRequired[Annotated[dict[Name, Name], "The author's name of each name that is no atom."]]
    trace: NotRequired[Annotated[list[StepRow], "The steps of the search."]]


class TrueRow(TypedDict):
    """One object that truly stands somewhere; its label is null where no knowledge base knows it."""

    label: Annotated[Name | None, "The object's type; null: the KB does not know it."]
    T_camera_object: Annotated[Pose, "Where it stands: maps object coordinates to the camera's; row-major, metres."]
    visible_fraction: NotRequired[Annotated[Chance, "Share of its picture that nothing hides; 1."]]


class TruthRow(TypedDict):
    """``truth/1``, beside a scene; ``complete``: whether every object of a known type is listed."""

    format: Literal["truth/1"]
    objects: Annotated[list[TrueRow], "The objects."]
    complete: NotRequired[Annotated[bool, "Whether every object of a known type is listed; true."]]
    causes: NotRequired[
        Annotated[dict[str, str], "What each datum of Γ is of: `0/roof/apex` of the first of objects, or `noise`."]
    ]
