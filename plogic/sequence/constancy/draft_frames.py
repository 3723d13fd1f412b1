"""How a draft's features are turned: by the angles of their data, where detectors give some."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.sequence.constancy.sightings import SeenFeature, Sighting

    Floats = NDArray[np.float64]

ANGLE_SIGMA, ASIDE_SIGMA = 0.1, 0.6
"""rad: what a datum's angle is taken to be known by, and how far the x axis is taken to be from at right angles to the
line of sight. Two views from nearly one side hardly tell how far it leans towards them; marks lie on surfaces that face
whoever sees them."""


def feature_frame(feature: SeenFeature) -> Floats:
    """world_from_feature (3, 3): the x axis is what the angles of its data show, z as near to the mean direction to the viewpoints as can be.

    The identity where a datum has no angle.
    """
    if any(sighting.angle is None for sighting in feature.sightings):
        return np.eye(3)
    rows = [_arrow(feature.at, sighting) for sighting in feature.sightings]
    sights, arrows = (np.array([row[i] for row in rows]) for i in range(2))
    middle = sights.mean(axis=0)
    middle /= np.linalg.norm(middle)
    normals = np.cross(sights, arrows)
    known = np.einsum("ni,nj->ij", normals, normals) / ANGLE_SIGMA**2 + np.outer(middle, middle) / ASIDE_SIGMA**2
    x = np.linalg.eigh(known)[1][:, 0]
    x = x if float((arrows @ x).sum()) >= 0.0 else -x
    z = -(middle - (middle @ x) * x)
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _arrow(at: Floats, sighting: Sighting) -> tuple[Floats, Floats]:
    """The line of sight (3,) to the feature, and the direction (3,) across it that has the datum's angle on the screen; unit, world."""
    frame, angle = sighting.world_from_camera[:3, :3], sighting.angle or 0.0
    sight = at - sighting.eye
    sight = sight / np.linalg.norm(sight)
    arrow = frame @ np.array([np.cos(angle), np.sin(angle), 0.0])
    arrow -= (arrow @ sight) * sight
    return sight, arrow / np.linalg.norm(arrow)
