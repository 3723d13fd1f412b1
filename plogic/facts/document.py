"""The shapes of ``interpretation/1`` and ``truth/1``: every object of a document, with its keys, types and bounds.

The classes are types of what ``json`` reads and writes: a document is checked against them once, where it is read
(``geometry.json_shapes``), and every function that takes one says which. Keys that older documents lack, and those that
only a writer needs, are not required; the writer tells all of them.
"""

from typing import Annotated, Literal, NotRequired, TypedDict

from geometry.camera import CameraRow, Pose
from geometry.json_shapes import Row, Size
from plogic.facts.fact_rows import (
    Chance,
    Count,
    Fact,
    GravityRow,
    Interval,
    Name,
    Pair,
    Point2,
    Point3,
    Positive,
    RelatedRow,
    Slightly,
    SpaceRow,
)
from plogic.facts.situation import DvOver, Reading, Reconsider, Stopped

Case = Literal["A", "B", "C", "D"]
Status = Literal["accepted", "rival", "open"]


class KBRow(TypedDict):
    """The knowledge base that was perceived with."""

    name: Name
    digest: Name


class AppearanceRow(TypedDict):
    """One datum of Γ; ``clutter`` per pixel²."""

    id: Name
    type: Name
    uv: Point2
    clutter: Positive
    detector: NotRequired[Name]
    angle: NotRequired[float]
    scale: NotRequired[float]
    score: NotRequired[float]
    arms: NotRequired[Annotated[list[float], Size(0, 64)]]
    depth: NotRequired[float]
    depth_sigma: NotRequired[float]


class StandsKey(TypedDict):
    """For how many features one stands, where it is not for itself."""

    stands_for: NotRequired[Count]


class SeenRow(StandsKey):
    """What is told of any feature; ``case`` beside Δi."""

    id: Name
    type: Name
    uv: Point2
    in_image: bool
    in_lobe: bool
    self_hidden: bool
    hidden_by: list[Name]
    match: Name | None
    case: NotRequired[Case | None]


class FeatureRow(SeenRow):
    """One feature of a hypothesis of Δh; ``expected`` and ``detected`` beside Δi."""

    at: Point3
    dv: Positive
    residual: float | None
    density: Positive
    hit_rate: Chance
    expected: NotRequired[bool]
    detected: NotRequired[bool]


class LookedRow(SeenRow):
    """One feature of a rejected hypothesis: to be looked at, nothing is computed from it."""

    expected: bool
    detected: bool
    at: NotRequired[Point3]
    dv: NotRequired[Positive]
    residual: NotRequired[float | None]
    density: NotRequired[Positive]
    hit_rate: NotRequired[Chance]


class PartRow(TypedDict):
    """One node of the part-whole tree."""

    id: Name
    parent: Name
    kind: Literal["object", "feature"]
    type: Name


class Cells(TypedDict):
    """The four cells of §4.2; ``weights`` where visual words of many types are summed up."""

    expected_detected: Count
    expected_missed: Count
    hidden_missed: Count
    hidden_detected: Count
    weights: NotRequired[dict[Name, float]]


class LeftOut(TypedDict):
    """Features of a learned type that are not told one by one."""

    in_image: Count
    outside_image: Count


class Verdict(TypedDict):
    """The keys that the cycle decides, of any hypothesis."""

    left_out: NotRequired[LeftOut]
    why: NotRequired[str]
    ev: NotRequired[float | None]
    p_ev: NotRequired[float | None]
    ev_reconsidered: NotRequired[float | None]
    log_likelihood_ratio: NotRequired[float]
    support: NotRequired[dict[Name, Cells]]
    outline: NotRequired[list[list[Point2]]]
    probability: NotRequired[Slightly]
    interval: NotRequired[Interval]


class PosedRow(TypedDict):
    """What is told of any hypothesis, tried or of Δh."""

    id: Name
    type: Name
    T_camera_object: Pose
    opaque: bool
    parts: list[PartRow]


class HypothesisFacts(PosedRow):
    """One hypothesis of Δh, without its verdict."""

    group: Name
    features: list[FeatureRow]


class ApartKey(TypedDict):
    """A sentence for each hypothesis that A4 keeps out of the worlds of this one, the deepest first, a few."""

    apart: NotRequired[list[str]]


class HypothesisRow(HypothesisFacts, Verdict, ApartKey):
    """One hypothesis of Δh."""

    label: NotRequired[Name]
    status: Status


class RejectedRow(PosedRow, Verdict):
    """One hypothesis that was tried and dropped: told, and no part of Δh."""

    group: None
    features: list[LookedRow]
    label: NotRequired[Name]
    status: Literal["rejected"]


