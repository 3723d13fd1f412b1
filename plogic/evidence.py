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
    return np.array([kb.rates.sigma_of(feature.type) for feature in posed.object_type.features])


def hit_rates(posed: Posed, kb: KnowledgeBase) -> NDArray[np.float64]:
    """h_F (F,) of each feature."""
    return np.array([kb.rates.hit.get(feature.type, 0.8) for feature in posed.object_type.features])


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
    hit = hit_rates(posed, kb)
    found = expected & posed.detected
    clutter = clutter_density(kb, data)[posed.matches[found]]
    gain = np.log(
        (hit[found] * density(posed.residual[found], sigmas(posed, kb)[found]) + (1.0 - hit[found]) * clutter) / clutter
    )
    ratio = float(gain.sum() + np.log(1.0 - hit[expected & ~posed.detected]).sum())
    return Evidence(ratio, ratio - float(np.sort(gain)[-FIXED_BY:].sum()))
