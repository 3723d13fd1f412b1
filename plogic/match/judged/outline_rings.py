"""The outline of a posed hypothesis as plain rings of pixels: the evidence area (§4.3) is this, widened by the match tolerance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.visibility.outline import outline

if TYPE_CHECKING:
    from geometry.camera import Camera
    from plogic.facts.hypothesis import Hypothesis


def outline_rings(posed: Hypothesis, camera: Camera) -> list[list[list[float]]]:
    """Exterior rings of the projected outline, pixels to two decimals; empty for a type without a surface."""
    surface = posed.object_type.surface
    if surface is None:
        return []
    shape = outline(surface.vertices, surface.triangles, posed.camera_from_object, camera)
    polygons = getattr(shape, "geoms", [shape])
    return [np.round(np.array(p.exterior.coords), 2).tolist() for p in polygons if not p.is_empty]
