"""The record of the perceptual cycle (§7): which hypotheses were tried, and why each was kept or dropped."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plogic.facts.document import StepRow


@dataclass(frozen=True)
class Step:
    """One event, with its reason in one sentence; ``ev`` where it was decided by ev."""

    event: str
    why: str
    type: str | None = None
    hypothesis: str | None = None
    ev: float | None = None


@dataclass
class Trace:
    """The steps in order."""

    steps: list[Step] = field(default_factory=list)

    def add(
        self,
        event: str,
        why: str,
        *,
        of_type: str | None = None,
        hypothesis: str | None = None,
        ev: float | None = None,
    ) -> None:  # the key's name in interpretation.json
        """Record one step."""
        self.steps.append(Step(event, why, of_type, hypothesis, ev))

    def document(self) -> list[StepRow]:
        """As in ``interpretation.json``."""
        return [
            {"step": i, "event": s.event, "hypothesis": s.hypothesis, "type": s.type, "ev": s.ev, "why": s.why}
            for i, s in enumerate(self.steps, 1)
        ]
