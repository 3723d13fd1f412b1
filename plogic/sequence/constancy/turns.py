"""Whether a track's angles are those of one direction in space: the x axis of its feature's frame, as each view sees it.

A place and the angle in one view leave of the direction half a circle, of which each point has an angle in every other
view. For small moves these hardly differ, so that even two views say something; clutter has any angle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.screen_angles import screen_angle, wrapped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.sequence.constancy.sight_lines import Sights
    from plogic.sequence.constancy.tracks import Tracks

    Floats = NDArray[np.float64]

STEPS = 60
"""Points of the half circle."""
STRAY = 0.02
"""Share of angles that say nothing: a detector may turn a feature round."""
CHUNK = 2000
"""Tracks at a time: memory stays small."""


def log_turns(sights: Sights, tracks: Tracks) -> Floats:
    """(T,) ln of the density of the tracks' angles, the first of each given, if a direction in space causes them, against any angle alike.

    The direction is anywhere on the sphere, a priori. 0 where the KB says nothing of angles (``sigma_angle``), or a
    datum has none.
    """
    answer = np.zeros(len(tracks.kind))
    if sights.sigma_angle is None:
        return answer
    angles = np.where(tracks.data >= 0, sights.angle[np.arange(len(sights.views)), tracks.data], np.nan)
    known = np.flatnonzero((np.isfinite(angles) == (tracks.data >= 0)).all(axis=1))
    for start in range(0, len(known), CHUNK):
        some = known[start : start + CHUNK]
        answer[some] = _some(sights, tracks.places.at[some], angles[some], sights.sigma_angle)
    return answer


def _some(sights: Sights, at: Floats, angles: Floats, sigma: float) -> Floats:
    R, t = sights.camera_from_world[:, :3, :3], sights.camera_from_world[:, :3, 3]
    first = np.isfinite(angles).argmax(axis=1)
    theta = (np.arange(STEPS) + 0.5) * np.pi / STEPS
    directions = _half_circle(
        R[first], (R[first] @ at[..., None])[..., 0] + t[first], angles[np.arange(len(at)), first], theta
    )
    total = np.zeros((len(at), STEPS))
    for v in range(len(sights.views)):
        there = np.flatnonzero(np.isfinite(angles[:, v]) & (first != v))
        seen = screen_angle(directions[there] @ R[v].T, (at[there] @ R[v].T + t[v])[:, None])
        off = wrapped(seen - angles[there, v, None])
        right = (
            np.exp(-0.25 * (off / sigma) ** 2) * np.sqrt(np.pi) / sigma
        )  # both angles are noisy: the variance is twice sigma², times 2π
        total[there] += np.log(STRAY + (1.0 - STRAY) * right)
    share = np.sin(theta) / np.sin(theta).sum()
    return np.asarray(
        np.log((np.exp(total - total.max(axis=1, keepdims=True)) * share).sum(axis=1)) + total.max(axis=1)
    )


def _half_circle(camera_from_world: Floats, at_camera: Floats, angle: Floats, theta: Floats) -> Floats:
    """(T, S, 3) unit, world: what has the ``angle`` (T,) on the screen at places (T, 3), at ``theta`` (S,) from the line of sight."""
    ray = at_camera / np.linalg.norm(at_camera, axis=1, keepdims=True)
    aside = np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
    aside -= (aside * ray).sum(axis=1, keepdims=True) * ray
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    camera = np.cos(theta)[:, None] * ray[:, None] + np.sin(theta)[:, None] * aside[:, None]
    return np.asarray(camera @ camera_from_world)
