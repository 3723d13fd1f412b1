"""What speaks against a hypothesis in a photo, compactly: where on it features are missed.

Hundreds of features of a learned type are expected, and most are missed of a right pose too: what tells is where fewer
are found than when the type was learned. ``missed_on(row, size)`` is the mask of such places.
"""

import cv2
import numpy as np

from geometry.arrays import Mask
from plogic.facts.document import HypothesisRow

REACH = 0.06
"""Share of the object's larger side, the standard deviation of the window in which features are counted."""
ENOUGH = 3.0
"""Features that were found in a window, as a rule, from which none found is no chance: it is one in twenty, e⁻³."""
FEW = 1 / 3
"""Share of these below which what is found is few."""


def missed_on(h: HypothesisRow, size: tuple[int, int]) -> Mask:
    """(height, width) of an image of ``size``: within the outline, where few are found of what is found as a rule.

    Nothing of a type that was not learned, and where another object that is accepted hides the features.
    """
    width, height = size
    inside = silhouette(h, size)
    rows = [f for f in h.get("features", []) if "learned_rate" in f and f.get("case") in ("A", "C")]
    uv = np.rint(np.array([f["uv"] for f in rows], float).reshape(-1, 2)).astype(np.intp)
    uv = np.clip(uv, 0, [width - 1, height - 1])
    if not inside.any() or not len(uv):
        return np.zeros((height, width), bool)
    usual, found = np.zeros((2, height, width), np.float32)
    v, u = np.nonzero(inside)
    sigma = max(1.0, REACH * float(max(np.ptp(u), np.ptp(v))))
    np.add.at(usual, (uv[:, 1], uv[:, 0]), [f["learned_rate"] for f in rows])
    np.add.at(found, (uv[:, 1], uv[:, 0]), [f["case"] == "A" for f in rows])
    usual, found = (2.0 * np.pi * sigma**2 * cv2.GaussianBlur(some, (0, 0), sigma) for some in (usual, found))
    return np.asarray(inside & (usual >= ENOUGH) & (found < FEW * usual))


def missed_rings(h: HypothesisRow, size: tuple[int, int]) -> list[list[list[float]]]:
    """The rings, pixels, about the places of ``missed_on``."""
    found = cv2.findContours(missed_on(h, size).astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_TC89_L1)[0]
    return [ring.reshape(-1, 2).tolist() for ring in found if len(ring) > 2]


def silhouette(h: HypothesisRow, size: tuple[int, int]) -> Mask:
    """(height, width) of an image of ``size``: what is within the outline."""
    mask = np.zeros(size[::-1], np.uint8)
    for ring in h.get("outline", []):
        places = np.clip(np.nan_to_num(np.array(ring, float)), -1e4, 1e4)
        cv2.fillPoly(mask, [np.rint(places).astype(np.int32)], 1)
    return np.asarray(mask > 0)
