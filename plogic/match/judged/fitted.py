"""What the program is told of a pose that was fitted to its matches (§8, posterior): they say less than of a pose that was known before.

The posterior of an object's presence sums over all poses that it may have; a hypothesis stands for those about its own.
So its prior is the type's times the share of all poses that fit about as well (``plogic.match.judged.freedom``), often
below what ProbLog can read as a label. It is told with the matches instead, of which each gives up in proportion. The
log odds of a lone hypothesis are then its type's prior, plus its evidence, plus the share.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.base.bounds import LEAST
from plogic.match.judged.evidence import as_counted, clutter_density
from plogic.match.judged.freedom import log_share
from plogic.match.judged.pose_information import known

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data

    Floats = NDArray[np.float64]


def as_fitted(
    posed: Hypothesis, data: Data, kb: KnowledgeBase, hidden: NDArray[np.bool_] | None = None
) -> tuple[Floats, Floats]:
    """Hit rates (F,) and densities (F,) per pixel²: of expected matches such that Π (h·N + f − h·f) / f is that at the best pose times the share.

    Each match gives up in proportion to how much better it is than a miss, ln(1 + h·N / (f − h·f)); where that is less
    in all than the pose owes, the matches count as misses. ``hidden`` (F,) are the features that accepted opaque
    objects hide: not expected.
    """
    hit, near = as_counted(posed, data, kb, hidden)
    found = posed.candidate & posed.detected
    found = found if hidden is None else found & ~hidden
    if found.any():
        h = np.clip(hit[found], LEAST, 1.0 - LEAST)
        missed = (1.0 - h) * clutter_density(kb, data, posed.matches[found])
        better = np.log1p(h * near[found] / missed)
        kept = max(LEAST, 1.0 + _owed(posed, found, data, kb) / max(float(better.sum()), LEAST))
        near[found] = np.expm1(kept * better) * missed / h
    return hit, near


def _owed(posed: Hypothesis, found: NDArray[np.bool_], data: Data, kb: KnowledgeBase) -> float:
    """The logarithm of the share of all poses that fit the matches as well as this one."""
    at, precision, middle, across = known(posed, found, data, kb)
    return log_share(at, precision, middle, data.camera, across)
