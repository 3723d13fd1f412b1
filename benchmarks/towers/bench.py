"""``plogic bench towers``: random scenes of the two towers and of decoys, judged against the simulator's truth."""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.shared.claims import Claim, report
from geometry.frames import pose_error
from plogic.base.clock import Stopwatch

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.document import HypothesisRow, Interpretation, RejectedRow, RelationRow
    from plogic.facts.situation import PairFact
    from plogic.run.perceive import Perceiver
    from sensing.simulated.scene import Scene

PLAN = (
    "hiding",
    "beside",
    "hiding",
    "single",
    "hiding",
    "decoys",
    "hiding",
    "beside",
    "hiding",
    "single",
    "hiding",
    "decoys",
)
"""The kinds of scenes, over and over: half of them with one tower partly hiding the other, a sixth with none but
decoys."""
ROTATION, TRANSLATION = np.radians(3.0), 0.02
"""A pose is right within this many radians and this share of the distance, up to the type's symmetries."""
HALF = 0.5
"""Share of a tower's picture that must be visible for it to count."""


@dataclass(frozen=True)
class Outcome:
    """One scene: its kind, per true tower whether it counts, is found and is posed right; false reports.

    The relation.
    """

    kind: str
    seed: int
    countable: bool
    found: tuple[bool, ...]
    posed: tuple[bool, ...]
    reported: int
    false: int
    relation: bool | None
    seconds: dict[str, float] = field(default_factory=dict)


