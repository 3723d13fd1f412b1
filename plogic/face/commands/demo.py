"""``plogic demo``: the two towers, whole, from a simulated camera's pixels to ranked worlds, a picture and a page.

Γ comes from the pixels alone: the ground truth is written beside the result, and nothing reads it.
"""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypedDict, cast

import numpy as np
from numpy.typing import NDArray

from geometry.camera import camera_to_dict
from geometry.camera_row import Pose
from kb.clouds.cloud import KnowledgeBase
from plogic.base.clock import Stopwatch
from plogic.base.errors import InputError
from plogic.cycle.delta import Options
from plogic.face.commands.next_view import CandidateRow, NextView, looked, table_of
from plogic.face.commands.perceive import picture_of
from plogic.face.commands.simulate import shapes_of, tell_without_physics
from plogic.face.pages.one_file import page
from plogic.face.shown import tables
from plogic.face.shown.options import Moves
from plogic.face.shown.tables import text_of_table
from plogic.facts.document import Interpretation, WorldRow
from plogic.facts.fact_rows import Interval
from plogic.facts.interpretation import situation_of, text_of
from plogic.facts.situation import Reading
from plogic.match.gamma.data import data_of
from plogic.run.document import document_of
from plogic.run.perceive import Perceiver, ranked
from plogic.run.sources import kb_of
from plogic.scene.asking.query import answers_to_all
from plogic.scene.document import AnswerRow
from plogic.scene.text.program_text import program_text, query_lines
from plogic.sequence.constancy.sight_lines import View
from plogic.sequence.views.joint import Found, joint, merged
from plogic.sequence.views.standing import Seen, standing_of
from sensing.detectors.detector import detect
from sensing.files.gamma_files import gamma_to_dict
from sensing.files.whole_files import write_files
from sensing.simulated.robot import Robot
from sensing.simulated.scene import json_bytes, png, random_scene, truth_to_dict

READINGS: tuple[Reading, ...] = ("score", "posterior")
SCENE = 62
"""The demo's scene at seed 0: one tower partly hides the other."""
GOALS = ("present(H)", "partially_occludes(X, Y)")


def run_demo(out: Path, seed: int, reading: Reading, *, say: Callable[[str], None], as_json: bool = False) -> str:
    """Render, detect, interpret in both readings, write ``out``, and return the text to print (in ``reading``)."""
    check_folder(out)
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
    situation = situation_of(document)
    return {
        f"{prefix}interpretation.json": text_of(document).encode(),
        f"{prefix}picture.png": picture_of(document, image),
        f"{prefix}page.html": page(document).encode(),
        f"{prefix}program.pl": (program_text(situation) + "\n" + query_lines(situation)).encode(),
    }


def check_folder(out: Path) -> None:
    """Raise InputError where something that is no folder stands in the way of ``out``, before any work is done."""
    for place in (out, *out.parents):
        if place.exists() and not place.is_dir():
            raise InputError(f"{out}: cannot be written: {place} is no folder")


def write_into(out: Path, files: dict[str, bytes]) -> None:
    """All of the files or none; the folder may be there from an earlier run."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror}") from None
    write_files({out / name: data for name, data in files.items()})


def _told(document: Interpretation, out: Path) -> str:
    """Worlds, measures and two queries as text, and where to look."""
    shown = [
        tables.measures(_held(document)),
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
    asked = [a for found in answers_to_all(situation_of(document), GOALS) for a in found]
    return [{"goal": a.goal, "probability": a.probability, "interval": list(a.interval)} for a in asked]


TURNED_AWAY = 4
"""The demo's scene at seed 0: the wall that would tell is turned away."""
STANDING = "open_tower", "pyramid_tower"
SHOWN = 4
"""Candidates in the table."""


class TogetherRow(TypedDict):
    """One hypothesis of both views."""

    id: str
    type: str
    T_world_object: Pose


class Together(TypedDict):
    """What both views say, as ``worlds`` has it, so that the same table shows it."""

    format: Literal["worlds/1"]
    reading: Reading
    worlds: list[WorldRow]
    unlisted_mass: Interval
    hypotheses: list[TogetherRow]


class _Look(NamedTuple):
    """One look: what was found in it, its interpretation, and the image (H, W, 3)."""

    found: Found
    document: Interpretation
    image: NDArray[np.uint8]


