"""From which on pixels convince: by how many of the types are there, as the pixels of all of them tell together.

Where most types that one knows are there, less is asked of each than where hardly any is: the share that is there is
estimated from the photo itself (empirical Bayes), and what is there by ``THERE`` to 1 is accepted,
and kept in the end if it is by ``SURE`` to 1.

* ``demanded(best)``: the log-likelihood ratio that is asked of each
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from geometry.arrays import Floats

THERE, SURE = 5.0, 10.0
"""Odds from which a type is taken to be there while more is looked for, and in the end: nine in ten are to be right.
What is accepted sooner tells of the plane and hides others; in a trace of ``lmo`` the three between were not there.
"""
BEFORE = 1.0, 3.0
"""Of types, so many that are there and that are not are known before the photo is."""
ROUNDS = 100


def demanded(best: Floats) -> float:
    """The log-likelihood ratio from which pixels convince; ``best`` (T,): the greatest that each type has."""
    there, absent = BEFORE
    share = there / (there + absent)
    for _ in range(ROUNDS):
        each = 1.0 / (1.0 + np.exp(-np.clip(best, -50.0, 50.0)) * (1.0 - share) / share)
        share = float((there + each.sum()) / (there + absent + len(best)))
    return float(np.log(THERE * (1.0 - share) / share))
