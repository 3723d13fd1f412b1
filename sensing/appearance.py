"""The data types of Γ (§1, §4): what a detector reports of one image.

Vocabulary, each with an example value:

* ``Appearance``: one datum, ``Appearance(id="a1", type="y_junction", uv=(312.4, 201.9), detector="junction",
  angle=0.3)``
* ``Gamma``: all data of one view, ``Gamma(camera=Camera(640, 480, K, ...), appearances=(a1, a2))``

Outlines are not in Γ, and nothing here knows an object type.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera

MAX_APPEARANCES = 20_000
"""Of a Γ in a file."""


@dataclass(frozen=True)
class Appearance:
    """One datum of Γ.

    Attributes:
        id: Unique within its Γ.
        type: The appearance type, a name of the KB's vocabulary ("l_junction", "patch").
        uv: Place in pixels; an integer is a pixel's centre.
        detector: Name of the detector that reported it, or None.
        angle: Radians, clockwise on the screen from +x; None where the type has no direction.
        scale: Diameter in pixels, or None.
        score: The detector's own confidence in [0, 1], or None.
        arms: Directions of a junction's arms, radians, same convention as ``angle``, ascending in [0, 2π); empty for
            other types.
        descriptor: Raw bytes of a keypoint's descriptor: 128 of SIFT, or 138 with its colours, 32 of ORB; 5 of the
            looks of the side of an edge;
            None where the detector gives none.
        depth: Metres along the camera's z axis, or None; ``depth_sigma``: its standard deviation, metres, where there
            is one (§3.3).
    """

    id: str
    type: str
    uv: tuple[float, float]
    detector: str | None = None
    angle: float | None = None
    scale: float | None = None
    score: float | None = None
    arms: tuple[float, ...] = ()
    descriptor: bytes | None = None
    depth: float | None = None
    depth_sigma: float | None = None


@dataclass(frozen=True)
class Gamma:
    """All data of one view (§3.3: one viewpoint, so at most one appearance of a feature)."""

    camera: Camera
    appearances: tuple[Appearance, ...]

    @property
    def uv(self) -> NDArray[np.float64]:
        """(N, 2) places in pixels, in the order of ``appearances``; (0, 2) for an empty Γ."""
        return np.array([a.uv for a in self.appearances], dtype=np.float64).reshape(-1, 2)

    def in_order(self) -> "Gamma":
        """The same set, in one order however it is told: by ids, a2 before a10.

        Of data that are equal in all else the first is taken.
        """
        ordered = tuple(sorted(self.appearances, key=lambda a: (len(a.id), a.id)))
        return self if ordered == self.appearances else Gamma(self.camera, ordered)
