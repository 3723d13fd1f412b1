"""What ``plogic settle`` says of worlds that were found, and of the same with one object out of its place.

``python benchmarks/let_go.py [--seeds FIRST..LAST]``: in each scene two to three boxes of the shipped ``first``, 1 to
2 m away, are reported as detectors do that are as good as its ``kb.yaml`` says. In every second scene one of them
stands on another. The best world is let go as it was found; with one object lifted by 5 cm; and with a stack's lower
object taken away. What was lifted should fall, and what stands on what is missing, and nothing else. Objects whose pose
is not within a tenth of their diameter of the true one (ADD) are told apart: a wrong world may fall.

``--pictures KB DATASET``: instead, rendered pictures with the models of DATASET, in BOP layout, which are the types of
KB, by number or by name: scenes as of ``plogic bench support``, of other seeds. What is held in the air or leans there
should stay where it is, for it is free; what stands on what is not found may do either, and is left out.
"""

import argparse
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.photos.answers import Looker
from benchmarks.photos.knowledge import resting
from benchmarks.photos.scenes import as_symmetric
from benchmarks.photos.table import measure_of
from benchmarks.support.bench import scenes_with
from geometry.arrays import Floats
from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from plogic import perceive
from plogic.facts.document import HypothesisRow, Interpretation, RejectedRow
from plogic.run.bop.models import ids_of, model_names
from plogic.run.settling import ObjectRow, settled
from plogic.run.simulated_gamma import Posed, simulated_gamma
from plogic.run.sources import kb_of

LIFT = 0.05
HIGH = 0.16
"""Of the box, m."""
MIDDLE = np.array([0.0, 0.0, 0.1])
"""What the camera looks at, m."""
RIGHT = 0.1
"""Of the diameter, within which a pose is right."""
SEEDS = "0..59"
RENDERED = 70_000
"""Of the first picture: those of ``plogic bench support`` are from 40000 on."""
FLOOR, AIR, LOST = "the floor", "nothing", "what is not found"


def scene(seed: int) -> tuple[Camera, list[Floats], bool]:
    """A camera above a floor, world_from_object of boxes, and whether the last stands on the first."""
    rng = np.random.default_rng([seed, 42])
    stacked = seed % 2 == 1
    around = rng.uniform(0.0, 2.0 * np.pi)
    places = [(0.24 * np.cos(around + k), 0.24 * np.sin(around + k), 0.0) for k in (0.0, np.pi)]
    places += [(places[0][0] + rng.uniform(-0.03, 0.03), places[0][1] + rng.uniform(-0.03, 0.03), HIGH)] * stacked
    poses = [_turned(rng.uniform(0.0, 2.0 * np.pi), place) for place in places]
    high, side, far = np.radians(rng.uniform(25.0, 60.0)), rng.uniform(0.0, 2.0 * np.pi), rng.uniform(1.0, 2.0)
    eye = far * np.array([np.cos(high) * np.cos(side), np.cos(high) * np.sin(side), np.sin(high)]) + MIDDLE
    K = np.array([[600.0, 0.0, 319.5], [0.0, 600.0, 239.5], [0.0, 0.0, 1.0]])
    camera = Camera(640, 480, K, world_from_camera=inverse(look_at(eye, MIDDLE)))
    return camera, poses, stacked


def _turned(angle: float, place: tuple[float, float, float]) -> Floats:
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    pose[:3, 3] = place
    return pose


class Found(NamedTuple):
    """A world that was found: its document, and of each present hypothesis what it stands on in truth.

    ``on``: another hypothesis, or FLOOR, AIR, or LOST, which is not found. ``right``: whose pose is. ``up`` (3,): away
    from the floor, camera frame.
    """

    document: Interpretation
    on: Mapping[str, str]
    right: set[str]
    up: Floats


def found(seed: int) -> Found:
    """What is found of simulated boxes."""
    camera, poses, stacked = scene(seed)
    kb, camera_from_world = kb_of("first"), inverse(np.asarray(camera.world_from_camera))
    truths = [camera_from_world @ pose for pose in poses]
    reported = simulated_gamma(kb, [Posed("box", pose) for pose in truths], camera, np.random.default_rng([seed, 43]))
    document = perceive(reported.gamma, "first").document
    document["gravity"] = {"unknown_support": 0.1, "ground": 0.0}
    surface = kb.type("box").surface
    assert surface is not None  # noqa: S101 - it is shipped with one
    who, right = {}, set()
    for name in document["worlds"][0]["present"]:
        pose = np.array(_row(document, name)["T_camera_object"])
        moved = [
            transform_points(pose, surface.vertices) - transform_points(truth, surface.vertices) for truth in truths
        ]
        add = [float(np.linalg.norm(rows, axis=1).mean()) for rows in moved]
        who[name] = int(np.argmin(add))
        right |= {name} if min(add) < RIGHT * surface.diameter else set()
    lower = next((name for name in who if who[name] == 0), LOST)
    on = {name: lower if stacked and box == len(poses) - 1 else FLOOR for name, box in who.items()}
    return Found(document, on, right, camera_from_world[:3, 2])


