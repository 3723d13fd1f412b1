"""What the matches of a hypothesis say of its pose: the places that they fix, how sharply, and the lines that their angles lead along.

* ``known(posed, which, data, kb)``: of some of its features, as ``plogic.match.judged.freedom`` takes it
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.poses.reprojection import WEIGHT, across, ends, reach

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data

    Floats = NDArray[np.float64]


class Known(NamedTuple):
    """``at`` (N, 3) m, camera frame; ``precision`` (N,) 1/pixel²; ``middle`` (3,) m of the object, camera frame.

    ``across`` (N, 2) unit vectors across the lines that a place may lie anywhere along, NaN of others; None where there
    are no lines.
    """

    at: Floats
    precision: Floats
    middle: Floats
    across: Floats | None


def known(posed: Hypothesis, which: NDArray[np.bool_], data: Data, kb: KnowledgeBase) -> Known:
    """Of features ``which`` (F,), all matched: their places, as much as they are counted; and their angles, where these count."""
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
