"""``plogic bench sizes``: knowledge bases of three sizes, written by hand, simulated with pictures and as Γ alone.

``--quick``: few scenes.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from benchmarks.recognition.score import Found, Tally, Truth, tally
from benchmarks.shared.claims import Claim, report
from benchmarks.sizes.types import SIZES, write_kb

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from plogic.run.perceive import Perceiver
    from sensing.appearance import Gamma
    from sensing.simulated.scene import Scene

SCENES, QUICK_SCENES = 20, 3
COVER = 0.05, 0.6
FROM_GAMMA, FROM_PICTURES = 0.90, 0.75
CAPTION = """\
Scenes of two objects of three types, every second with a decoy, as `plogic simulate` makes them of a knowledge base of things of 4 cm (small),
30 cm (middle) and 5 m (large). from: what `perceive` has, Γ by the KB's rates (`--gamma`) or the picture. there: objects at least half visible;
found: those that an accepted object of their type stands for; posed: within 5 degrees and 5 % of the distance; false: accepted objects that stand
for none. height: the least and the greatest share of the picture's height that an object covers. data: appearances in Γ, median."""


class Outcome(NamedTuple):
    """One scene, perceived from its Γ and from its picture."""

    gamma: Tally
    picture: Tally
    data: tuple[int, int]
    heights: tuple[float, ...]


def run(
    *, seed: int, quick: bool, as_json: bool, say: Callable[[str], None], scenes: int | None = None
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a scene on ``say``."""
    count, rows = scenes or (QUICK_SCENES if quick else SCENES), []
    with tempfile.TemporaryDirectory() as folder:
        for name in SIZES:
            write_kb(name, Path(folder) / name)
            rows += _rows(name, _of_size(Path(folder) / name, count, seed, say))
    text, met = report("sizes", rows, _claims(rows), as_json=as_json)
    return (text if as_json else f"{CAPTION}\n\n{text}"), met


def _of_size(folder: Path, count: int, seed: int, say: Callable[[str], None]) -> list[Outcome]:
    from plogic.run.perceive import Perceiver
    from plogic.run.sources import kb_of

    kb = kb_of(str(folder))
    perceiver, outcomes = Perceiver(kb), []
    for i in range(count):
        outcomes.append(one_scene(kb, perceiver, SCENES * seed + i))
        g, p = outcomes[-1].gamma, outcomes[-1].picture
        say(f"{folder.name}, {i + 1}/{count}: {g.found} of {g.there} from Γ, {p.found} from the picture")
    return outcomes


def one_scene(kb: KnowledgeBase, perceiver: Perceiver, seed: int) -> Outcome:
    """The scene of a seed, perceived twice, and compared with the truth."""
    from plogic.face.commands.simulate import Wanted, noise_of, reported_of, scene_of, standings_of
    from sensing.detectors.detector import detect

    scene = scene_of(kb, standings_of(kb.types), Wanted(decoys=seed % 2), seed)
    truths = truths_of(kb, scene)
    gammas = (
        reported_of(kb, scene, noise_of(seed)).gamma,
        detect(scene.photograph().image, scene.camera, kb.appearance_types),
    )
    of_gamma, of_picture = (_score(kb, perceiver, gamma, truths) for gamma in gammas)
    heights = tuple(float(np.ptp(truth.box[:, 1])) / scene.camera.height for truth in truths)
    return Outcome(of_gamma, of_picture, (len(gammas[0].appearances), len(gammas[1].appearances)), heights)


def _score(kb: KnowledgeBase, perceiver: Perceiver, gamma: Gamma, truths: Sequence[Truth]) -> Tally:
    from plogic.base.clock import Stopwatch
    from plogic.cycle.delta import Options

    _, cycle = perceiver.cycle(gamma, Options(), Stopwatch())
    found = [Found(one.type, one.camera_from_object) for one in cycle.accepted]
    return tally(found, truths, gamma.camera, {kind.name for kind in kb.types})


def truths_of(kb: KnowledgeBase, scene: Scene) -> tuple[Truth, ...]:
    """What stands there, decoys aside."""
    rows = zip(scene.bodies, scene.camera_from_bodies, scene.fractions, strict=True)
    return tuple(
        Truth(
            body.label,
            pose,
            fraction,
            _box(body.mesh.vertices @ pose[:3, :3].T + pose[:3, 3], scene.camera),
            (body.mesh.vertices.min(axis=0) + body.mesh.vertices.max(axis=0)) / 2.0,
            kb.type(body.label).symmetries,
        )
        for body, pose, fraction in rows
        if body.label is not None
    )


def _box(points: np.ndarray, camera: Camera) -> np.ndarray:
    uv = camera.project(points)
    return np.stack([uv.min(axis=0), uv.max(axis=0)])


def _rows(name: str, outcomes: Sequence[Outcome]) -> list[dict[str, Any]]:
    heights = [h for o in outcomes for h in o.heights]
    rows = []
    for source in ("gamma", "picture"):
        whole = sum((getattr(o, source) for o in outcomes), Tally())
        rows.append(
            {
                "kb": name,
                "from": source,
                "scenes": len(outcomes),
                "there": whole.there,
                "found": whole.found,
                "posed": whole.posed,
                "false": whole.false,
                "data": round(float(np.median([o.data[source == "picture"] for o in outcomes]))),
                "height": f"{min(heights):.2f} to {max(heights):.2f}",
                "least": min(heights),
                "most": max(heights),
            }
        )
    return rows


def _claims(rows: list[dict[str, Any]]) -> list[Claim]:
    claims = []
    for row in rows:
        least, most = row.pop("least"), row.pop("most")
        wanted = FROM_GAMMA if row["from"] == "gamma" else FROM_PICTURES
        said = f"{row['kb']}, {row['from']}: at least half visible, found"
        claims.append(Claim(said, ">=", wanted, row["found"] / max(1, row["there"])))
        if row["from"] == "gamma":
            claims.append(Claim(f"{row['kb']}: share of the picture's height, least", ">=", COVER[0], least))
            claims.append(Claim(f"{row['kb']}: share of the picture's height, most", "<=", COVER[1], most))
    return claims