def pictured(kb_folder: str, dataset: Path, seeds: range) -> Iterator[Found]:
    """What is found in rendered pictures."""
    kb = resting(kb_of(kb_folder), maybe=True)
    names = [kind.name for kind in kb.types]
    known = model_names(dataset / "models") | ids_of(names, {})
    numbers = {name: known[name] for name in names if name in known}
    looker, measure = Looker(kb, numbers), measure_of(kb, numbers, dataset / "models")
    measure = measure._replace(models=as_symmetric(measure.models))
    for stood in scenes_with(kb, numbers, dataset, seeds):
        document = looker.looked(stood.shown).document
        present = set(document["worlds"][0]["present"]) if document["worlds"] else set()
        answers = {name: posed for name, posed in looker.accepted(document).items() if name in present}
        _, told = measure.counted(stood.shown, list(answers.values()))
        stands_for = [next((name for name, posed in answers.items() if posed is row.answer), LOST) for row in told]
        rows = zip(stands_for, told, stood.stances, strict=True)
        on = {
            name: AIR if how.kind == "free" else FLOOR if how.on is None else stands_for[how.on]
            for name, row, how in rows
            if row.found
        }
        right = {name for name, row in zip(stands_for, told, strict=True) if row.right}
        yield Found(document, on, right, stood.plane.up)


def _row(document: Interpretation, name: str) -> HypothesisRow | RejectedRow:
    return next(row for row in document["hypotheses"] if row["id"] == name)


def trials(one: Found, turn: int) -> Iterator[tuple[str, ObjectRow, str, bool]]:
    """What is done, each object's row, what should become of it, and whether its pose and those below it are right."""
    document, on = one.document, one.on
    if document["worlds"]:
        yield from _let_go("as found", one, document, set())
    tops = [name for name in sorted(on) if on[name] != AIR and name not in on.values()]
    if tops:
        lifted, other = tops[turn // 2 % len(tops)], deepcopy(document)
        row = _row(other, lifted)
        pose = np.array(row["T_camera_object"])
        pose[:3, 3] += LIFT * one.up
        row["T_camera_object"] = pose.tolist()
        yield from _let_go(f"one lifted by {100 * LIFT:.0f} cm", one, other, {lifted})
    upper = next((name for name in sorted(on) if on[name] in on), None)
    if upper is not None:
        lower, taken = on[upper], deepcopy(document)
        left = [name for name in document["worlds"][0]["present"] if name != lower]
        taken["worlds"] = [{"probability": 1.0, "present": left}]
        above = {name for name in on if lower in _below(name, on)}
        yield from _let_go("a stack's lower taken away", one, taken, above, drop=True)


def _below(name: str, on: Mapping[str, str]) -> Iterator[str]:
    """All that something stands on."""
    while name in on:
        name = on[name]
        yield name


def _let_go(
    what: str, one: Found, document: Interpretation, falls: set[str], *, drop: bool = False
) -> Iterator[tuple[str, ObjectRow, str, bool]]:
    """``drop``: what is free is let go as well."""
    for row in settled(document, drop=drop)["worlds"][0]["objects"]:
        name = row["id"]
        below = list(_below(name, one.on))
        should = "fall" if name in falls or (drop and AIR in below) else "hold" if AIR in below else "stand"
        if LOST not in below and name in one.on:
            yield what, row, should, {name, *below} & one.on.keys() <= one.right


def main(scenes: Iterable[Found]) -> None:
    """Print how many objects are told right, and how far those that should stand are moved."""
    counts: Counter[tuple[str, bool, str, str]] = Counter()
    shares: list[float] = []
    for turn, one in enumerate(scenes):
        for what, row, should, right in trials(one, turn):
            counts[what, right, should, row["verdict"]] += 1
            if what == "as found" and right and should == "stand":
                shares.append(row["moved"] / row["allowed"])
    lines = [f"{'what':28} {'pose':6} {'should':7} {'verdict':11} objects"]
    lines += [
        f"{what:28} {'right' if right else 'wrong':6} {should:7} {verdict:11} {number}"
        for (what, right, should, verdict), number in sorted(counts.items(), reverse=True)
    ]
    told = np.percentile(shares, [50, 90, 100]) if shares else np.zeros(3)
    lines.append(
        f"moved as found, shares of what is allowed: median {told[0]:.2f}, 90 % {told[1]:.2f}, most {told[2]:.2f}"
    )
    print("\n".join(lines))  # noqa: T201 - a script


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seeds", default=SEEDS, metavar="FIRST..LAST", help=f"default: {SEEDS}")
    parser.add_argument("--pictures", nargs=2, metavar=("KB", "DATASET"))
    asked = parser.parse_args()
    first, _, last = asked.seeds.partition("..")
    seeds = range(int(first), int(last) + 1)
    if asked.pictures is None:
        main(map(found, seeds))
    else:
        kb, dataset = asked.pictures
        main(pictured(kb, Path(dataset), range(RENDERED + seeds.start, RENDERED + seeds.stop)))
