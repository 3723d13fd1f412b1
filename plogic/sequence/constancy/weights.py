"""What a track says for one physical feature against clutter: ln of a Bayes factor times the prior odds.

With S the views of a track, u_i its data, X its unknown place, f_i the density of clutter of its type, P(S) how
probable it is to be detected there and missed elsewhere (``persistence``), and n the data of unknown features that an
image is expected to have (as many as of clutter):

    w = ln [ n · P(S) · ∫ p(X) Π_{i∈S} N(u_i; û_i(X), σ²I) dX ] − Σ_{i∈S} ln f_i

The integral is Laplace's: p(X̂) (2π)^{3/2} |C|^{1/2} Π N(u_i; û_i(X̂), σ²I), with X̂ the most likely place and C its
covariance.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from plogic.match.gamma.grid import screen_angle, wrapped
from plogic.sequence.constancy.sight_lines import Sights
from plogic.sequence.constancy.tracks import DEPTHS, Tracks

Hidden: TypeAlias = Callable[[str, Floats], Mask]
"""Which places (N, 3) m, world, the bodies that are known hide from a view, by its id: a mask (N,)."""

NEIGHBOURS = 3
"""The spacing of some places is the median distance to the neighbour of this number."""
SHARE = 0.5
"""Share of the features that are taken to be near certain ones; the others are anywhere."""
LEAST_CERTAIN = 4
"""Certain features below which nothing is said of where others are."""


def spacing(at: Floats) -> float:
    """m: the median distance of places (N, 3) to their third neighbours; to the farthest where there are fewer."""
    from scipy.spatial import cKDTree

    if len(at) < 2:
        return 0.0
    distances, _ = cKDTree(at).query(at, k=min(NEIGHBOURS, len(at) - 1) + 1)
    return float(np.median(distances[:, -1]))


@dataclass(frozen=True, eq=False)
class Company:
    """Certain tracks: their data (G, V), places (G, 3) m, and the spacing of these."""

    data: Indices
    at: Floats
    reach: float

    def log_place(self, tracks: Tracks, elsewhere: Floats) -> Floats:
        """The logarithms of p(X̂) (T,) with ``elsewhere`` (T,) being that of the first look.

        Half of it, and half normal about each certain place.

        A track does not keep itself company: certain ones that share a datum with it say nothing of it.
        """
        spread = tracks.places.covariance + self.reach**2 * np.eye(3)
        off = tracks.places.at[:, None] - self.at
        squared = np.einsum("tgi,tij,tgj->tg", off, np.linalg.inv(spread), off)
        near = np.exp(-0.5 * squared) / np.sqrt((2.0 * np.pi) ** 3 * np.linalg.det(spread))[:, None]
        own = ((tracks.data[:, None] == self.data) & (self.data >= 0)).any(axis=-1)
        density = np.where(own, 0.0, near).sum(axis=1) / len(self.at)
        return np.asarray(np.log((1.0 - SHARE) * np.exp(elsewhere) + SHARE * density))


def company_of(data: Indices, at: Floats) -> Company | None:
    """Of certain tracks (G, V) at places (G, 3); None of too few."""
    reach = spacing(at)
    return Company(data, at, reach) if len(at) >= LEAST_CERTAIN and reach > 0.0 else None


ODDS = 1.0
"""Prior odds of an unexplained datum to be of an unknown feature, against clutter."""


def log_weights(sights: Sights, tracks: Tracks, hidden: Hidden | None, company: Company | None = None) -> Floats:
    """The weights w (T,) of the tracks; ``company`` is what is known already of where unknown features are."""
    if not len(tracks.kind):
        return np.zeros(0)
    place = log_place(sights, tracks)
    if company is not None:
        place = company.log_place(tracks, place)
    spread = 0.5 * np.linalg.slogdet(tracks.places.covariance)[1] + 1.5 * np.log(2.0 * np.pi)
    prior = np.log(ODDS * sights.expected[tracks.kind])
    seen = _residuals_against_clutter(sights, tracks) + log_turns(sights, tracks)
    return np.asarray(prior + place + spread + seen + _persistence(sights, tracks, hidden))


def log_place(sights: Sights, tracks: Tracks) -> Floats:
    """The logarithms of p(X̂) (T,) per m³: anywhere in the image alike, and log-uniform over ``DEPTHS``.

    The mean over the track's views.
    """
    mask = tracks.data >= 0
    area = np.array(
        [view.gamma.camera.width * view.gamma.camera.height / view.gamma.camera.f**2 for view in sights.views]
    )
    density = 1.0 / (area * np.where(mask, tracks.places.depth, 1.0) ** 3 * np.log(DEPTHS[1] / DEPTHS[0]))
    return np.asarray(np.log(np.where(mask, density, 0.0).sum(axis=1) / mask.sum(axis=1)))


def _residuals_against_clutter(sights: Sights, tracks: Tracks) -> Floats:
    """(T,) ln of Π N(u_i; û_i, σ²I) / f_i."""
    mask = tracks.data >= 0
    each = np.log(2.0 * np.pi * sights.sigma[:, tracks.kind].T ** 2 * sights.clutter[:, tracks.kind].T)
    return np.asarray(-0.5 * tracks.places.chi2 - np.where(mask, each, 0.0).sum(axis=1))


def _persistence(sights: Sights, tracks: Tracks, hidden: Hidden | None) -> Floats:
    at, detected = tracks.places.at, tracks.data >= 0
    towards = sights.eye - at[:, None]
    towards = towards / np.maximum(np.linalg.norm(towards, axis=-1, keepdims=True), 1e-12)
    in_view = sights.in_image(at)
    if hidden is not None:
        in_view &= ~np.stack([hidden(view.id, at) for view in sights.views], axis=-1)
    return log_pattern(towards, in_view, detected, sights.hit[tracks.kind])


AXES = 96
"""Directions, spread evenly, that the unknown lobe's axis may have."""
HALF_ANGLES = tuple(np.radians([60.0, 75.0, 90.0, 110.0]).tolist())
"""Half-angles, each as probable, that it may have: a mark on a wall is seen from within about 75 degrees, a corner from
farther round."""
TRACKS = 1000
"""Tracks at a time: memory stays small."""


