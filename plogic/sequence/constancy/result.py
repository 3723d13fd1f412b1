"""What constancy came to, and how it is written.

Vocabulary, each with an example value:

* ``PhysicalFeature("u1/f1", "patch", at, 0.003, 0.97, {"v1": "a3", "v2": "a9"})``
* ``UnknownObject("u1", 0.98, features)``
* ``Constancy(unknown, noise={"v1": ("a4",)}, undecided={"v1": ("a7",)})``
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from geometry.arrays import Floats, frozen

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from plogic.sequence.document import ConstancyRow, PhysicalFeatureRow
    from plogic.sequence.views.view import View


@dataclass(frozen=True, eq=False)
class PhysicalFeature:
    """One place that looks alike from several views: its appearances' ``type``, ``at`` (3,) m, world, and its ``data``, by view.

    ``sigma`` m: the standard deviation in the direction that is known worst; ``probability``: that it is physical.
    """

    id: str
    type: str
    at: Floats
    sigma: float
    probability: float
    data: Mapping[str, str]

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", frozen(self.at))


@dataclass(frozen=True, eq=False)
class UnknownObject:
    """A cluster of physical features that no type of Σo explains.

    ``probability``: that one of them at least is physical.
    """

    id: str
    probability: float
    features: tuple[PhysicalFeature, ...]


@dataclass(frozen=True, eq=False)
class Constancy:
    """What case D was (§4.4). ``noise`` and ``undecided``: the ids of the rest, by view, in the order of Γ."""

    unknown: tuple[UnknownObject, ...]
    noise: Mapping[str, tuple[str, ...]]
    undecided: Mapping[str, tuple[str, ...]]


def constancy_document(constancy: Constancy) -> ConstancyRow:
    """The keys ``unknown``, ``noise`` and ``undecided`` of a ``panorama/1``."""
    return {
        "unknown": [
            {"id": one.id, "probability": one.probability, "features": [_feature(feature) for feature in one.features]}
            for one in constancy.unknown
        ],
        "noise": {view: list(ids) for view, ids in constancy.noise.items()},
        "undecided": {view: list(ids) for view, ids in constancy.undecided.items()},
    }


def _feature(feature: PhysicalFeature) -> PhysicalFeatureRow:
    return {
        "id": feature.id,
        "type": feature.type,
        "at": feature.at.tolist(),
        "sigma": feature.sigma,
        "probability": feature.probability,
        "data": dict(feature.data),
    }


@dataclass(frozen=True, eq=False)
class Sighting:
    """From where a feature was seen: ``world_from_camera`` (4, 4), the camera's focal length in pixels, the datum's angle on the screen, rad."""

    world_from_camera: Floats
    focal: float
    angle: float | None = None

    @property
    def eye(self) -> Floats:
        """(3,) m, world."""
        return self.world_from_camera[:3, 3]


@dataclass(frozen=True, eq=False)
class SeenFeature:
    """What it looks like, ``at`` (3,) m in the world, and who saw it."""

    type: str
    at: Floats
    sightings: tuple[Sighting, ...]


def seen_features(unknown: UnknownObject, views: Sequence[View]) -> tuple[SeenFeature, ...]:
    """Of an unknown object, with the views that its data are of."""
    by_id = {view.id: view for view in views}
    angles = {view.id: {a.id: a.angle for a in view.gamma.appearances} for view in views}
    return tuple(
        SeenFeature(
            feature.type,
            feature.at,
            tuple(
                Sighting(by_id[view].world_from_camera, by_id[view].gamma.camera.f, angles[view][datum])
                for view, datum in feature.data.items()
            ),
        )
        for feature in unknown.features
    )
