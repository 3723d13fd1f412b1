"""How much of a posed surface is seen: the part of its image in front of which nothing stands."""

from collections.abc import Sequence

import numpy as np

from geometry.camera import Camera
from geometry.visibility.occlusion import PosedSurface
from geometry.visibility.outline import outline
from geometry.visibility.samples import even_grid


def visible_fraction(surface: PosedSurface, others: Sequence[PosedSurface], camera: Camera, count: int = 2000) -> float:
    """The part in [0, 1] of the surface's whole image that lies in the picture and in front of all `others`.

    Taken on an even grid of about `count` points over the image in pixels; 0.0 for a surface without an image.
    """
    area = outline(surface.vertices, surface.triangles, surface.camera_from_object, camera)
    if area.is_empty or area.area == 0:
        return 0.0
    uv = even_grid(area, count)
    rays = camera.rays(uv)
    own = surface.depth(rays)
    hit = np.isfinite(own)
    seen = hit & camera.contains(uv)
    for other in others:
        seen &= ~(other.depth(rays) < own)
    return float(seen.sum() / hit.sum()) if hit.any() else 0.0
