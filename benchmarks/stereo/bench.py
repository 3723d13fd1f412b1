"""``plogic bench stereo``: the pose of one small object from one image, and from a calibrated pair of them (§3.3).

The left image is the same for both. Objects are as small in it as a cup on a table two metres away; the right camera
stands 12 cm to the right.
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.clutter.scenes import CAMERA, random_pose, visible
from benchmarks.clutter.types import Detector, random_types
from benchmarks.shared.claims import Claim, report
from geometry.frames import pose_error
from plogic.match.gamma.grid import screen_angle
from sensing.appearance import Appearance, Gamma

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.run.perceive import Perceiver
    from sensing.files.stereo import Pair

    Floats = NDArray[np.float64]

TRIALS, QUICK = 100, 10
TYPES, LOOKS, FEATURES, CLUTTER = 20, 300, 60, 100
DETECTOR = Detector("table", 0.8, 1.0, float(np.radians(5.0)))
BASELINE = 0.12
"""Metres between the cameras."""
SMALLER = 0.5
"""Pictures are so much smaller than those of ``bench clutter``: 50 to 150 pixels."""


@dataclass(frozen=True)
class Outcome:
    """One trial: errors of the pose of one image and of the pair, radians and share of the distance.

    None where the type is not accepted.
    """

    mono: tuple[float, float] | None
    pair: tuple[float, float] | None
    depths: int


def run(*, seed: int, quick: bool, as_json: bool, say: Callable[[str], None]) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a trial on ``say``."""
    from plogic.run.perceive import Perceiver

    kb = random_types(TYPES, FEATURES, LOOKS, np.random.default_rng([seed, 0]), DETECTOR, CLUTTER)
    perceiver = Perceiver(kb)
    outcomes = []
    for number in range(QUICK if quick else TRIALS):
        outcomes.append(one_trial(kb, perceiver, np.random.default_rng([seed, 1 + number])))
        say(f"trial {number}: {_said(outcomes[-1])}")
    return report("stereo", _rows(outcomes), claims(outcomes), as_json=as_json)


def one_trial(kb: KnowledgeBase, perceiver: Perceiver, rng: np.random.Generator) -> Outcome:
    """One object before both cameras; perceived in the left image, and in the pair."""
    from sensing.files.stereo import Pair, fused

    kind = kb.types[int(rng.integers(len(kb.types)))]
    pose = random_pose(kind, rng)
    pose[:3, 3] /= SMALLER
    right_from_left = np.eye(4)
    right_from_left[0, 3] = -BASELINE
    left, right = (detected(kind, camera @ pose, kb, rng) for camera in (np.eye(4), right_from_left))
    pair = Pair(right_from_left)
    both = fused(left, right, pair, DETECTOR.sigma)
    depths = sum(a.depth is not None for a in both.appearances)
    return Outcome(off(perceiver, left, kind, pose), off_of_pair(perceiver, both, right, pair, (kind, pose)), depths)


def off_of_pair(
    perceiver: Perceiver, both: Gamma, right: Gamma, pair: Pair, truth: tuple[ObjectType, Floats]
) -> tuple[float, float] | None:
    """As ``off``, of the best that is accepted of the pair's Γ, refined on both images."""
    from plogic.base.clock import Stopwatch
    from plogic.cycle.delta import Options
    from plogic.sequence.views.standing import sharpened

    data, cycle = perceiver.cycle(both, Options(reading="posterior"), Stopwatch())
    kind, pose = truth
    accepted = sharpened(cycle, both, data, right, pair, perceiver).accepted
    mine = sorted((b for b in accepted if b.object_type.name == kind.name), key=lambda b: -b.surplus)
    return error(mine[0].camera_from_object, kind, pose) if mine else None


