"""``plogic bench photos``.

All types of a dataset of real photos in one knowledge base, learned from its models, each photo perceived; beside it
SIFT's ratio test with RANSAC on the same learned keypoints, at the setting that is best over these very photos. The
datasets lie in ``../shared/data/photos``, or where ``PLOGIC_PHOTOS`` says.
"""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

from benchmarks.photos.score import RIGHT as ADD
from benchmarks.photos.score import Counts, Posed, counted
from benchmarks.recognition.peer import SEEN, Peer, accepted, settings
from benchmarks.shared.claims import Claim, report
from plogic.base.errors import InputError
from plogic.face.shown.options import Learning

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from benchmarks.recognition.peer import Candidates
    from kb.clouds.cloud import KnowledgeBase
    from plogic.run.bop.dataset import Dataset, Frame

FOLDER = Path(os.environ.get("PLOGIC_PHOTOS", "../shared/data/photos"))
SETS = "ycb", "lmo"
VISIBLE = 0.1
"""What is less visible is not asked for."""
RIGHT = {"ycb": 11, "lmo": 10}
FOUND = {"ycb": 11, "lmo": 20}
"""How many the issue on real photos asks for, of 12 and of 89."""


class Answer(NamedTuple):
    """One photo: what is there, what ours and the peer came to, and the seconds of both."""

    name: str
    truths: tuple[Posed, ...]
    unposed: tuple[int, ...]
    ours: tuple[Posed, ...]
    seconds: float
    peer: Candidates
    peer_seconds: float
    frame: Frame


def run(
    *, seed: int, quick: bool, as_json: bool, say: Callable[[str], None], pictures: Path | None = None
) -> tuple[str, bool]:
    """Run the benchmark, of ``quick`` the first dataset alone; ``pictures``: the folder of a picture of each photo.

    Raises:
        InputError: The photos are not there, or their models cannot be learned.
    """
    try:
        if pictures is not None:
            pictures.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{pictures}: cannot be made: {error.strerror}") from None
    rows: list[dict[str, Any]] = []
    wrong: list[dict[str, Any]] = []
    claims: list[Claim] = []
    for name in SETS[:1] if quick else SETS:
        found = _of_dataset(FOLDER / name, name, seed, say, pictures)
        rows += found[0]
        wrong += found[1]
        claims += found[2]
    return report("photos", rows, claims, as_json=as_json, more={"not right": wrong})


