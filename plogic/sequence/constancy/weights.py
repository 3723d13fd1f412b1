"""What a track says for one physical feature against clutter: ln of a Bayes factor times the prior odds.

With S the views of a track, u_i its data, X its unknown place, f_i the density of clutter of its type, P(S) how
probable it is to be detected there and missed elsewhere (``persistence``), and n the data of unknown features that an
image is expected to have (as many as of clutter):

    w = ln [ n · P(S) · ∫ p(X) Π_{i∈S} N(u_i; û_i(X), σ²I) dX ] − Σ_{i∈S} ln f_i

The integral is Laplace's: p(X̂) (2π)^{3/2} |C|^{1/2} Π N(u_i; û_i(X̂), σ²I), with X̂ the most likely place and C its
covariance.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.sequence.constancy.persistence import log_pattern
from plogic.sequence.constancy.tracks import DEPTHS
from plogic.sequence.constancy.turns import log_turns

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from plogic.sequence.constancy.company import Company
    from plogic.sequence.constancy.sight_lines import Sights
    from plogic.sequence.constancy.tracks import Tracks

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]
    Hidden = Callable[[str, Floats], Flags]
    """Which places (N, 3) m, world, the bodies that are known hide from a view, by its id: a mask (N,)."""

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
    """The logarithms of p(X̂) (T,) per m³: anywhere in the image alike, and log-uniform over ``DEPTHS``; the mean over the track's views."""
    mask = tracks.data >= 0
    area = np.array(
        [view.gamma.camera.width * view.gamma.camera.height / view.gamma.camera.f**2 for view in sights.views]
    )
    span = np.log(DEPTHS[1] / DEPTHS[0])
    density = 1.0 / (area * np.where(mask, tracks.places.depth, 1.0) ** 3 * span)
    return np.asarray(np.log(np.where(mask, density, 0.0).sum(axis=1) / mask.sum(axis=1)))


def _residuals_against_clutter(sights: Sights, tracks: Tracks) -> Floats:
    """(T,) ln of Π N(u_i; û_i, σ²I) / f_i."""
    mask = tracks.data >= 0
    sigma, clutter = sights.sigma[:, tracks.kind].T, sights.clutter[:, tracks.kind].T
    each = np.log(2.0 * np.pi * sigma**2 * clutter)
    return np.asarray(-0.5 * tracks.places.chi2 - np.where(mask, each, 0.0).sum(axis=1))


def _persistence(sights: Sights, tracks: Tracks, hidden: Hidden | None) -> Floats:
    at, detected = tracks.places.at, tracks.data >= 0
    towards = sights.eye - at[:, None]
    towards = towards / np.maximum(np.linalg.norm(towards, axis=-1, keepdims=True), 1e-12)
    in_view = sights.in_image(at)
    if hidden is not None:
        in_view &= ~np.stack([hidden(view.id, at) for view in sights.views], axis=-1)
    return log_pattern(towards, in_view, detected, sights.hit[tracks.kind])
