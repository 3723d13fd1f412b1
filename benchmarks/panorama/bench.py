"""``plogic bench panorama``: a camera that turns away from the two towers and back.

What is remembered, and what remembering spares.

Each sequence has five frames, rendered and detected from their pixels: the scene; turned by some 25 degrees; turned
away, with nothing in view; and back again. No frame is taken from quite the same place as another, and none has
another's noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.shared.claims import Claim, report
from benchmarks.shared.processor import processor_seconds
from benchmarks.towers.bench import scene_of
from geometry.frames import pose_error

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.run.perceive import Perceiver
    from plogic.sequence.constancy.sight_lines import View
    from plogic.sequence.views.panorama import Known, Look, Panorama
    from sensing.simulated.scene import Scene

    Floats = NDArray[np.float64]

SEQUENCES, QUICK = 20, 3
KINDS = "hiding", "beside"
TURNS = 0.0, 25.0, 75.0, 25.0, 0.0
"""Degrees by which the camera has turned, frame by frame; the sequence says to which side."""
OFF = 2.0, 0.05
"""Degrees and metres, at most along each axis, by which a frame is taken from elsewhere."""
ROTATION, TRANSLATION = np.radians(2.0), 0.02
"""A pose is right within this many radians and this share of the distance, up to the type's symmetries."""
FIRST_SEED = 30_000


@dataclass(frozen=True)
class Outcome:
    """One sequence: towers of the first frame that came back under their names and stand right; the last's times."""

    seed: int
    told: int
    false: int
    kept: tuple[bool, ...]
    posed: tuple[bool, ...]
    away: int
    searched: bool
    warm: float
    cold: float


def run(*, seed: int, quick: bool, as_json: bool, say: Callable[[str], None]) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a sequence on ``say``."""
    from plogic.run.perceive import Perceiver
    from plogic.run.sources import kb_of

    kb = kb_of("towers")
    perceiver = Perceiver(kb)
    outcomes = []
    for i in range(QUICK if quick else SEQUENCES):
        outcomes.append(one_sequence(kb, perceiver, FIRST_SEED + 1000 * seed + i, KINDS[i % len(KINDS)]))
        o = outcomes[-1]
        search = "searched" if o.searched else "no search"
        say(
            f"{i + 1}: {sum(o.kept)} of {o.told} kept, {sum(o.posed)} posed, {search}, {o.warm:.2f} s, cold {o.cold:.2f} s"
        )
    return report("panorama", _rows(outcomes), claims(outcomes), as_json=as_json)


def one_sequence(kb: KnowledgeBase, perceiver: Perceiver, seed: int, kind: str) -> Outcome:
    """Look, turn away, come back; only then compare with the truth."""
    from plogic.cycle.delta import Options
    from plogic.sequence.views.panorama import Panorama

    scene, rng = scene_of(kb, kind, seed), np.random.default_rng([seed, 7])
    panorama, side = Panorama(perceiver, Options(reading="posterior")), float(rng.choice([-1.0, 1.0]))
    first: list[Known] = []
    away = 0
    for number, turn in enumerate(TURNS, 1):
        view = taken(elsewhere(scene, side * turn, rng), number, kb)
        start = processor_seconds()
        look = panorama.look(view)
        warm = processor_seconds() - start
        first = first or list(panorama.known)
        away = max(away, *(known.age for known in panorama.known), 0)
    start = processor_seconds()
    perceiver(look.view.gamma, Options(reading="posterior"))
    cold = processor_seconds() - start
    return judged(kb, scene, panorama, first, look, (seed, away, warm, cold))


def elsewhere(scene: Scene, degrees: float, rng: np.random.Generator) -> Scene:
    """The same scene from a camera turned about the vertical by so much, and moved a little, with noise of its own."""
    pose = scene.camera.world_from_camera
    if pose is None:
        raise ValueError("a scene's camera has a place")
    turned = Rotation.from_rotvec([0.0, 0.0, np.radians(degrees)]) * Rotation.from_rotvec(
        np.radians(rng.uniform(-OFF[0], OFF[0], 3))
    )
    moved = np.eye(4)
    moved[:3, :3] = turned.as_matrix() @ pose[:3, :3]
    moved[:3, 3] = pose[:3, 3] + rng.uniform(-OFF[1], OFF[1], 3)
    sensor = replace(scene.sensor, seed=int(rng.integers(2**31)))
    return replace(scene, camera=replace(scene.camera, world_from_camera=moved), sensor=sensor)


def taken(scene: Scene, number: int, kb: KnowledgeBase) -> View:
    """What is detected in the scene's picture."""
    from plogic.sequence.constancy.sight_lines import View
    from sensing.detectors.detector import detect

    gamma = detect(scene.photograph().image, scene.camera, kb.appearance_types)
    return View(f"v{number}", gamma, np.asarray(scene.camera.world_from_camera))


