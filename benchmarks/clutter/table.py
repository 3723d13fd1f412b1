"""What ``plogic bench clutter`` prints: judged answers, a row a case and a side, and the claims.

* ``Outcome``: one answer to one trial, judged
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.recognition.score import pose_right
from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from benchmarks.clutter.scenes import Case
    from benchmarks.recognition.score import Found, Truth

OURS, ACCEPTED, TOLD = "ours", "accepted", "told"
CAPTION = """\
One object of `types` types among clutter. looks: appearance types in all; own: the object's own data in Γ, mean; learned: trials whose object is
made of what was learned from a mesh, and poses right of these. identity: the answer is of the right type; pose: and it stands right, within 5
degrees and 5 % of the distance, both as shares of all trials. ours: the best object accepted or, where none is, the best hypothesis, for there
is one, and the peers are asked alike; accepted: what is accepted alone. false: trials with an object that is not there, of another type or a
second one. Seconds are of the processor, all threads together; build: seconds once a knowledge base; it is in no trial's
seconds. told: the ceiling, somebody who knows the type and whose each datum is, and refines the true pose on them: what he has not
right, no method can have but by luck; identity is then the share of trials with four data or more of its own. The peers have so many seconds a
trial as are behind their names, use them, and are asked in the first trials of a row only. quadruples: the paper's sets of four with POSIT;
SoftPOSIT: from random starts; poselib: its LO-RANSAC; each type by type, on typed correspondences."""
IDENTITY, POSE, HARD_IDENTITY, HARD_POSE = 0.95, 0.95, 0.95, 0.75
SECONDS, SLOWER = 1.0, 3.0
LEARNED = 0.33


@dataclass(frozen=True)
class Outcome:
    """One trial of a case and what one side made of it; ``own``: how many of the data are the object's own."""

    case: Case
    who: str
    learned: bool
    own: int
    identity: bool
    pose: bool
    false: bool
    seconds: float


def judged(found: Sequence[Found], truth: Truth) -> tuple[bool, bool, bool]:
    """Whether the best is of the right type, whether its pose is right as well, whether one is not there.

    ``found`` comes best first.
    """
    identity = bool(found) and found[0].type == truth.type
    right = sum(f.type == truth.type for f in found)
    return identity, identity and pose_right(found[0], truth), right < len(found) or right > 1


def rows(outcomes: Sequence[Outcome], builds: Mapping[Case, float]) -> list[dict[str, Any]]:
    """A row a case and a side; ``builds``: seconds in which our side made each case's knowledge base ready."""
    return [
        _row([o for o in outcomes if (o.case, o.who) == side], builds)
        for side in dict.fromkeys((o.case, o.who) for o in outcomes)
    ]


def _row(mine: Sequence[Outcome], builds: Mapping[Case, float]) -> dict[str, Any]:
    case, who, learned, seconds = mine[0].case, mine[0].who, [o for o in mine if o.learned], [o.seconds for o in mine]
    return {
        "case": case.detector.name,
        "types": case.types,
        "looks": case.appearance_types,
        "who": who,
        "trials": len(mine),
        "own": round(sum(o.own for o in mine) / len(mine), 1),
        "identity": share(o.identity for o in mine),
        "pose": share(o.pose for o in mine),
        "learned": f"{sum(o.pose for o in learned)}/{len(learned)}",
        "median s": round(median(seconds), 3),
        "p95 s": round(float(np.percentile(seconds, 95)), 3),
        "false": sum(o.false for o in mine),
        "build": round(builds[case], 1) if who == OURS else "",
    }


def share(values: Iterable[bool]) -> float:
    """Of those that hold; 0 of none."""
    kept = list(values)
    return round(sum(kept) / len(kept), 4) if kept else 0.0


def claims(outcomes: Sequence[Outcome]) -> list[Claim]:
    """The issue's bars of our side.

    Those of right answers and of time for the fewest types, of the growth of time for more types.
    """
    mine = [o for o in outcomes if o.who == OURS]
    cases = list(dict.fromkeys(o.case for o in mine))
    listed = [claim for case in cases for claim in _of_case(case, mine)]
    return [
        *listed,
        Claim(
            "share of the trials with clouds learned from meshes",
            ">=",
            LEARNED,
            sum(o.learned for o in mine) / max(len(mine), 1),
        ),
    ]


def _of_case(case: Case, mine: Sequence[Outcome]) -> list[Claim]:
    some = [o for o in mine if o.case == case]
    alike = [o for o in mine if (o.case.detector, o.case.appearance_types) == (case.detector, case.appearance_types)]
    fewest = [o for o in alike if o.case.types == min(o.case.types for o in alike)]
    if case != fewest[0].case:
        slower = median(o.seconds for o in some) / max(median(o.seconds for o in fewest), 1e-9)
        return [Claim(f"{case}: median seconds over those of {fewest[0].case.types} types", "<=", SLOWER, slower)]
    identity, pose = share(o.identity for o in some), share(o.pose for o in some)
    if case.detector.name == "hard":
        return [
            Claim(f"{case}: identity right", ">=", HARD_IDENTITY, identity),
            Claim(f"{case}: pose right", ">=", HARD_POSE, pose),
        ]
    return [
        Claim(f"{case}: identity right", ">=", IDENTITY, identity),
        Claim(f"{case}: identity and pose right", ">=", POSE, pose),
        Claim(f"{case}: seconds, median", "<=", SECONDS, median(o.seconds for o in some)),
    ]
