"""What each datum says for or against a hypothesis in the posterior reading: log-likelihood ratios, one per feature or appearance (§8).

``Contribution("a3", 5.9)``: that a3 is there makes the hypothesis e^5.9 times likelier; ``Contribution("h1/roof/apex",
-1.6)``: that nothing was detected where h1's apex should be seen speaks against it. What it hides of others counts for
it: explaining away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.facts.dependence import Scene
from plogic.scene.readings.posterior_reading import appearance_weight, miss_weight, unmatched

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from plogic.facts.situation import Situation


@dataclass(frozen=True)
class Contribution:
    """``datum``: an appearance, or a feature that has none; ``llr``: ln P(datum | hypothesis) − ln P(datum | without it)."""

    datum: str
    llr: float


def contributions(situation: Situation, hypothesis: str, world: Iterable[str]) -> list[Contribution]:
    """Every datum that tells ``world`` with the hypothesis from ``world`` without it, the strongest first; ties by name.

    The ratios sum to the logarithm of the Bayes factor between these two worlds. A ratio may be infinite (a hit rate of
    1).
    """
    others = set(world) - {hypothesis}
    scene = Scene(situation)
    present = {h.id: np.array([h.id in others, h.id in others or h.id == hypothesis]) for h in situation.hypotheses}
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = [
            Contribution(name, float(np.log(weight[1]) - np.log(weight[0])))
            for name, weight in _weights(scene, present)
        ]
    told = [c for c in ratios if not math.isnan(c.llr) and abs(c.llr) > 1e-12]
    return sorted(told, key=lambda c: (-abs(c.llr), c.datum))


def _weights(
    scene: Scene, present: dict[str, np.ndarray[tuple[int], np.dtype[np.bool_]]]
) -> Iterator[tuple[str, np.ndarray[tuple[int], np.dtype[np.float64]]]]:
    for appearance in scene.claimants:
        yield appearance, appearance_weight(scene, appearance, present)
    for h in scene.situation.hypotheses:
        for f in unmatched(h):
            yield f"{h.id}/{f.id}", miss_weight(scene, h, f, present)