def judged(
    kb: KnowledgeBase,
    scene: Scene,
    panorama: Panorama,
    first: Sequence[Known],
    look: Look,
    more: tuple[int, int, float, float],
) -> Outcome:
    """Compare Δp at the end with the truth, and with what it was after the first frame.

    ``more``: seed, age, seconds warm and cold.
    """
    truth = [(body.label, body.world_from_body) for body in scene.bodies if body.label is not None]
    eye = np.asarray(scene.camera.world_from_camera)[:3, 3]
    told = [known for known in first if any(right(kb, known, label, pose, eye) for label, pose in truth)]
    now = {known.id: known for known in panorama.known}
    posed = [k.id in now and any(right(kb, now[k.id], label, pose, eye) for label, pose in truth) for k in told]
    kept = [
        k.id in now and now[k.id].age == 0 and now[k.id].standing.object_type.name == k.standing.object_type.name
        for k in told
    ]
    events = {step["event"] for step in look.interpretation["trace"]}
    seed, away, warm, cold = more
    return Outcome(
        seed, len(told), len(first) - len(told), tuple(kept), tuple(posed), away, "no search" not in events, warm, cold
    )


def right(kb: KnowledgeBase, known: Known, label: str, pose: Floats, eye: Floats) -> bool:
    """Whether an object of Δp is of this type and stands at this pose in the world."""
    if known.standing.object_type.name != label:
        return False
    turned, moved = pose_error(known.standing.world_from_object, pose, kb.type(label).symmetries)
    return bool(turned <= ROTATION and moved <= TRANSLATION * np.linalg.norm(pose[:3, 3] - eye))


def _rows(outcomes: Sequence[Outcome]) -> list[dict[str, Any]]:
    return [
        {
            "sequences": len(outcomes),
            "towers told": sum(o.told for o in outcomes),
            "false": sum(o.false for o in outcomes),
            "kept": sum(sum(o.kept) for o in outcomes),
            "posed": sum(sum(o.posed) for o in outcomes),
            "views away": median(o.away for o in outcomes),
            "searched": sum(o.searched for o in outcomes),
            "s back": round(median(o.warm for o in outcomes), 3),
            "s cold": round(median(o.cold for o in outcomes), 3),
        }
    ]


def claims(outcomes: Sequence[Outcome]) -> list[Claim]:
    """The issue's bars."""
    told = max(sum(o.told for o in outcomes), 1)
    return [
        Claim(
            "towers, told rightly at first, that are back under their names",
            ">=",
            1.0,
            sum(sum(o.kept) for o in outcomes) / told,
        ),
        Claim(
            "their poses in the world within 2 degrees and 2 %", ">=", 1.0, sum(sum(o.posed) for o in outcomes) / told
        ),
        Claim("sequences that needed a search on return", "<=", 0, sum(o.searched for o in outcomes)),
        Claim(
            "seconds of the last frame, all told, over those of the same Γ cold, median",
            "<=",
            1.0,
            median(o.warm / o.cold for o in outcomes),
        ),
    ]
