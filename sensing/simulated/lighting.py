"""How bright each facet is: one lamp far away, the sky, and a little from everywhere.

TinyRenderer knows one lamp, so two facets turned away from it look alike. The brightness is therefore computed here,
per facet, and given to TinyRenderer as a normal whose cosine with its lamp is that brightness.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sensing.simulated.body import Body


@dataclass(frozen=True)
class Light:
    """A lamp's direction (world frame, towards it, any length) and the shares of the whole brightness, each in [0, 1].

    ``lamp`` · max(0, n·l) + ``sky`` · (1 + n_z)/2 + ``back`` · max(0, −n·l′) + ``ambient``, where l′ is l's horizontal
    part turned by 60°: what a wall in the shade gets back from its surroundings, so that two such walls differ.
    """

    direction: tuple[float, float, float] = (0.4, -0.5, 0.8)
    ambient: float = 0.30
    lamp: float = 0.45
    sky: float = 0.15
    back: float = 0.10

    @property
    def unit(self) -> NDArray[np.float64]:
        """(3,) unit vector towards the lamp, world frame."""
        d = np.asarray(self.direction, dtype=np.float64)
        return d / np.linalg.norm(d)


def brightness(normals_world: NDArray[np.float64], light: Light) -> NDArray[np.float64]:
    """(T,) brightness in [0, 1] of facets with (T, 3) unit outward normals in the world frame."""
    lamp = light.unit
    cos, sin = 0.5, np.sqrt(0.75)
    turned = np.array([cos * lamp[0] - sin * lamp[1], sin * lamp[0] + cos * lamp[1], 0.0])
    direct = light.lamp * np.maximum(normals_world @ lamp, 0)
    sky = light.sky * (1 + normals_world[:, 2]) / 2
    back = light.back * np.maximum(-normals_world @ turned, 0)
    return np.clip(light.ambient + direct + sky + back, 0, 1)


def shading_normals(body: Body, light: Light) -> NDArray[np.float64]:
    """(T, 3) unit vectors in the body frame whose cosine with the lamp is the facet's brightness."""
    R = body.world_from_body[:3, :3]
    shade = brightness(body.mesh.normals @ R.T, light)[:, None]
    lamp = light.unit
    across = np.cross(lamp, [1.0, 0, 0] if abs(lamp[0]) < 0.9 else [0, 1.0, 0])
    across /= np.linalg.norm(across)
    normals: NDArray[np.float64] = (shade * lamp + np.sqrt(1 - shade**2) * across) @ R
    return normals
