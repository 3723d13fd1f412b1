"""The scenes of ``plogic bench places``: Γ of one to four objects, partly one behind another, among clutter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.scenes import CAMERA
from benchmarks.many.placing import placed
from benchmarks.many.scenes import seen, truths_of
from benchmarks.places.types import DETECTOR
from benchmarks.recognition.score import HALF
from geometry.frames import transform_points
from sensing.appearance import Appearance, Gamma

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from benchmarks.many.placing import Placed
    from benchmarks.recognition.score import Truth
    from kb.clouds.cloud import KnowledgeBase

    Floats = NDArray[np.float64]

OBJECTS = 1, 4
"""Least and most of a scene."""
APPEARANCES = 40, 80
"""Least and most of a Γ: what is missing is filled up with clutter, and where there are more another scene is drawn."""
FEWEST = 5
"""Data of an object at least half visible: where there are fewer another scene is drawn, for they do not tell it. Four
lie as well on a wrong pose in one of so many tries."""
NOISE = 0.25
"""Share of all data that is clutter, where that makes enough."""
AIMED = 0.2
"""Share of the objects (the first aside) that are placed so that one more is half hidden."""


def scene(kb: KnowledgeBase, seed: int, number: tuple[int, int] = OBJECTS) -> tuple[Gamma, tuple[Truth, ...]]:
    """What the detector reports in the scene of a seed, in an order that tells nothing; and what stands there.

    ``number``: least and most objects.
    """
    rng = np.random.default_rng([seed, len(kb.types), len(kb.appearance_types), *number])
    while True:
        objects = placed(kb, rng, number, AIMED)
        own = [_reported(kb, objects, which, rng) for which in range(len(objects))]
        truths, found = truths_of(objects), sum(len(uv) for _, uv in own)
        told = all(len(uv) >= FEWEST or t.fraction < HALF for t, (_, uv) in zip(truths, own, strict=True))
        if told and found <= (1.0 - NOISE) * APPEARANCES[1]:
            break
    count = max(round(found * NOISE / (1.0 - NOISE)), APPEARANCES[0] - found)
    noise = rng.uniform(-0.5, [CAMERA.width - 0.5, CAMERA.height - 0.5], (count, 2))
    names = [name for some, _ in own for name in some] + rng.choice(kb.appearance_types, count).tolist()
    uv = np.concatenate([*(uv for _, uv in own), noise])
    order = rng.permutation(len(names))
    data = (Appearance(f"d{n}", names[i], (float(uv[i, 0]), float(uv[i, 1])), "simulated") for n, i in enumerate(order))
    return Gamma(CAMERA, tuple(data)), truths


def _reported(
    kb: KnowledgeBase, objects: list[Placed], which: int, rng: np.random.Generator
) -> tuple[list[str], Floats]:
    """Types, and pixels (N, 2), of the features of one object that the camera sees and the detector reports."""
    kind, some = objects[which].kind, seen(kb, objects, which)
    some = some[rng.random(len(some)) < DETECTOR.hit]
    uv = CAMERA.project(transform_points(objects[which].pose, kind.lobes.at[some]))
    uv = uv + rng.normal(0.0, DETECTOR.sigma, uv.shape)
    inside = CAMERA.contains(uv)
    return [kind.lobes.types[f] for f in some[inside]], uv[inside]
