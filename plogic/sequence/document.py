"""The shape of ``panorama/1``.

A sequence of views, each with its interpretation, and what stands in the world after all of them.
"""

from typing import Annotated, Literal, NotRequired, TypedDict

from geometry.camera_row import Pose
from geometry.json_shapes import Size
from plogic.facts.document import Interpretation, KBRow, Marks, WorldRow
from plogic.facts.fact_rows import Chance, Count, Interval, Name, Pair, Point3, Positive, Slightly
from plogic.facts.situation import Reading


class ExpectedRow(TypedDict):
    """One object of Δp that is led to be expected in a view."""

    id: Annotated[Name, "The object: `p1`."]
    type: Annotated[Name, "Its object type."]
    T_camera_object: Annotated[Pose, "Where it should be: maps object coordinates to the camera's; row-major, metres."]
    expected_features: Annotated[Count, "Features that should be seen."]
    expected_detections: Annotated[Positive, "How many of them should be detected."]


class ViewRow(TypedDict):
    """One view: its interpretation, what was expected there, what is gone, and the data that nobody explains."""

    id: Annotated[Name, "Its name: `v1`."]
    frame: Annotated[Name, "The file that it is of."]
    T_world_camera: Annotated[Pose, "Where the camera stood: maps its coordinates to the world's; row-major, metres."]
    predicted: Annotated[list[ExpectedRow], "What was expected there."]
    gone: Annotated[list[Name], "Objects that were expected and are not there."]
    unexplained: Annotated[list[Name], "Appearances that no hypothesis explains."]
    interpretation: Annotated[Interpretation, "The view alone."]


class ObjectRow(TypedDict):
    """One object of Δp; ``hypotheses``: which hypothesis of a view's interpretation it was."""

    id: Annotated[Name, "Its name: `p1`."]
    type: Annotated[Name, "Its object type."]
    T_world_object: Annotated[Pose, "Its pose: maps object coordinates to the world's; row-major, metres."]
    probability: Annotated[Slightly, "Probability that it is there."]
    age: Annotated[Count, "Views since it was last in view."]
    last_seen: Annotated[Name, "The view that last saw it."]
    in_view: Annotated[bool, "Whether the last view should show it."]
    hypotheses: Annotated[dict[Name, Name], "Which hypothesis it was, by view."]
    interval: NotRequired[Annotated[Interval, "Bounds of the probability, where a deadline left something open."]]


class PhysicalFeatureRow(TypedDict):
    """One place that looks alike from several views; ``data`` by view."""

    id: Annotated[Name, "Its name: `u1/f1`."]
    type: Annotated[Name, "Its appearance type."]
    at: Annotated[Point3, "Its place in the world, m."]
    sigma: Annotated[Positive, "Standard deviation of the place, m."]
    probability: Annotated[Chance, "Probability that it is a thing and no noise."]
    data: Annotated[dict[Name, Name], "The appearance that it is, by view."]


class UnknownRow(TypedDict):
    """A cluster of physical features that no type explains."""

    id: Annotated[Name, "Its name: `u1`."]
    probability: Annotated[Chance, "Probability that it is there."]
    features: Annotated[list[PhysicalFeatureRow], "Its features."]


class ConstancyRow(TypedDict):
    """What case D was (§4.4); ids of data by view."""

    unknown: NotRequired[Annotated[list[UnknownRow], "Clusters of features that no type explains."]]
    noise: NotRequired[Annotated[dict[Name, list[Name]], "Appearances that are noise, by view."]]
    undecided: NotRequired[Annotated[dict[Name, list[Name]], "Appearances that may be either, by view."]]


class StandingRow(TypedDict):
    """One hypothesis of the last views together: an object of Δp, or a rival of one."""

    id: Annotated[Name, "Its name."]
    type: Annotated[Name, "Its object type."]
    opaque: Annotated[bool, "Whether it hides what is behind it."]
    T_world_object: Annotated[Pose, "Its pose: maps object coordinates to the world's; row-major, metres."]
    probability: Annotated[Slightly, "Probability that it is there."]
    interval: NotRequired[Annotated[Interval, "Bounds of the probability, where a deadline left something open."]]


class Joined(Marks):
    """The possible worlds of the last views together."""

    hypotheses: Annotated[list[StandingRow], "What may stand there."]
    rivals: Annotated[list[Pair], "Pairs of which only one can be there."]
    worlds: Annotated[list[WorldRow], "The most probable worlds of all views, best first."]
    unlisted_mass: Annotated[Interval, "Bounds of the probability of all worlds that are not listed."]


class AheadRow(TypedDict):
    """What will be seen from a place where nothing was seen yet."""

    T_world_camera: Annotated[Pose, "The place: maps camera coordinates to the world's; row-major, metres."]
    predicted: Annotated[list[ExpectedRow], "What will be seen from there."]


class Panorama(ConstancyRow, Joined):
    """The document ``panorama/1``."""

    format: Literal["panorama/1"]
    kb: Annotated[KBRow, "The knowledge base that was perceived with."]
    reading: Annotated[Reading, "How probabilities are read: as scores or as a posterior."]
    views: Annotated[list[ViewRow], Size(0, 100_000), "The views, in their order."]
    objects: Annotated[list[ObjectRow], "What stands in the world after the last view."]
    ahead: NotRequired[Annotated[list[AheadRow], "What will be seen from places where nothing was seen yet."]]
