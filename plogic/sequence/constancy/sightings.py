"""Who saw what of an unknown object: what a draft of its type is made of.

Vocabulary, each with an example value:

* ``Sighting``, one datum of a feature: ``Sighting(world_from_camera, 600.0, angle)``
* ``SeenFeature``, a physical feature with its sightings: ``SeenFeature("patch", at, (s1, s2))``
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from plogic.sequence.constancy.result import UnknownObject
    from plogic.sequence.views.view import View

    Floats = NDArray[np.float64]


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