def run_look_again(out: Path, seed: int, *, say: Callable[[str], None], as_json: bool = False) -> str:
    """Look, ask where to look next, go there, look again; write the folder ``out`` and return the text to print."""
    check_folder(out)
    kb = kb_of("lookalikes")
    robot, perceiver = Robot(random_scene(shapes_of(kb, STANDING), TURNED_AWAY + seed)), Perceiver(kb)
    tell_without_physics(say)
    say("the first look ...")
    first = _look("v1", robot, perceiver)
    say("where to look next ...")
    ahead = looked(first.document, 100, 0, Moves())
    chosen = _reachable(ahead["candidates"], robot)
    say(f"{chosen['name']}: {chosen['gain_bits']:.2f} bits expected; the second look ...")
    second = _look("v2", robot, perceiver)
    after = _together([first, second], perceiver)
    _write(out, kb, robot, (first, second), ahead, after)
    ahead = {**ahead, "candidates": ahead["candidates"][:SHOWN]}
    if as_json:
        told = {"worlds": first.document["worlds"], "next_view": ahead, "after": after["worlds"]}
        return json.dumps({"format": "demo/1", "folder": str(out), **told})
    before, later = (
        text_of_table(tables.worlds(some, 5)) for some in (_held(first.document), cast("Interpretation", after))
    )
    parts = [
        "after the first view",
        before,
        "",
        table_of(ahead),
        "",
        f"after the second view, from {chosen['name']}",
        later,
        "",
        f"look at {out}/views.png; ask {out}/interpretation.json (one view); where the camera stood: {out}/poses.json",
    ]
    return "\n".join(parts)


def _held(document: Interpretation) -> Interpretation:
    return {**document, "hypotheses": [h for h in document["hypotheses"] if h["status"] != "rejected"]}


def _look(name: str, robot: Robot, perceiver: Perceiver) -> _Look:
    """The picture from where the robot is, and what it leads to by itself."""
    kb, image = perceiver.kb, robot.look().image
    gamma = detect(image, robot.scene().camera, kb.sought)
    options = Options(reading="posterior")
    delta, rejected, trace = perceiver.delta(gamma, options, Stopwatch())
    delta, ranking = ranked(delta, trace)
    document = document_of(kb, gamma, delta, rejected, trace, ranking, image)
    data = data_of(gamma.appearances, gamma.camera, perceiver.width)
    seen = Seen(View(name, gamma, robot.world_from_camera), data)
    return _Look(Found(seen, tuple(delta.beliefs.values())), document, image)


def _reachable(candidates: Sequence[CandidateRow], robot: Robot) -> CandidateRow:
    """Go to the first candidate where a camera can be, the best first. Raises InputError where there is none."""
    for row in candidates:
        place = np.array(row["T_world_camera"])
        if robot.why_not(place) is None:
            robot.move_to(place)
            return row
    raise InputError("no candidate is where a camera can be")


def _together(looks: Sequence[_Look], perceiver: Perceiver) -> Together:
    """What both views say: worlds and hypotheses, by the first view's names where it had them."""
    found = [look.found for look in looks]
    both, ranking = joint(
        [one.seen for one in found],
        merged(found, perceiver.models, perceiver.kb),
        perceiver,
        Options(reading="posterior"),
    )
    standing, first = both.standing, looks[0]
    old = {
        f"h{i}": standing_of(belief, first.found.seen.view, perceiver.models)
        for i, belief in enumerate(first.found.beliefs, 1)
    }
    names: dict[str, str] = {}
    for i, some in enumerate(standing, 1):
        known = [
            name
            for name, other in old.items()
            if name not in names.values() and some.same(other, first.found.seen.view)
        ]
        names[f"h{i}"] = known[0] if known else f"n{i}"
    rows: list[WorldRow] = [
        {"probability": w.probability, "present": sorted(names[h] for h in w.present), "causes": dict(w.causes)}
        for w in ranking.worlds
    ]
    hypotheses: list[TogetherRow] = [
        {"id": names[f"h{i}"], "type": some.object_type.name, "T_world_object": some.world_from_object.tolist()}
        for i, some in enumerate(standing, 1)
    ]
    return {
        "format": "worlds/1",
        "reading": "posterior",
        "worlds": rows,
        "unlisted_mass": list(ranking.unlisted),
        "hypotheses": hypotheses,
    }


def _write(
    out: Path, kb: KnowledgeBase, robot: Robot, looks: Sequence[_Look], ahead: NextView, after: Together
) -> None:
    """The pictures, the interpretation of the first view, the candidates, and what both views say."""
    frames = [
        {"frame": f"view-{i}.png", "T_world_camera": look.found.seen.view.world_from_camera.tolist()}
        for i, look in enumerate(looks, 1)
    ]
    write_into(
        out,
        {
            **{f"view-{i}.png": png(look.image) for i, look in enumerate(looks, 1)},
            "views.png": png(_beside([look.image for look in looks])),
            "camera.json": json_bytes(camera_to_dict(looks[0].found.seen.data.camera)),
            "poses.json": json_bytes({"format": "poses/1", "frames": frames}),
            "truth.json": json_bytes(truth_to_dict(robot.scene())),
            "interpretation.json": text_of(looks[0].document).encode(),
            "next-view.json": json_bytes(ahead),
            "worlds.json": json_bytes({**after, "kb": kb.name}),
        },
    )


def _beside(images: Sequence[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """The views in one picture, left to right, a light line between them."""
    line = np.full((images[0].shape[0], 6, 3), 235, np.uint8)
    return np.hstack([part for image in images for part in (image, line)][:-1])
