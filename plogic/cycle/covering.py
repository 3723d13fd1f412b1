"""Where accepted objects stand in the image: what is there may well be hidden.

* ``covered_by(posed, data)``
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from plogic.match.gamma.ideal_projection import project_ideal

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data


def covered_by(posed: Iterable[Hypothesis], data: Data) -> NDArray[np.bool_]:
    """(H, W) where the opaque ones of some objects stand in the ideal image."""
    mask = np.zeros((data.camera.height, data.camera.width), dtype=np.uint8)
    for some in posed:
        surface = some.object_type.surface
        if surface is not None and some.object_type.opaque:
            corners = project_ideal(some.camera_from_object[None], surface.vertices, data)[0]
            for triangle in np.rint(corners[surface.triangles]).astype(np.int32):
                cv2.fillConvexPoly(mask, triangle, 1)
    return mask.astype(bool)