def run(scenes: int, seed: int, *, as_json: bool, say: Callable[[str], None]) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a scene on ``say``."""
    from plogic.run.perceive import Perceiver
    from plogic.run.sources import kb_of

    kb = kb_of("towers")
    clock = Stopwatch()
    with clock.stage("index"):
        perceiver = Perceiver(kb)
    outcomes = []
    for i in range(scenes):
        outcome = one_scene(kb, perceiver, PLAN[i % len(PLAN)], 1000 * seed + i)
        outcomes.append(outcome)
        say(
            f"{i + 1}/{scenes} {outcome.kind}: posed {outcome.posed}, {outcome.false} false, relation {outcome.relation}"
        )
    return report("towers", _rows(outcomes, clock), _claims(outcomes), as_json=as_json)


def one_scene(kb: KnowledgeBase, perceiver: Perceiver, kind: str, seed: int) -> Outcome:
    """Render, perceive from the pixels, and only then compare with the truth."""
    from plogic.cycle.delta import Options
    from sensing.detectors.detector import detect

    scene = scene_of(kb, kind, seed)
    image = scene.photograph().image
    clock = Stopwatch()
    with clock.stage("detect"):
        gamma = detect(image, scene.camera, kb.appearance_types)
    document = perceiver(gamma, Options(), image, clock)
    return judged(kb, kind, seed, scene, document, clock)


def scene_of(kb: KnowledgeBase, kind: str, seed: int) -> Scene:
    """A scene of one kind; the seed decides which tower stands alone and how many decoys there are."""
    from plogic.face.commands.simulate import shapes_of
    from sensing.simulated.scene import random_scene

    shapes = shapes_of(kb)
    if kind == "decoys":
        return random_scene([], seed, decoys=2 + seed % 3)
    if kind == "single":
        return random_scene([shapes[seed // 2 % len(shapes)]], seed, decoys=seed % 2)
    return random_scene(shapes, seed, placement="hiding" if kind == "hiding" else "beside")


def judged(
    kb: KnowledgeBase, kind: str, seed: int, scene: Scene, document: Interpretation, clock: Stopwatch
) -> Outcome:
    """Compare Δi with the truth: towers are matched by type and least rotation error."""
    accepted = [h for h in document["hypotheses"] if h["status"] == "accepted"]
    truth = [
        (body.label, pose, fraction)
        for body, pose, fraction in zip(scene.bodies, scene.camera_from_bodies, scene.fractions, strict=True)
        if body.label is not None
    ]
    of_truth = [_best(kb, label, pose, accepted) for label, pose, _ in truth]
    posed = tuple(right for _, right in of_truth)
    used = {name for name, _ in of_truth if name is not None}
    return Outcome(
        kind=kind,
        seed=seed,
        countable=bool(truth) and all(fraction >= HALF for *_, fraction in truth),
        found=tuple(name is not None for name, _ in of_truth),
        posed=posed,
        reported=len(accepted),
        false=sum(h["id"] not in used for h in accepted),
        relation=_relation_right(kb, truth, [name for name, _ in of_truth], document, scene)
        if len(truth) == 2
        else None,
        seconds=clock.seconds,
    )


def _best(
    kb: KnowledgeBase, label: str, pose: NDArray[np.float64], accepted: Sequence[HypothesisRow | RejectedRow]
) -> tuple[str | None, bool]:
    """The accepted hypothesis of this type that lies nearest, and whether its pose is right."""
    errors = []
    for h in accepted:
        if h["type"] == label:
            turned, moved = pose_error(np.array(h["T_camera_object"]), pose, kb.type(label).symmetries)
            share = float(moved) / float(np.linalg.norm(pose[:3, 3]))
            errors.append((float(turned), share, h["id"]))
    if not errors:
        return None, False
    rotation, share, name = min(errors)
    return name, bool(rotation <= ROTATION and share <= TRANSLATION)


def _relation_right(
    kb: KnowledgeBase,
    truth: Sequence[tuple[str, NDArray[np.float64], float]],
    names: Sequence[str | None],
    document: Interpretation,
    scene: Scene,
) -> bool:
    """Whether the most probable relation of the reported towers is that of the true poses, by outlines and depth."""
    from geometry.visibility.occlusion import PosedSurface, occlusion
    from plogic.facts.situation import pair_facts

    posed = []
    for label, pose, _ in truth:
        surface = kb.type(label).surface
        if surface is None:
            return False
        posed.append(PosedSurface(surface.vertices, surface.triangles, surface.rays, pose))
    if None in names:
        return False
    right = pair_facts(occlusion(posed[0], posed[1], scene.camera), str(names[0]), str(names[1]))[0]
    rows = [r for r in document["relations"] if set(r["args"]) == set(names)]
    likeliest = max(rows, key=lambda r: float(r["probability"]), default=None)
    return likeliest is not None and _same(right, likeliest)


def _same(right: PairFact, row: RelationRow) -> bool:
    """Whether a reported relation is the right one, of the right ordered pair."""
    either_way = right.relation in {"non_occludes", "mutually_occludes"}
    return right.relation == row["relation"] and (either_way or row["args"] == [right.x, right.y])


def _share(values: Sequence[bool]) -> float:
    return sum(values) / len(values) if values else 1.0


def _claims(outcomes: Sequence[Outcome]) -> list[Claim]:
    two = [o for o in outcomes if len(o.posed) == 2 and o.countable]
    every = [o for o in outcomes if o.countable]
    whole = [_per_image(o) for o in outcomes]
    return [
        Claim(
            "scenes with both towers at least half visible: both identities and poses right",
            ">=",
            0.95,
            _share([all(o.posed) for o in two]),
        ),
        Claim(
            "scenes whose towers are all at least half visible: identities and poses right",
            ">=",
            0.95,
            _share([all(o.posed) for o in every]),
        ),
        Claim(
            "towers reported in scenes that have none", "<=", 0, sum(o.reported for o in outcomes if o.kind == "decoys")
        ),
        Claim(
            "occlusion relation right, both at least half visible", ">=", 0.95, _share([bool(o.relation) for o in two])
        ),
        Claim("seconds an image, detection to document, median", "<=", 1.0, median(whole)),
    ]


def _per_image(outcome: Outcome) -> float:
    return sum(outcome.seconds.values())


def _rows(outcomes: Sequence[Outcome], clock: Stopwatch) -> list[dict[str, Any]]:
    """A row a kind of scene, then a row of milliseconds a stage (median; the index is built once)."""
    rows = []
    for kind in ("hiding", "beside", "single", "decoys"):
        mine = [o for o in outcomes if o.kind == kind]
        towers = [right for o in mine for right in o.posed]
        rows.append(
            {
                "row": kind,
                "scenes": len(mine),
                "towers": len(towers),
                "found": sum(f for o in mine for f in o.found),
                "posed": sum(towers),
                "false": sum(o.false for o in mine),
                "relation right": sum(bool(o.relation) for o in mine),
                "median ms": round(1000 * median([_per_image(o) for o in mine])) if mine else 0,
            }
        )
    stages = list(outcomes[0].seconds)
    times = {s: median([o.seconds[s] for o in outcomes]) for s in stages} | clock.seconds
    rows += [
        {"row": f"stage {s}", **dict.fromkeys(list(rows[0])[1:-1], ""), "median ms": round(1000 * t)}
        for s, t in times.items()
    ]
    return rows
