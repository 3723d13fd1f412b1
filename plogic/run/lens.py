"""Whether the accepted objects agree with the camera's focal length: a wrong camera gives poses that look right."""

from collections.abc import Sequence
from math import dist, exp, inf

import numpy as np

from geometry.arrays import Floats
from geometry.camera import Camera
from geometry.frames import inverse, transform_points
from geometry.poses.focal import error_by_groups, focal_fit
from plogic.facts.document import CameraDoubtRow, HypothesisRow, Interpretation

SURE = 4.0
"""Standard errors from which on it is told.

``python benchmarks/focal_doubts.py 20``, photographs of simulated towers: under the right camera told in 0 of 20, at
0.7, 0.85, 1.2 and 1.5 of its focal length in 11, 7, 8 and 14."""
HARDLY = 3.0
"""An object whose standard error is larger than the least by this factor, so that it counts for a ninth, is left out
where errors are asked again: what fixes no focal length takes long."""
FEWEST = 6
"""Matched features of a hypothesis below which it is not asked."""
APART = 0.1
"""Change of ln f below which nothing is told, however sure."""
SIDE = 0.1
"""Pixels by which a match's residual may differ from its distance: of sides of edges it is what is off across them."""


def focal_doubt(document: Interpretation, camera: Camera) -> CameraDoubtRow | None:
    """What focal length the matched features of all accepted objects fit better; None where they fit the camera's."""
    told = [
        (*_matches(h, document), np.array(h["T_camera_object"]))
        for h in document["hypotheses"]
        if h["status"] == "accepted"
    ]
    fits = [
        (places, data, focal_fit(places, data, camera, pose)) for places, data, pose in told if len(places) >= FEWEST
    ]
    found = [(fit.log, fit.noise * fit.error) for *_, fit in fits]
    if not _far(*_together(found)):
        return None
    least = min(error for _, error in found)
    step, error = _together(
        [
            (log, max(error, error_by_groups(places, data, camera, fit)))
            for (places, data, fit), (log, error) in zip(fits, found, strict=True)
            if error <= HARDLY * least
        ]
    )
    if not _far(step, error):
        return None
    fitting = camera.f * exp(step)
    why = (
        f"the accepted objects fit a focal length of {fitting:.0f} pixels (standard error {fitting * error:.0f}) better "
        f"than the camera's {camera.f:.0f}: is it this picture's camera, at this size? Poses are as wrong as it is"
    )
    return {"focal": fitting, "standard_error": fitting * error, "stated": camera.f, "why": why}


def _far(step: float, error: float) -> bool:
    """Whether a change of ln f is far from 0 for its standard error."""
    return abs(step) >= max(APART, SURE * error)


def _together(estimates: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Several estimates as one, by their standard errors; (0, inf) of none that says anything."""
    weights = [(value, error**-2.0) for value, error in estimates if 0.0 < error < inf]
    whole = sum(weight for _, weight in weights)
    return (sum(value * weight for value, weight in weights) / whole, whole**-0.5) if whole else (0.0, inf)


def _matches(h: HypothesisRow, document: Interpretation) -> tuple[Floats, Floats]:
    """The matched features (N, 3) m, object frame, and their data (N, 2) px; sides of edges are left out."""
    seen = {row["id"]: row["uv"] for row in document["appearances"]}
    pairs = [
        (f["at"], seen[f["match"]])
        for f in h["features"]
        if f["match"] is not None and f["residual"] is not None
        if f["uv"] is not None and abs(dist(f["uv"], seen[f["match"]]) - f["residual"]) < SIDE
    ]
    places, data = (np.array([pair[k] for pair in pairs], np.float64).reshape(-1, 3 - k) for k in (0, 1))
    return transform_points(inverse(np.array(h["T_camera_object"])), places), data
