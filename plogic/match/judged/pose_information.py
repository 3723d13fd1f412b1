"""What the matches of a hypothesis say of its pose, and what the pose owes to its freedom.

Of all poses a few fit any matches, so that a fit to them is no evidence by itself. The evidence of presence is that of
all poses, not of the best (the marginal likelihood, by Laplace's method): the likelihood at the best pose, times the
share of all poses that fit about as well.

* ``known(posed, which, data, kb)``: the places that matches fix, how sharply, and the lines that their angles lead
  along
* ``log_share(at, precision, centre, camera, across)``: the logarithm of that share, at most 0; ``share_of(information,
  ...)``, of what is known
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.poses.reprojection import WEIGHT, across, ends, information, reach

if TYPE_CHECKING:
    from geometry.arrays import Floats, Mask
    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data


DEPTHS = 4.2
"""Logarithm of the ratio of the farthest to the nearest distance that is believed."""
LOOSE = (0.3, 0.35)
"""Even one appearance fixes the distance (its size) and the rotation (its angle and its lobe) so well: logarithm,
radians."""


def log_share(at: Floats, precision: Floats, centre: Floats, camera: Camera, across: Floats | None = None) -> float:
    """The share of all poses, even in the image, in the logarithm of depth and in rotation, that fit matched places as well as theirs.

    ``at`` (N, 3) metres, camera frame; ``precision`` (N,) 1/pixel²; ``centre`` (3,) of the object, before the camera;
    ``across`` (N, 2) unit vectors across the edges that sides lie anywhere along, NaN of others.
    """
    return float(share_of(information(at, centre, precision, camera, across), centre[2], camera))


def share_of(information: Floats, depth: Floats | float, camera: Camera) -> Floats:
    """The logarithm of that share, (...,): of what is known (..., 6, 6) of a step (w rad, v m) in the camera's axes.

    The step is about a middle at ``depth`` (...,) metres.
    """
    far = np.asarray(depth, float)[..., None]
    scale = np.concatenate(
        [np.ones((*far.shape[:-1], 3)), np.repeat(far, 3, axis=-1)], axis=-1
    )  # moves are counted in depths
    loose = np.array([*[LOOSE[1]] * 3, camera.width / camera.f, camera.height / camera.f, LOOSE[0]])
    sharp = information * scale[..., :, None] * scale[..., None, :] + np.diag(loose**-2.0)
    volume = 3.0 * np.log(2.0 * np.pi) - 0.5 * np.linalg.slogdet(sharp)[1]
    return np.asarray(volume - np.log(camera.width * camera.height / camera.f**2 * DEPTHS * 8.0 * np.pi**2))


class Known(NamedTuple):
    """``at`` (N, 3) m, camera frame; ``precision`` (N,) 1/pixel²; ``middle`` (3,) m of the object, camera frame.

    ``across`` (N, 2) unit vectors across the lines that a place may lie anywhere along, NaN of others; None where there
    are no lines.
    """

    at: Floats
    precision: Floats
    middle: Floats
    across: Floats | None


def known(posed: Hypothesis, which: Mask, data: Data, kb: KnowledgeBase) -> Known:
    """Of features ``which`` (F,), all matched: their places, as much as they are counted.

    And their angles, where these count.
    """
    at, sigma = posed.at[which], sigmas(posed, kb)[which]
    precision, lines = posed.counted[which] / sigma**2, None if posed.across is None else posed.across[which]
    if posed.axes is not None and kb.rates.sigma_angle is not None:
        angle = data.angle[posed.matches[which]]
        told = np.isfinite(angle)
        beyond = ends(at, posed.axes[which], at[:, 2], reach(sigma, kb.rates.sigma_angle) / data.camera.f)[told]
        lines = np.concatenate([np.full((len(at), 2), np.nan), across(angle[told])])
        at, precision = np.concatenate([at, beyond]), np.concatenate([precision, precision[told] * WEIGHT])
    return Known(at, precision, posed.middle, lines)


def sigmas(posed: Hypothesis, kb: KnowledgeBase) -> Floats:
    """Location noise (F,) of each feature, pixels."""
    if posed.sigma is not None:
        return posed.sigma
    return np.array([kb.rates.sigma_of(feature.type) for feature in posed.object_type.features])
