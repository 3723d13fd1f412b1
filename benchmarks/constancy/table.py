"""What ``plogic bench constancy`` prints: all sides by the number of views, how the probabilities hold, the claims.

* ``Tally``: the scores so far, by side and number of views
"""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import median
from typing import Any

from benchmarks.constancy.score import Score
from benchmarks.shared.claims import Claim

OURS, ONE_LOOK, ANGLELESS, PEER = "ours", "one look", "no angles", "epipolar"
COUNTS = 2, 3, 4, 5
"""Numbers of views."""
AFTER = 3
"""Views after which the claims are taken."""
PHYSICAL, NOISE, SECONDS = 0.90, 0.95, 1.0
CAPTION = """\
Sequences of a camera on a ring round known and unknown bodies, 12 to 25 degrees on from view to view, with 45 data of clutter an image. seen: the
unknown bodies' features that were detected in two views or more; physical: those of them that are called so (two of their data are in one physical
feature); of all: the same of those that were to be seen in a view or more, detected or not; precise: of what was called physical, what is one true
feature; said: the mean probability that was given. noise, undecided: what clutter was called; right: of what was called noise, the clutter (the
rest are features that were detected once, or lost). whole: unknown bodies, four features found or more, that are one cluster. s: of the
processor, the longest sequence. one look: without the second look, which knows where the first found features; no angles: as if data had
none; epipolar: plain two-view matching, each view with the next."""


@dataclass
class Tally:
    """``scores`` and ``seconds`` by side and number of views.

    ``forecasts`` by number of views: probabilities, and whether it was so.
    """

    scores: dict[tuple[str, int], Score] = field(default_factory=dict)
    seconds: dict[int, list[float]] = field(default_factory=dict)
    forecasts: dict[int, list[tuple[float, bool]]] = field(default_factory=dict)

    def add(self, who: str, count: int, scored: Score, seconds: float | None = None) -> None:
        """One more sequence."""
        self.scores[who, count] = self.scores.get((who, count), Score()) + scored
        if seconds is not None:
            self.seconds.setdefault(count, []).append(seconds)

    def forecast(self, count: int, probability: float, *, right: bool) -> None:
        """One more feature that was called physical."""
        self.forecasts.setdefault(count, []).append((probability, right))


def rows(tally: Tally) -> list[dict[str, Any]]:
    """A row a number of views and side."""
    return [
        _row(who, count, tally)
        for count in COUNTS
        for who in (OURS, ONE_LOOK, ANGLELESS, PEER)
        if (who, count) in tally.scores
    ]


def _row(who: str, count: int, tally: Tally) -> dict[str, Any]:
    s = tally.scores[who, count]
    said = tally.forecasts.get(count, []) if who == OURS else []
    return {
        "views": count,
        "who": who,
        "seen": s.twice,
        "physical": _share(s.found, s.twice),
        "of all": _share(s.found, s.visible),
        "precise": _share(s.right, s.called),
        "said": round(sum(p for p, _ in said) / len(said), 3) if said else "",
        "noise": _share(s.noise, s.clutter),
        "undecided": _share(s.undecided, s.clutter),
        "right": _share(s.noise, s.called_noise),
        "whole": f"{s.whole}/{s.bodies}" if who != PEER else "",
        "s": round(max(tally.seconds[count]), 2) if who == OURS else "",
    }


def _share(some: int, of: int) -> float:
    return round(some / of, 3) if of else 1.0


def claims(tally: Tally) -> list[Claim]:
    """The issue's bars."""
    s = tally.scores[OURS, AFTER]
    return [
        Claim(
            f"unknown features, detected twice or more in {AFTER} views, called physical",
            ">=",
            PHYSICAL,
            s.found / max(s.twice, 1),
        ),
        Claim(f"noise called noise after {AFTER} views", ">=", NOISE, s.noise / max(s.clutter, 1)),
        Claim(f"seconds a sequence of {COUNTS[-1]} views, median", "<=", SECONDS, median(tally.seconds[COUNTS[-1]])),
    ]
