"""The shape of ``panorama/1``.

A sequence of views, each with its interpretation, and what stands in the world after all of them.
"""

from typing import Annotated, Literal, NotRequired, TypedDict

from geometry.camera import Pose
from geometry.json_shapes import Size
from plogic.facts.document import Interpretation, KBRow, Marks, WorldRow
from plogic.facts.fact_rows import Chance, Count, Interval, Name, Pair, Point3, Positive, Slightly
from plogic.facts.situation import Reading


class ExpectedRow(TypedDict):
    """One object of Δp that is led to be expected in a view."""

    id: Name
    type: Name
    T_camera_object: Pose
    expected_features: Count
    expected_detections: Positive


class ViewRow(TypedDict):
    """One view: its interpretation, what was expected there, what is gone, and the data that nobody explains."""

    id: Name
    frame: Name
    T_world_camera: Pose
    predicted: list[ExpectedRow]
    gone: list[Name]
    unexplained: list[Name]
    interpretation: Interpretation


class ObjectRow(TypedDict):
    """One object of Δp; ``hypotheses``: which hypothesis of a view's interpretation it was."""

    id: Name
    type: Name
    T_world_object: Pose
    probability: Slightly
    age: Count
    last_seen: Name
    in_view: bool
    hypotheses: dict[Name, Name]
    interval: NotRequired[Interval]


class PhysicalFeatureRow(TypedDict):
    """One place that looks alike from several views; ``data`` by view."""

    id: Name
    type: Name
    at: Point3
    sigma: Positive
    probability: Chance
    data: dict[Name, Name]


class UnknownRow(TypedDict):
    """A cluster of physical features that no type explains."""

    id: Name
    probability: Chance
    features: list[PhysicalFeatureRow]


class ConstancyRow(TypedDict):
    """What case D was (§4.4); ids of data by view."""

    unknown: NotRequired[list[UnknownRow]]
    noise: NotRequired[dict[Name, list[Name]]]
    undecided: NotRequired[dict[Name, list[Name]]]


class StandingRow(TypedDict):
    """One hypothesis of the last views together: an object of Δp, or a rival of one."""

    id: Name
    type: Name
    opaque: bool
    T_world_object: Pose
    probability: Slightly
    interval: NotRequired[Interval]


class Joined(Marks):
    """The possible worlds of the last views together."""

    hypotheses: list[StandingRow]
    rivals: list[Pair]
    worlds: list[WorldRow]
    unlisted_mass: Interval


class AheadRow(TypedDict):
    """What will be seen from a place where nothing was seen yet."""

    T_world_camera: Pose
    predicted: list[ExpectedRow]


class Panorama(ConstancyRow, Joined):
    """The document ``panorama/1``."""

    format: Literal["panorama/1"]
    kb: KBRow
    reading: Reading
    views: Annotated[list[ViewRow], Size(0, 100_000)]
    objects: list[ObjectRow]
    ahead: NotRequired[list[AheadRow]]
