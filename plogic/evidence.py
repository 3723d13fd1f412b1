"""The evidence for one hypothesis against clutter (§8, posterior, one claimant): the logarithm of a likelihood ratio."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.cloud import KnowledgeBase
    from plogic.expectation import Posed
    from plogic.search.data import Data


def density(residual: NDArray[np.float64], sigma: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """N(u; û, σ²I) per pixel² at distances ``residual`` in pixels; 0 where NaN."""
    value = np.exp(-0.5 * (residual / sigma) ** 2) / (2.0 * np.pi * sigma**2)
    return np.asarray(np.nan_to_num(value, nan=0.0))


def clutter_density(kb: KnowledgeBase, data: Data) -> NDArray[np.float64]:
    """F (A,) per pixel² of each datum: the expected number of clutter appearances of its type over the image's area."""
    area = float(data.camera.width * data.camera.height)
    return np.array([kb.rates.clutter.get(name, 1.0) / area for name in data.types])


def sigmas(posed: Posed, kb: KnowledgeBase) -> NDArray[np.float64]:
    """Location noise (F,) of each feature, pixels."""
    if posed.sigma is not None:
        return posed.sigma
    return np.array([kb.rates.sigma_of(feature.type) for feature in posed.object_type.features])


def match_density(posed: Posed, kb: KnowledgeBase) -> NDArray[np.float64]:
    """N (F,) per pixel² of each feature's match, 0 where it has none; of a learnt type against clutter that looks as right, not any."""
    near = density(posed.residual, sigmas(posed, kb))
    return near if posed.likeness is None else near * posed.likeness


def hit_rates(posed: Posed, kb: KnowledgeBase, hidden: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
    """h_F (F,) of each feature; of a learnt type the measured rates, times the share of them that holds in this image (``clarity``)."""
    if posed.hit is not None:
        return np.asarray(np.clip(posed.hit * clarity(posed, hidden), LEAST_HIT, MOST_HIT))
    return np.array([kb.rates.hit.get(feature.type, 0.8) for feature in posed.object_type.features])


CLEAR = 3.0
"""The prior of clarity is ∝ clarity³: an instance of which little shows where much should is rarely one. It counts in what is accepted; the
program has the scaled hit rates, and no prior of them."""
LEAST_CLEAR, LEAST_HIT, MOST_HIT = 0.04, 0.005, 0.98
"""Least share of the measured hit rates that an image can keep; bounds of what remains."""


def clarity(posed: Posed, hidden: NDArray[np.bool_] | None = None) -> float:
    """Which share of the measured hit rates holds of this instance in this image: light, focus, noise and a changed print cost detections.

    The most likely one: expected features that were detected, over the sum of their rates, in [``LEAST_CLEAR``, 1].
    """
    if posed.hit is None:
        return 1.0
    expected = posed.candidate if hidden is None else posed.candidate & ~hidden
    hoped = float(posed.hit[expected].sum())
    return float(np.clip((expected & posed.detected).sum() / hoped, LEAST_CLEAR, 1.0)) if hoped > 0.0 else 1.0


FIXED_BY = 3
"""Matches that any pose has for nothing: a pose can be laid through any three appearances."""


@dataclass(frozen=True)
class Evidence:
    """``ratio``: the log-likelihood ratio of presence against clutter; ``surplus``: what is left without the ``FIXED_BY`` best matches."""

    ratio: float
    surplus: float


def evidence(posed: Posed, data: Data, kb: KnowledgeBase, hidden: NDArray[np.bool_] | None = None) -> Evidence:
    """Σ over E∧D of ln((h·N + f − h·f) / f), in densities, plus Σ over E∧¬D of ln(1 − h) (§8).

    ``hidden`` (F,) are the features that accepted opaque objects hide: not expected.
    """
    expected = posed.candidate if hidden is None else posed.candidate & ~hidden
    hit = hit_rates(posed, kb, hidden)
    found = expected & posed.detected
    clutter = clutter_density(kb, data)[posed.matches[found]]
    gain = np.log((hit[found] * match_density(posed, kb)[found] + (1.0 - hit[found]) * clutter) / clutter)
    ratio = float(gain.sum() + np.log(1.0 - hit[expected & ~posed.detected]).sum())
    ratio += CLEAR * float(np.log(clarity(posed, hidden)))
    return Evidence(ratio, ratio - float(np.sort(gain)[-FIXED_BY:].sum()))