def _of_dataset(
    folder: Path, name: str, seed: int, say: Callable[[str], None], pictures: Path | None
) -> tuple[list[dict[str, Any]], list[dict[str, Any]], list[Claim]]:
    import cv2

    from benchmarks.photos.pictures import drawn
    from plogic.run.bop.dataset import open_dataset
    from plogic.run.bop.models import ids_of, model_names, read_models
    from sensing.files.whole_files import write_whole

    if not folder.is_dir():
        raise InputError(f"{folder}: there are no such photos: PLOGIC_PHOTOS may name their folder")
    dataset = open_dataset(folder)
    assert dataset.models is not None  # noqa: S101 - it has been opened as a whole dataset with models
    with tempfile.TemporaryDirectory(prefix="plogic-photos-") as place:
        kb = _learned(Path(place) / "kb", dataset.models, seed, say)
        numbers = model_names(dataset.models) | ids_of([kind.name for kind in kb.types], {})
        answers = list(_answers(dataset, kb, numbers, say))
    models = read_models(dataset.models, {truth.obj_id for answer in answers for truth in answer.truths})
    surfaces = {numbers[kind.name]: kind.surface.rays for kind in kb.types if kind.surface is not None}

    def total(answer_of: Callable[[Answer], tuple[Posed, ...]]) -> Counts:
        every = (counted(answer_of(a), a.truths, a.unposed, models, surfaces, a.frame.camera)[0] for a in answers)
        return sum(every, Counts())

    def peers(setting: Any) -> Callable[[Answer], tuple[Posed, ...]]:  # noqa: ANN401 - the peer's
        return lambda a: tuple(Posed(numbers[f.type], f.camera_from_object) for f in accepted(a.peer, setting))

    mine = total(lambda a: a.ours)
    best = max((total(peers(setting)) for setting in settings(SEEN[:1])), key=lambda c: c.right - c.false)
    rows = [
        _row(f"{name}, ours", mine, median(a.seconds for a in answers)),
        _row(f"{name}, peer", best, median(a.peer_seconds for a in answers)),
    ]
    names = {number: kind for kind, number in numbers.items()}
    judged = [(a, counted(a.ours, a.truths, a.unposed, models, surfaces, a.frame.camera)[1]) for a in answers]
    wrong = [
        {"photo": a.name, "type": names[number], "error": error, "overlap": overlap}
        for a, told in judged
        for number, error, overlap in told
        if error is None or error >= ADD
    ]
    for a, told in judged if pictures is not None else ():
        file = Path(pictures or "") / f"{name}_{a.name.replace('/', '_')}.png"
        shown = drawn(a.frame.image, a.frame.camera, a.ours, a.truths, a.unposed, told, surfaces, names)
        write_whole(file, bytes(cv2.imencode(".png", shown)[1].tobytes()))
    claims = [
        Claim(f"{name}: right, of {mine.there}", ">=", RIGHT[name], mine.right),
        Claim(f"{name}: found", ">=", FOUND[name], mine.found),
        Claim(f"{name}: precision", ">=", 0.9, mine.precision),
        Claim(f"{name}: accepted of types that are not there", "<=", 0, mine.false),
        Claim(f"{name}: seconds a photo, median", "<=", 2.0, median(a.seconds for a in answers)),
    ]
    return rows, wrong, claims


def _learned(folder: Path, models: Path, seed: int, say: Callable[[str], None]) -> KnowledgeBase:
    """A knowledge base of all the models."""
    from kb.files.read import read_kb
    from plogic.face.authoring.kb_learn import learn_command
    from plogic.face.authoring.kb_types import import_command, new_command

    new_command(folder, None)
    import_command(models, folder, None, as_json=False)
    learn_command(str(folder), [], Learning(detector="sift", jobs=2, seed=seed), say=say)
    return read_kb(folder)


def _answers(
    dataset: Dataset, kb: KnowledgeBase, numbers: dict[str, int], say: Callable[[str], None]
) -> Iterator[Answer]:
    from plogic.face.commands.bop import look_of

    look = look_of(kb)
    peer = Peer({kind.name: kind.learned.keypoints for kind in kb.types if kind.learned is not None}, SEEN[:1])
    for scene_id, im_id in dataset.listed()[0]:
        scene = dataset.scene(scene_id)
        frame = scene.frame(im_id)
        start = perf_counter()
        found = look(frame.image, frame.camera)
        seconds = perf_counter() - start
        theirs, spent = peer.candidates(frame.image, frame.camera)
        truths = scene.truths(im_id) or ()
        beside = scene.folder / "present.json"
        unposed = json.loads(beside.read_text()).get(str(im_id), []) if beside.exists() else []
        yield Answer(
            f"{scene_id}/{im_id}",
            tuple(Posed(t.obj_id, t.camera_from_object) for t in truths if t.visible is None or t.visible >= VISIBLE),
            tuple(unposed),
            tuple(Posed(numbers[name], pose) for name, pose, _ in found if name in numbers),
            seconds,
            theirs,
            spent[SEEN[0]],
            frame,
        )
        say(f"photo {scene_id}/{im_id}: {', '.join(name for name, _, _ in found) or 'nothing'} in {seconds:.1f} s")


def _row(name: str, counts: Counts, seconds: float) -> dict[str, Any]:
    return {
        "row": name,
        "there": counts.there,
        "accepted": counts.accepted,
        "right": counts.right,
        "found": counts.found,
        "false": counts.false,
        "precision": round(counts.precision, 3),
        "seconds": round(seconds, 2),
    }
