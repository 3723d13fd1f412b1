"""Situations of up to 14 hypotheses, more than hypothesis draws cheaply.

From a seed, with all that bears on a world's weight.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from situations import feature, hypothesis, situation

TYPES = ("t1", "t2", "A Box")


def crowd(count, seed, reading="posterior", mode="to_B", **changes):
    """Near neighbours share appearances, hide each other's features (front to back), rival, overlap or exclude."""
    rng = np.random.default_rng(seed)
    names = [f"h{i:02d}" for i in range(count)]
    members = [
        hypothesis(
            name,
            [_feature(rng, names[max(0, i - 3) : i], f"a{i + k}") for k in rng.permutation(6)[:4]],
            type=TYPES[int(rng.integers(3))],
            group=f"g{int(rng.integers(max(count // 2, 1)))}",
            opaque=bool(rng.random() < 0.8),
        )
        for i, name in enumerate(names)
    ]
    plain = situation(members, reading, mode, smoothing=(0.01, 0.0)[min(seed, 1)], priors={"t1": 0.4, "t2": 0.25})
    pairs = {kind: _pairs(rng, names) for kind in ("overlaps", "rivals", "exclusive")}
    return replace(plain, **{**pairs, "rivals": pairs["rivals"] | pairs["exclusive"], **changes})


def _feature(rng, before, appearance):
    found = rng.random() < 0.6
    return feature(
        f"part/{appearance}",
        match=appearance if found else None,
        dv=float(rng.choice([0.15, 0.5, 0.86])),
        density=float(rng.choice([1e-7, 1e-3, 0.05, 0.2])) if found else 0.0,
        hit_rate=float(rng.choice([0.3, 0.8, 0.95])),
        in_lobe=bool(rng.random() < 0.85),
        self_hidden=bool(rng.random() < 0.1),
        hidden_by=tuple(name for name in before if rng.random() < 0.3),
    )


def _pairs(rng, names):
    count = len(names)
    return frozenset(
        (names[i], names[j]) for i in range(count) for j in range(i + 1, min(i + 4, count)) if rng.random() < 0.2
    )
