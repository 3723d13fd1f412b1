"""``plogic demo --look-again``: one image leaves two worlds near even, and the second view that was chosen settles it.

Γ comes from the simulated camera's pixels alone. Two towers of the shipped ``lookalikes`` differ on their north wall,
which the first view does not show; the robot goes where looking tells most, and both views are judged together.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Literal, NamedTuple, TypedDict, cast

from plogic.base.errors import InputError
from plogic.face.commands.demo import check_folder, json_bytes, write_into
from plogic.face.commands.simulate import shapes_of, tell_without_physics
from plogic.face.shown import tables
from plogic.face.shown.tables import text_of_table
from plogic.run.sources import kb_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.face.commands.next_view import CandidateRow, NextView
    from plogic.facts.document import Interpretation, WorldRow
    from plogic.facts.fact_rows import Interval, Pose
    from plogic.facts.situation import Reading
    from plogic.match.kinds import Models
    from plogic.run.perceive import Perceiver
    from plogic.scene.worlds.ranked_worlds import Ranking
    from plogic.sequence.views.joint import Found
    from plogic.sequence.views.standing import Standing
    from sensing.simulated.robot import Robot

SCENE = 4
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
    from plogic.face.commands.next_view import looked, table_of
    from plogic.face.shown.options import Moves
    from plogic.run.perceive import Perceiver
    from sensing.simulated.robot import Robot
    from sensing.simulated.scene import random_scene

    kb = kb_of("lookalikes")
    robot, perceiver = Robot(random_scene(shapes_of(kb, STANDING), SCENE + seed)), Perceiver(kb)
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
        _where(out),
    ]
    return "\n".join(parts)


def _held(document: Interpretation) -> Interpretation:
    return {**document, "hypotheses": [h for h in document["hypotheses"] if h["status"] != "rejected"]}


def _where(out: Path) -> str:
    return (
        f"look at {out}/views.png; ask {out}/interpretation.json (one view); where the camera stood: {out}/poses.json"
    )


def _look(name: str, robot: Robot, perceiver: Perceiver) -> _Look:
    """The picture from where the robot is, and what it leads to by itself."""
    from plogic.base.clock import Stopwatch
    from plogic.cycle.delta import Options
    from plogic.match.gamma.data import data_of
    from plogic.run.document import document_of
    from plogic.run.perceive import ranked
    from plogic.sequence.constancy.sight_lines import View
    from plogic.sequence.views.joint import Found
    from plogic.sequence.views.standing import Seen
    from sensing.detectors.detector import detect

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
    import numpy as np

    for row in candidates:
        place = np.array(row["T_world_camera"])
        if robot.why_not(place) is None:
            robot.move_to(place)
            return row
    raise InputError("no candidate is where a camera can be")


def _together(looks: Sequence[_Look], perceiver: Perceiver) -> Together:
    """What both views say: worlds and hypotheses, by the first view's names where it had them."""
    from plogic.cycle.delta import Options
    from plogic.sequence.views.joint import joint, merged

    found = [look.found for look in looks]
    both, ranking = joint(
        [one.seen for one in found],
        merged(found, perceiver.models, perceiver.kb),
        perceiver,
        Options(reading="posterior"),
    )
    return _told(both.standing, ranking, looks[0], perceiver.models)


def _told(standing: Sequence[Standing], ranking: Ranking, first: _Look, models: Models) -> Together:
    """As ``worlds`` has it, so that the same table shows it."""
    from plogic.sequence.views.standing import standing_of

    old = {
        f"h{i}": standing_of(belief, first.found.seen.view, models) for i, belief in enumerate(first.found.beliefs, 1)
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
    from geometry.camera import camera_to_dict
    from plogic.facts.interpretation import text_of
    from sensing.simulated.scene import png, truth_to_dict

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
    import numpy as np

    line = np.full((images[0].shape[0], 6, 3), 235, np.uint8)
    return np.hstack([part for image in images for part in (image, line)][:-1])
