"""``plogic demo``: the two towers, whole, from a simulated camera's pixels to ranked worlds, a picture and a page.

Γ comes from the pixels alone: the ground truth is written beside the result, and nothing reads it.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from plogic.base.errors import InputError
from plogic.face.commands.perceive import picture_of
from plogic.face.commands.simulate import shapes_of, tell_without_physics
from plogic.face.shown import tables
from plogic.face.shown.tables import text_of_table
from plogic.run.sources import kb_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from plogic.facts.document import Interpretation
    from plogic.facts.situation import Reading
    from plogic.scene.document import AnswerRow

READINGS: tuple[Reading, ...] = ("score", "posterior")
SCENE = 62
"""The demo's scene at seed 0: one tower partly hides the other."""
GOALS = ("present(H)", "partially_occludes(X, Y)")


def run_demo(out: Path, seed: int, reading: Reading, *, say: Callable[[str], None], as_json: bool = False) -> str:
    """Render, detect, interpret in both readings, write the folder ``out`` and return the text to print (in ``reading``)."""
    check_folder(out)
    from geometry.camera import camera_to_dict
    from plogic.base.clock import Stopwatch
    from plogic.cycle.delta import Options
    from plogic.run.perceive import Perceiver
    from sensing.detectors.detector import detect
    from sensing.files.gamma_files import gamma_to_dict
    from sensing.simulated.scene import png, random_scene, truth_to_dict

    kb = kb_of("towers")
    tell_without_physics(say)
    say("rendering two towers with the simulated camera ...")
    scene = random_scene(shapes_of(kb), SCENE + seed, placement="hiding")
    image = scene.photograph().image
    clock = Stopwatch()
    say("detecting junctions and patches in the pixels ...")
    with clock.stage("detect"):
        gamma = detect(image, scene.camera, kb.appearance_types)
    perceiver = Perceiver(kb)
    say(f"{len(gamma.appearances)} appearances; searching for worlds that explain them ...")
    documents: dict[Reading, Interpretation] = {
        name: perceiver(gamma, Options(reading=name), image, clock) for name in READINGS
    }
    files = {
        "image.png": png(image),
        "camera.json": json_bytes(camera_to_dict(scene.camera)),
        "truth.json": json_bytes(truth_to_dict(scene)),
        "gamma.json": json_bytes(gamma_to_dict(gamma)),
        **_results(documents["score"], image, ""),
        **_results(documents["posterior"], image, "posterior-"),
    }
    write_into(out, files)
    document = documents[reading]
    asked = {
        "format": "demo/1",
        "reading": reading,
        "folder": str(out),
        "worlds": document["worlds"],
        "unlisted_mass": document["unlisted_mass"],
    }
    return json.dumps(asked | {"answers": _answers(document)}) if as_json else _told(document, out)


def _results(document: Interpretation, image: NDArray[Any], prefix: str) -> dict[str, bytes]:
    """The files of one reading."""
    from plogic.face.pages.one_file import page
    from plogic.facts.interpretation import situation_of, text_of
    from plogic.scene.text.program_text import program_text, query_lines

    situation = situation_of(document)
    return {
        f"{prefix}interpretation.json": text_of(document).encode(),
        f"{prefix}picture.png": picture_of(document, image),
        f"{prefix}page.html": page(document).encode(),
        f"{prefix}program.pl": (program_text(situation) + "\n" + query_lines(situation)).encode(),
    }


def json_bytes(document: Mapping[str, object]) -> bytes:
    """A document as the bytes of its file."""
    return (json.dumps(document, indent=1) + "\n").encode()


def check_folder(out: Path) -> None:
    """Raise InputError where something that is no folder stands in the way of ``out``, before any work is done."""
    for place in (out, *out.parents):
        if place.exists() and not place.is_dir():
            raise InputError(f"{out}: cannot be written: {place} is no folder")


def write_into(out: Path, files: dict[str, bytes]) -> None:
    """All of the files or none; the folder may be there from an earlier run."""
    from sensing.files.whole_files import write_files

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror}") from None
    write_files({out / name: data for name, data in files.items()})


def _told(document: Interpretation, out: Path) -> str:
    """Worlds, measures and two queries as text, and where to look."""
    held: Interpretation = {**document, "hypotheses": [h for h in document["hypotheses"] if h["status"] != "rejected"]}
    shown = [
        tables.measures(held),
        tables.worlds(document),
        tables.answers({"format": "answers/1", "answers": _answers(document)}),
    ]
    texts = [text_of_table(table) for table in shown]
    prefix = f"{out}/" if document["reading"] == "score" else f"{out}/posterior-"
    return "\n".join(
        [*texts, "", f"look at {prefix}page.html and {prefix}picture.png; ask {prefix}interpretation.json"]
    )


def _answers(document: Interpretation) -> list[AnswerRow]:
    """The answers to the demo's own queries, as ``query --json`` gives them."""
    from plogic.facts.interpretation import situation_of
    from plogic.scene.asking.query import answers_to_all

    asked = [a for found in answers_to_all(situation_of(document), GOALS) for a in found]
    return [{"goal": a.goal, "probability": a.probability, "interval": list(a.interval)} for a in asked]
