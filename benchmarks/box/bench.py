"""``plogic bench box``: a real cookie box in twenty frames of a hand-held video.

It is learned from one photo and judged against hand-marked corners.

The data is that of ``../shared/data`` (its README says whose), the clicked points and the marked corners of
``tests/scenes/box``; where either is absent the benchmark says so and fails. ``--quick`` leaves the ten YCB types out
of the knowledge base.
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.shared.claims import Claim, report
from geometry.frames import transform_points
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.run.perceive import Perceiver

ROOT = Path(__file__).parents[2]
DATA, MARKS = ROOT.parent / "shared" / "data" / "box", ROOT / "tests" / "scenes" / "box"
F, WRONG = 600.0, 2.6
"""The video's focal length, px, as far as it is known, and how many times too long that of the tutorial is which the
video comes from."""
SIZE = 640, 480
NEAR = 8.0
"""Pixels within which every marked corner must be reprojected."""
DRAWS = 2000
"""Resamplings of the frames for the interval of the drop."""


@dataclass(frozen=True)
class Answer:
    """What one frame gave.

    ``corners``: px from each marked corner to the accepted box's, none where no box was accepted; ``ev`` of the best
    box, accepted or not, ``wrong_ev`` of that with the wrong camera, 0 for none; ``others``: accepted types that are
    not there.
    """

    frame: str
    corners: tuple[float, ...]
    ev: float
    wrong_ev: float
    others: tuple[str, ...]
    seconds: float


def run(
    *,
    seed: int,
    quick: bool = False,
    picture: Path | None = None,
    as_json: bool = False,
    say: Callable[[str], None],
    **_: object,
) -> tuple[str, bool]:
    """Learn, look at every frame, judge; draw the frame of the greatest drop into ``picture``.

    Raises InputError where the data is not there or the types cannot be learned, SensingError where the picture cannot
    be written.
    """
    absent = [str(place) for place in (DATA / "photo.jpg", MARKS / "frame_corners.json") if not place.is_file()]
    if absent:
        raise InputError(f"bench box: needs {' and '.join(absent)}, not there")
    with tempfile.TemporaryDirectory(prefix="plogic-box-") as folder:
        kb = learned(Path(folder) / "kb", seed, quick=quick, say=say)
        answers = answered(kb, say)
        if picture is not None:
            from sensing.files.whole_files import write_whole

            write_whole(picture, drawn(kb, max(answers, key=lambda answer: answer.ev - answer.wrong_ev).frame))
    low, high = drop(answers)
    text, met = report("box", [_row(answer) for answer in answers], claims(answers), as_json=as_json)
    if as_json:
        return json.dumps(json.loads(text) | {"ev_drop_95": [low, high]}), met
    return (
        f"with f {WRONG:g} times too long, the box's ev drops by {low:.3f} to {high:.3f} (95 % of its mean over the frames)\n\n{text}",
        met,
    )


def learned(folder: Path, seed: int, *, quick: bool, say: Callable[[str], None]) -> KnowledgeBase:
    """A knowledge base of the box from its photo and, unless ``quick``, the YCB types.

    Raises InputError where these are not there.
    """
    from benchmarks.recognition.kb import LEARNING, learn_into
    from benchmarks.recognition.scenes import ycb_meshes
    from kb.files.read import read_kb
    from plogic.face.authoring.kb_learn_photo import learn_photo_command
    from plogic.face.shown.options import Photo

    learn_into(folder, {} if quick else ycb_meshes(), say, seed)
    sources = Photo(DATA / "photo.jpg", MARKS / "photo_points.yaml", mesh=DATA / "box.ply", units="cm")
    learn_photo_command(str(folder), ["box"], sources, replace(LEARNING, seed=seed), say=say)
    return read_kb(folder)


def answered(kb: KnowledgeBase, say: Callable[[str], None]) -> list[Answer]:
    """Every frame, at the right and at the wrong focal length."""
    from geometry.camera import centred_camera
    from plogic.run.perceive import Perceiver

    marked = json.loads((MARKS / "frame_corners.json").read_text(encoding="utf-8"))
    places = {name: np.array(place) / 100.0 for name, place in marked["corners"].items()}
    perceiver, right, wrong = Perceiver(kb), centred_camera(SIZE, F), centred_camera(SIZE, F * WRONG)
    answers = []
    for frame, corners in marked["frames"].items():
        start = perf_counter()
        beliefs, accepted = seen(kb, perceiver, DATA / frame, right)
        seconds = perf_counter() - start
        box = next((belief for belief in accepted if belief.object_type.name == "box"), None)
        off = () if box is None else _distances(box, right, [places[name] for name in corners], list(corners.values()))
        others = tuple(belief.object_type.name for belief in accepted if belief is not box)
        answers.append(
            Answer(frame, off, _best(beliefs), _best(seen(kb, perceiver, DATA / frame, wrong)[0]), others, seconds)
        )
        told = f"{max(off):.1f} px at most" if off else "not found"
        say(f"{frame}: {told}, ev {answers[-1].ev:.2f}, {answers[-1].wrong_ev:.2f} with the wrong camera")
    return answers


def seen(
    kb: KnowledgeBase, perceiver: Perceiver, frame: Path, camera: Camera
) -> tuple[list[Hypothesis], list[Hypothesis]]:
    """All hypotheses of a picture, and those accepted, best first."""
    from plogic.base.clock import Stopwatch
    from plogic.cycle.delta import Options
    from sensing.detectors.detector import detect
    from sensing.files.images import read_image

    gamma = detect(read_image(frame), camera, kb.sought, kb.words)
    delta, rejected, _ = perceiver.delta(gamma, Options(reading="posterior"), Stopwatch())
    accepted = sorted((b for b in delta.beliefs.values() if b.status == "accepted"), key=lambda b: -b.worth)
    return [*delta.beliefs.values(), *rejected], accepted


def drawn(kb: KnowledgeBase, frame: str) -> bytes:
    """A JPEG: the box's expected features in a frame, found and missed, at the right and at a wrong focal length."""
    import cv2

    from geometry.camera import centred_camera
    from plogic.cycle.delta import Options
    from plogic.face.shown.overlay import overlay
    from plogic.run.perceive import Perceiver
    from sensing.detectors.detector import detect
    from sensing.files.images import read_image

    image, perceiver, halves = read_image(DATA / frame), Perceiver(kb), []
    for f in (F, F * WRONG):
        gamma = detect(image, centred_camera(SIZE, f), kb.sought, kb.words)
        halves.append(overlay(perceiver(gamma, Options(reading="posterior"), image), image, "all"))
    height = max(len(half) for half in halves)
    whole = np.hstack([np.pad(half, ((0, height - len(half)), (0, 0), (0, 0)), mode="edge") for half in halves])
    small = cv2.resize(whole, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    return bytes(cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes())


def _best(beliefs: Sequence[Hypothesis]) -> float:
    """The explanatory value of the box that beats clutter by most."""
    boxes = [belief for belief in beliefs if belief.object_type.name == "box"]
    return float(max(boxes, key=lambda belief: belief.worth).ev or 0.0) if boxes else 0.0


def _distances(box: Hypothesis, camera: Camera, places: Sequence[Any], pixels: Sequence[Any]) -> tuple[float, ...]:
    uv = camera.project(transform_points(box.camera_from_object, places))
    return tuple(np.linalg.norm(uv - np.array(pixels), axis=1).tolist())


def claims(answers: Sequence[Answer]) -> list[Claim]:
    """What was promised."""
    corners = np.array([off for answer in answers for off in answer.corners] or [np.inf])
    return [
        Claim(
            f"frames of {len(answers)} in which the box is found, every corner within {NEAR:g} px",
            ">=",
            19,
            _found(answers),
        ),
        Claim("median distance of a corner from its mark, px", "<=", NEAR, float(np.median(corners))),
        Claim("largest distance of a corner from its mark, px", "<=", NEAR, float(corners.max())),
        Claim("objects accepted that are not there", "<=", 0, sum(len(answer.others) for answer in answers)),
    ]


def _found(answers: Sequence[Answer]) -> int:
    return sum(bool(answer.corners) and max(answer.corners) <= NEAR for answer in answers)


def drop(answers: Sequence[Answer]) -> tuple[float, float]:
    """The 95 % interval of the mean paired drop of ev, by resampling frames."""
    pairs = np.array([answer.ev - answer.wrong_ev for answer in answers])
    drawn = np.random.default_rng(0).choice(pairs, (DRAWS, len(pairs))).mean(axis=1)
    low, high = np.quantile(drawn, [0.025, 0.975])
    return float(low), float(high)


def _row(answer: Answer) -> dict[str, Any]:
    return {
        "frame": answer.frame,
        "corners px, median": round(float(np.median(answer.corners)), 1) if answer.corners else None,
        "largest": round(max(answer.corners), 1) if answer.corners else None,
        "ev": round(answer.ev, 3),
        "ev, wrong f": round(answer.wrong_ev, 3),
        "others": ", ".join(answer.others) or "none",
        "seconds": round(answer.seconds, 2),
    }
