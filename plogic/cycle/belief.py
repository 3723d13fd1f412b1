"""What a run of the perceptual cycle came to (§7): ``Cycle``, with Δh, Δi and the trace."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from plogic.match.judged.alike import same_place

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.cycle.attention import Attention
    from plogic.cycle.trace import Trace
    from plogic.facts.hypothesis import Hypothesis


@dataclass(frozen=True)
class Cycle:
    """``accepted`` is Δi in the order of acceptance; ``considered`` the rest of Δh; ``rejected`` what was tried and dropped."""

    accepted: tuple[Hypothesis, ...]
    considered: tuple[Hypothesis, ...]
    rejected: tuple[Hypothesis, ...]
    attention: tuple[Attention, ...]
    trace: Trace


def same_hypothesis(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two hypotheses are near-duplicates: one type, one place up to symmetry (§8)."""
    return one.object_type.name == other.object_type.name and same_place(
        one.object_type, one.camera_from_object, other.camera_from_object
    )


MOST_RIVALS = 2
"""Rivals of an accepted hypothesis that enter Δh with it."""


def considered(rivals: Sequence[Hypothesis], accepted: Sequence[Hypothesis]) -> list[Hypothesis]:
    """At most ``MOST_RIVALS`` rivals an accepted hypothesis, near-duplicates merged, best first."""
    kept: list[Hypothesis] = []
    for rival in sorted(rivals, key=lambda b: -b.worth):
        twin = any(same_hypothesis(rival, b) for b in [*kept, *accepted])
        if not twin and len(kept) < MOST_RIVALS * len(accepted):
            kept.append(rival)
    return kept
