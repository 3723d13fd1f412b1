"""What ``plogic bench recognition`` prints: both sides over all scenes, ours by type and by hardness, the claims."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

from benchmarks.recognition.peer import SEEN, accepted, best_setting, settings
from benchmarks.recognition.scenes import PLAIN
from benchmarks.recognition.score import Tally, tally
from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from benchmarks.recognition.bench import Answer
    from benchmarks.recognition.peer import Setting
    from benchmarks.recognition.score import Found

CAPTION = """\
there: objects at least half visible; found: those that an accepted object of their type stands for, its centre within the box of their picture;
posed: of these, within 5 degrees and 5 % of the distance, up to symmetries; false: accepted objects that stand for none, in scenes with none of
the types too; empty: these alone. Who stands for an object less than half visible does not count. F1 of the identities; pose F1 of those posed.
peer: SIFT ratio test against the same learned keypoints, OpenCV's USAC RANSAC per type, of keypoints alone or (with --quick) with the points along
edges that ours sees too, at the ratio, inlier threshold (pixels) and least number of inliers with the best F1 over these very scenes; peer by pose
F1: at those with the best pose F1. Its seconds are those of one setting. hard: how hard light and camera were made (0 good; 1 over-exposed, noisy,
blurred), seconds: median of wall time a picture of 640 x 480."""
NOTHING = Tally()
LEAD = 0.001
"""What counts as above the peer."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """The answers, the types with and without texture, and the peer's best settings by F1 and by pose F1."""

    answers: tuple[Answer, ...]
    textured: frozenset[str]
    plain: frozenset[str]
    by_f1: Setting
    by_pose_f1: Setting

    def mine(self, types: Collection[str], answers: Sequence[Answer] | None = None) -> Tally:
        """Our counts of these types."""
        return _total(self.answers if answers is None else answers, types, _ours)

    def peers(self, types: Collection[str], setting: Setting) -> Tally:
        """The peer's."""
        return _total(self.answers, types, lambda a: accepted(a.peer, setting))


def judged(answers: Sequence[Answer]) -> Verdict:
    """Give the peer its best settings, and sort the types."""
    names = {t.type for a in answers for t in a.case.truths} | {f.type for a in answers for f in a.found}
    names |= {c.found.type for a in answers for some in a.peer.values() for c in some}
    textured = frozenset(names - set(PLAIN))
    seen = [name for name in SEEN if any(key[0] == name for a in answers for key in a.peer)]
    tallies = {s: _total(answers, textured, lambda a, s=s: accepted(a.peer, s)) for s in settings(seen)}  # type: ignore[misc]
    return Verdict(
        tuple(answers),
        textured,
        frozenset(names & set(PLAIN)),
        best_setting({s: t.f1 for s, t in tallies.items()}),
        best_setting({s: t.pose_f1 for s, t in tallies.items()}),
    )


def _total(answers: Sequence[Answer], types: Collection[str], found: Callable[[Answer], Sequence[Found]]) -> Tally:
    return sum((tally(found(a), a.case.truths, a.case.camera, types) for a in answers), NOTHING)


def rows(verdict: Verdict) -> list[dict[str, Any]]:
    """Both sides on the textured types and on the plain ones; then ours by type, and by hardness."""
    v = verdict
    listed = []
    for group, types in (("", v.textured), (", plain", v.plain)):
        listed.append(
            _row(f"ours{group}", v.mine(types), _in_empty(v, types, _ours), median(a.seconds for a in v.answers))
        )
        for name, setting in (("peer", v.by_f1), ("peer by pose F1", v.by_pose_f1)):
            empty = _in_empty(v, types, lambda a, s=setting: accepted(a.peer, s))  # type: ignore[misc]
            listed.append(
                _row(
                    f"{name}{group}",
                    v.peers(types, setting),
                    empty,
                    median(a.peer_seconds[setting.seen] for a in v.answers),
                )
            )
    listed += [_row(name, v.mine({name}), _in_empty(v, {name}, _ours)) for name in sorted(v.textured | v.plain)]
    for hard in sorted({a.case.hard for a in v.answers}):
        some = [a for a in v.answers if a.case.hard == hard]
        false = sum(f.type in v.textured for a in some if a.case.empty for f in a.found)
        listed.append(_row(f"hard {hard:g}", v.mine(v.textured, some), false, median(a.seconds for a in some)))
    return listed


def _row(name: str, t: Tally, empty: int, seconds: float | None = None) -> dict[str, Any]:
    shares = {"recall": t.recall, "precision": t.precision, "poses": t.poses, "F1": t.f1, "pose F1": t.pose_f1}
    counts = {"there": t.there, "found": t.found, "posed": t.posed, "false": t.false, "empty": empty}
    return {
        "row": name,
        **counts,
        **{k: round(x, 3) for k, x in shares.items()},
        "seconds": "" if seconds is None else f"{seconds:.2f}",
    }


def _ours(answer: Answer) -> Sequence[Found]:
    return answer.found


def peer_said(verdict: Verdict) -> str:
    """A line with the peer's best settings."""
    return f"peer at its best: {verdict.by_f1}; by pose F1: {verdict.by_pose_f1}"


def _in_empty(v: Verdict, types: Collection[str], found: Callable[[Answer], Sequence[Found]]) -> int:
    return sum(f.type in types for a in v.answers if a.case.empty for f in found(a))


def claims(verdict: Verdict) -> list[Claim]:
    """The issue's bars; those of F1 are the peer's best, and must be exceeded."""
    v = verdict
    mine = v.mine(v.textured)
    peer, posed = v.peers(v.textured, v.by_f1).f1, v.peers(v.textured, v.by_pose_f1).pose_f1
    empty = _in_empty(v, v.textured | v.plain, _ours)
    return [
        Claim("textured, at least half visible: identity recall", ">=", 0.90, mine.recall),
        Claim("textured: identity precision", ">=", 0.97, mine.precision),
        Claim("of the found: rotation <= 5 deg and translation <= 5 % of the distance", ">=", 0.85, mine.poses),
        Claim("F1 of identities less the peer's best", ">=", LEAD, mine.f1 - peer),
        Claim("F1 of identities with the right pose less the peer's best", ">=", LEAD, mine.pose_f1 - posed),
        Claim("accepted in scenes with none of the types", "<=", 0, empty),
        Claim("seconds a picture, median", "<=", 3, median(a.seconds for a in v.answers)),
    ]