class WorldRow(TypedDict):
    """One possible world; ``causes`` by appearance."""

    probability: Slightly
    present: list[Name]
    causes: NotRequired[dict[Name, Name]]
    interval: NotRequired[Interval]


class RelationRow(RelatedRow):
    """P(a relation holds of two that are both present)."""

    probability: Slightly
    interval: NotRequired[Interval]


class DoubtRow(TypedDict):
    """One prediction of §3.8 that fails; ``evidence``: the relation's probability by what is detected."""

    relation: Name
    args: Pair
    expected: str
    found: str
    why: str
    evidence: NotRequired[Chance]


class SharesRow(TypedDict):
    """P(dv) by feature type; where dv is over the instances in Δ, that over the types of Σo as well (§5.1)."""

    p_dv: NotRequired[dict[Name, float]]
    dv_over: NotRequired[DvOver]
    dv_types: NotRequired[dict[Name, float]]


class MeasuresRow(SharesRow):
    """dv by feature type, rank by object type."""

    dv: dict[Name, float]
    rank: dict[Name, float]


class SensingRow(TypedDict):
    """What holds of the detector."""

    f_ref: float
    match_tolerance: float
    clutter: dict[Name, float]


class TypeRow(TypedDict):
    """How one type is seen: [id, type, x, y, z] of features, and lobes as rows of numbers (``plogic.run.carried``).

    ``facets``, ``faces``: polygons of its surface whose corners are features.
    """

    features: list[Annotated[list[str | float], Row(Name, Name, float, float, float)]]
    looks: list[Name]
    lobes: list[Annotated[list[float], Row(Count, Count, float, float, float, float, float, float, float)]]
    measured: bool
    facets: NotRequired[list[Annotated[list[Name], Size(3)]]]
    faces: NotRequired[list[Annotated[list[Name], Size(3, 1000)]]]
    left_out: NotRequired[dict[Name, Count]]


class ImageRow(TypedDict):
    """The picture, base64; the size is the original's."""

    media_type: Literal["image/png", "image/jpeg"]
    width: Count
    height: Count
    base64: str


class MeshRow(TypedDict):
    """A surface, m, object frame; ``slack``: how far off it may be."""

    vertices: list[Point3]
    triangles: list[Annotated[list[Count], Size(3)]]
    slack: NotRequired[Positive]


class AssetsRow(TypedDict):
    """What is carried along to be looked at."""

    image: NotRequired[ImageRow]
    meshes: NotRequired[dict[Name, MeshRow]]


class StepRow(TypedDict):
    """One step of the trace."""

    step: Count
    event: Name
    hypothesis: Name | None
    type: Name | None
    ev: float | None
    why: str


class Marks(TypedDict):
    """The keys of a document that a deadline left unfinished; a finished one has none of them."""

    unfinished: NotRequired[bool]
    stopped: NotRequired[Stopped]


class Listed(TypedDict):
    """The listed worlds; ``causes_else``: what the cause of an appearance is that none of them names."""

    worlds: NotRequired[list[WorldRow]]
    causes_else: NotRequired[Literal["noise"]]
    unlisted_mass: NotRequired[Interval]


class Interpretation(Marks, Listed):
    """The document ``interpretation/1`` of one image."""

    format: Literal["interpretation/1"]
    reading: Reading
    camera: NotRequired[CameraRow]
    facts: list[Fact]
    sensing: NotRequired[SensingRow]
    types: NotRequired[dict[Name, TypeRow]]
    assets: NotRequired[AssetsRow]
    reconsider: Reconsider
    smoothing: float
    kb: NotRequired[KBRow]
    appearances: Annotated[list[AppearanceRow], Size(0, 1_000_000)]
    hypotheses: list[HypothesisRow | RejectedRow]
    relations: NotRequired[list[RelationRow]]
    doubts: NotRequired[list[DoubtRow]]
    space: NotRequired[SpaceRow | None]
    gravity: NotRequired[GravityRow | None]
    measures: MeasuresRow
    priors: dict[Name, float]
    rules: str
    labels: NotRequired[dict[Name, Name]]
    trace: NotRequired[list[StepRow]]


class TrueRow(TypedDict):
    """One object that truly stands somewhere; its label is null where no knowledge base knows it."""

    label: Name | None
    T_camera_object: Pose
    visible_fraction: NotRequired[Chance]


class TruthRow(TypedDict):
    """``truth/1``, beside a scene; ``complete``: whether every object of a known type is listed."""

    format: Literal["truth/1"]
    objects: list[TrueRow]
    complete: NotRequired[bool]
