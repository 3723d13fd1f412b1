"""What ``plogic bench many`` prints.

Both sides over all scenes, ours by how much of an object shows and by how its type was made, the claims.

* ``Answer``: what one side made of one scene
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.many.placing import HALF_HIDDEN
from benchmarks.many.score import IN_VIEW
from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from benchmarks.many.score import Seen, Verdict

OURS, TOLD, CROWDED = "ours", "told", "crowded"
CAPTION = """\
Scenes of 5 to 10 objects, of 50 types. there: objects at least 40 % visible; found: those that an accepted object of their type stands for
within 5 degrees and 5 % of the distance; rotation, p90: median and 90th percentile of the found, degrees; wrong: accepted objects that stand so
for none, less visible ones counted as well; askew: those of the wrong whose type is right and whose centre lies within the box of a true one's
picture; reach: how far two accepted bodies reach into each other at most, mm. Seconds are of the processor a scene, all threads together. told:
the ceiling, somebody who knows what is there and whose each datum is, and refines the true poses on them. peer: poselib's LO-RANSAC of every
type on typed correspondences, the most inliers first, each datum used once, down to the number of inliers (at) with the best F1 over these very
scenes; it knows no angles. half hidden: of ours, those 30 to 60 % occluded; in the open: the others; polyhedra and learned types: ours by how
their types were made. crowded: ours in other scenes, of 11 to 18 objects."""
RECALL, PRECISION, ROTATION, SECONDS, REACH = 0.90, 0.95, 1.5, 2.0, 1.0


@dataclass(frozen=True)
class Answer:
    """``seconds`` of the processor; ``deep``: how far two of the accepted reach into each other at most, m."""

    verdict: Verdict
    seconds: float
    deep: float = 0.0


@dataclass(frozen=True)
class Totals:
    """Over some scenes: objects to be found; accepted, right and askew ones; reach in m; seconds a scene."""

    seen: tuple[Seen, ...]
    accepted: int
    right: int
    askew: int
    deep: float
    seconds: tuple[float, ...]

    @property
    def recall(self) -> float:
        """Share of those there that were found; 1 of none."""
        return sum(s.turned is not None for s in self.seen) / len(self.seen) if self.seen else 1.0

    @property
    def precision(self) -> float:
        """Share of the accepted that are right; 1 of none."""
        return self.right / self.accepted if self.accepted else 1.0

    @property
    def f1(self) -> float:
        """The harmonic mean of both."""
        total = self.recall + self.precision
        return 2.0 * self.recall * self.precision / total if total else 0.0

    @property
    def turned(self) -> list[float]:
        """Degrees by which each of the found is turned."""
        return [float(np.degrees(s.turned)) for s in self.seen if s.turned is not None]


def totals(answers: Sequence[Answer]) -> Totals:
    """Of some scenes together."""
    some = [a.verdict for a in answers]
    return Totals(
        tuple(s for v in some for s in v.seen),
        sum(v.accepted for v in some), sum(v.right for v in some), sum(v.askew for v in some),
        max((a.deep for a in answers), default=0.0), tuple(a.seconds for a in answers),
    )  # fmt: skip


def best_least(scored: dict[int, Totals]) -> int:
    """Of the least numbers of inliers that with the best F1; of equally good ones the least."""
    return max(sorted(scored), key=lambda least: scored[least].f1)


def rows(ours: Totals, others: dict[str, Totals], learned: Callable[[str], bool]) -> list[dict[str, Any]]:
    """A row a side, then of ours those half hidden and the others, and those of polyhedra and of learned types."""
    groups: dict[str, Callable[[Seen], bool]] = {
        "half hidden": lambda s: s.fraction <= HALF_HIDDEN[1],
        "in the open": lambda s: s.fraction > HALF_HIDDEN[1],
        "polyhedra": lambda s: not learned(s.type),
        "learned types": lambda s: learned(s.type),
    }
    listed = [_row(name, some) for name, some in {OURS: ours, **others}.items()]
    return listed + [_part(name, [s for s in ours.seen if of(s)]) for name, of in groups.items()]


def _row(name: str, t: Totals) -> dict[str, Any]:
    part = _part(name, t.seen)
    counts = {
        "accepted": t.accepted,
        "wrong": t.accepted - t.right,
        "askew": t.askew,
        "precision": round(t.precision, 3),
    }
    return (
        part
        | counts
        | {"reach": round(1000.0 * t.deep, 2), "median s": round(median(t.seconds), 3) if t.seconds else ""}
    )


def _part(name: str, seen: Sequence[Seen]) -> dict[str, Any]:
    some = Totals(tuple(seen), 0, 0, 0, 0.0, ())
    nobody = dict.fromkeys(("accepted", "wrong", "askew", "precision", "reach", "median s"), "")
    turned = some.turned
    angles = (
        {"rotation": round(median(turned), 2), "p90": round(float(np.percentile(turned, 90)), 2)}
        if turned
        else {"rotation": "", "p90": ""}
    )
    return {"row": name, "there": len(seen), "found": len(turned), "recall": round(some.recall, 3), **angles, **nobody}


def claims(ours: Totals) -> list[Claim]:
    """The issue's bars."""
    return [
        Claim(f"recall of objects at least {IN_VIEW:.0%} visible", ">=", RECALL, ours.recall),
        Claim("precision", ">=", PRECISION, ours.precision),
        Claim(
            "rotation of the found, median degrees",
            "<=",
            ROTATION,
            median(ours.turned) if ours.turned else float("inf"),
        ),
        Claim("how far accepted bodies reach into each other at most, mm", "<=", REACH, 1000.0 * ours.deep),
        Claim("seconds a scene, median", "<=", SECONDS, median(ours.seconds) if ours.seconds else 0.0),
    ]
