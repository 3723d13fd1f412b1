"""Situations that hang together so that no order of elimination makes them easy."""

from __future__ import annotations

import numpy as np
from situations import feature, hypothesis, situation


def tangle(count, seed=0):
    """Every two of many share an appearance that others claim too.

    One piece that no order of elimination makes easy.
    """
    rng = np.random.default_rng(seed)
    members = [
        hypothesis(
            f"h{i}",
            [feature(f"f{k}", "A", match=f"a{k}", density=float(rng.random()) / 9) for k in rng.permutation(count)[:5]],
        )
        for i in range(count)
    ]
    return situation(members, "posterior")