def detected(kind: ObjectType, pose: Floats, kb: KnowledgeBase, rng: np.random.Generator) -> Gamma:
    """What one camera reports of an object at camera_from_object (4, 4), and clutter."""
    at = (pose[:3, :3] @ kind.lobes.at.T).T + pose[:3, 3]
    seen = np.flatnonzero(
        visible(kind, pose, kb.f_ref) & CAMERA.contains(CAMERA.project(at)) & (rng.random(len(at)) < DETECTOR.hit)
    )
    x_axes = np.array([feature.rotation[:, 0] for feature in kind.features]) @ pose[:3, :3].T
    uv = CAMERA.project(at[seen]) + rng.normal(0.0, DETECTOR.sigma, (len(seen), 2))
    angle = screen_angle(x_axes[seen], at[seen]) + rng.normal(0.0, DETECTOR.turn, len(seen))
    looks = [kind.lobes.types[f] for f in seen] + [
        kb.appearance_types[i] for i in rng.integers(len(kb.appearance_types), size=CLUTTER)
    ]
    uv = np.concatenate([uv, rng.uniform(0.0, [CAMERA.width - 1.0, CAMERA.height - 1.0], (CLUTTER, 2))])
    angle = np.concatenate([angle, rng.uniform(0.0, 2.0 * np.pi, CLUTTER)]) % (2.0 * np.pi)
    order = rng.permutation(len(uv))
    rows = enumerate(order)
    data = (
        Appearance(f"d{n}", looks[i], (float(uv[i, 0]), float(uv[i, 1])), "simulated", angle=float(angle[i]))
        for n, i in rows
    )
    return Gamma(CAMERA, tuple(data))


def off(perceiver: Perceiver, gamma: Gamma, kind: ObjectType, truth: Floats) -> tuple[float, float] | None:
    """Rotation, radians, and share of the distance by which the best accepted hypothesis of the type is off.

    None where there is none.
    """
    from benchmarks.clutter.bench import ours

    accepted = [found for found in ours(perceiver, gamma)[0] if found.type == kind.name]
    if not accepted:
        return None
    return error(accepted[0].camera_from_object, kind, truth)


def error(pose: Floats, kind: ObjectType, truth: Floats) -> tuple[float, float]:
    """Rotation, radians, and share of the distance by which a pose is off."""
    turned, moved = pose_error(pose, truth, kind.symmetries)
    return float(turned), float(moved) / float(np.linalg.norm(truth[:3, 3]))


def _both(outcomes: Sequence[Outcome]) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    return [(o.mono, o.pair) for o in outcomes if o.mono is not None and o.pair is not None]


def _rows(outcomes: Sequence[Outcome]) -> list[dict[str, Any]]:
    """A row a side, over the trials in which both accept the type."""
    both = _both(outcomes)
    found = sum(o.mono is not None for o in outcomes), sum(o.pair is not None for o in outcomes)
    return [
        {
            "who": who,
            "trials": len(outcomes),
            "found": found[side],
            "depths": round(median(o.depths for o in outcomes)) if side else "",
            "turned, degrees": round(float(np.degrees(median(pair[side][0] for pair in both))), 3),
            "off, % of distance": round(100.0 * median(pair[side][1] for pair in both), 3),
            "p90, %": round(100.0 * float(np.percentile([pair[side][1] for pair in both], 90)), 3),
        }
        for side, who in enumerate(("one image", "the pair"))
    ]


def claims(outcomes: Sequence[Outcome]) -> list[Claim]:
    """The pair beats one image on pose error, and finds no fewer."""
    both = _both(outcomes)
    ratio = [median(pair[1][i] for pair in both) / median(pair[0][i] for pair in both) for i in (0, 1)]
    more = sum(o.pair is not None for o in outcomes) - sum(o.mono is not None for o in outcomes)
    return [
        Claim("place: the pair's median error over that of one image", "<=", 0.9, ratio[1]),
        Claim("rotation: the pair's median error over that of one image", "<=", 1.0, ratio[0]),
        Claim("objects found by the pair, less those found in one image", ">=", 0, more),
    ]


def _said(outcome: Outcome) -> str:
    sides = (
        "not found" if one is None else f"{np.degrees(one[0]):.2f} degrees, {100 * one[1]:.2f} %"
        for one in (outcome.mono, outcome.pair)
    )
    return "one image {}; pair {}; {} depths".format(*sides, outcome.depths)