def log_pattern(towards: Floats, in_view: Mask, detected: Mask, hit: Floats) -> Floats:
    """(T,) ln of P(detected so, in the views where the place is in view) / P(detected in a given one).

    ``towards`` (T, V, 3): unit directions from the place to the cameras; ``in_view`` (T, V): in the image and hidden by
    nothing that is known; ``detected`` (T, V); ``hit`` (T,). The lobe is unknown: the mean over its axis and
    half-angle. Its own body hides a feature from outside of its lobe, so that a miss far round the object costs little,
    and one between two detections much.
    """
    parts = [slice(start, start + TRACKS) for start in range(0, len(towards), TRACKS)]
    return np.concatenate([np.zeros(0), *(_pattern(towards[p], in_view[p], detected[p], hit[p]) for p in parts)])


def _pattern(towards: Floats, in_view: Mask, detected: Mask, hit: Floats) -> Floats:
    cosine = (towards @ _directions().T).astype(np.float32)  # (T, V, A)
    h = hit[:, None, None].astype(np.float32)
    total = np.zeros(len(towards))
    for half in HALF_ANGLES:
        seen = np.where(cosine >= np.cos(half), h, np.float32(0.0))
        factor = np.where(detected[..., None], seen, np.where(in_view[..., None], 1.0 - seen, np.float32(1.0)))
        total += factor.prod(axis=1).mean(axis=1)
    alone = np.mean([(1.0 - np.cos(half)) / 2.0 for half in HALF_ANGLES]) * hit
    return np.asarray(np.log(np.maximum(total / len(HALF_ANGLES), 1e-300)) - np.log(alone))


def _directions() -> Floats:
    """(A, 3) unit, spread evenly."""
    z = 1.0 - (2.0 * np.arange(AXES) + 1.0) / AXES
    around, r = np.pi * (1.0 + 5.0**0.5) * np.arange(AXES), np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(around), r * np.sin(around), z], axis=1)


POINTS = 60
"""Points of the half circle."""
STRAY = 0.02
"""Share of angles that say nothing: a detector may turn a feature round."""
TRACKS_TURNED = 2000
"""Tracks at a time: memory stays small."""


def log_turns(sights: Sights, tracks: Tracks) -> Floats:
    """(T,) ln density of the tracks' angles given the first, if one direction causes them, over any angle alike.

    The direction is anywhere on the sphere, a priori. 0 where the KB says nothing of angles (``sigma_angle``), or a
    datum has none.
    """
    answer = np.zeros(len(tracks.kind))
    if sights.sigma_angle is None:
        return answer
    angles = np.where(tracks.data >= 0, sights.angle[np.arange(len(sights.views)), tracks.data], np.nan)
    known = np.flatnonzero((np.isfinite(angles) == (tracks.data >= 0)).all(axis=1))
    for start in range(0, len(known), TRACKS_TURNED):
        some = known[start : start + TRACKS_TURNED]
        answer[some] = _turns(sights, tracks.places.at[some], angles[some], sights.sigma_angle)
    return answer


def _turns(sights: Sights, at: Floats, angles: Floats, sigma: float) -> Floats:
    R, t = sights.camera_from_world[:, :3, :3], sights.camera_from_world[:, :3, 3]
    first = np.isfinite(angles).argmax(axis=1)
    theta = (np.arange(POINTS) + 0.5) * np.pi / POINTS
    directions = _half_circle(
        R[first], (R[first] @ at[..., None])[..., 0] + t[first], angles[np.arange(len(at)), first], theta
    )
    total = np.zeros((len(at), POINTS))
    for v in range(len(sights.views)):
        there = np.flatnonzero(np.isfinite(angles[:, v]) & (first != v))
        seen = screen_angle(directions[there] @ R[v].T, (at[there] @ R[v].T + t[v])[:, None])
        # Both angles are noisy: the variance is twice sigma², times 2π.
        right = np.exp(-0.25 * (wrapped(seen - angles[there, v, None]) / sigma) ** 2) * np.sqrt(np.pi) / sigma
        total[there] += np.log(STRAY + (1.0 - STRAY) * right)
    share = np.sin(theta) / np.sin(theta).sum()
    return np.asarray(
        np.log((np.exp(total - total.max(axis=1, keepdims=True)) * share).sum(axis=1)) + total.max(axis=1)
    )


def _half_circle(camera_from_world: Floats, at_camera: Floats, angle: Floats, theta: Floats) -> Floats:
    """(T, S, 3) unit, world: directions with ``angle`` (T,) on the screen at places (T, 3), at ``theta`` (S,).

    ``theta`` is from the line of sight.
    """
    ray = at_camera / np.linalg.norm(at_camera, axis=1, keepdims=True)
    aside = np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
    aside -= (aside * ray).sum(axis=1, keepdims=True) * ray
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    camera = np.cos(theta)[:, None] * ray[:, None] + np.sin(theta)[:, None] * aside[:, None]
    return np.asarray(camera @ camera_from_world)
