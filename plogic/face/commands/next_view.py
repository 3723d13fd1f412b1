"""``plogic next-view``: where to look next, and why."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from plogic.face.shown.options import AS_JSON, INTERPRETATION, READING, SEED, Number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geometry.camera import Camera
    from plogic.face.commands.next_view_table import NextView
    from plogic.facts.document import Interpretation
    from plogic.facts.situation import Reading, Situation
    from plogic.sequence.next_view.moves import Candidate, MovesRow
    from plogic.sequence.next_view.prospect import Prospect
    from plogic.sequence.next_view.reading import LastView

    Worlds = list[tuple[float, Sequence[str]]]

    Looked = Interpretation | LastView

LISTED_WORLDS = 100
"""Worlds that are taken in the other reading: as many as an interpretation lists."""


@dataclass(frozen=True)
class Moves:
    """``about``: the goal that should become certain; where the camera may go, one of ``ring`` m, ``within`` m and a file of ``moves``.

    ``reading``: the other one of the same Δh, None for its own.
    """

    about: str | None = None
    ring: float | None = None
    moves: Path | None = None
    within: float | None = None
    reading: Reading | None = None


@click.command(name="next-view", context_settings={"help_option_names": ["-h", "--help"]})
@INTERPRETATION
@click.option(
    "--about",
    metavar="GOAL",
    help="What should become certain, as `plogic query` takes it (default: which world it is).",
)
@click.option(
    "--ring",
    type=Number(0.0, min_open=True),
    metavar="METRES",
    help="Radius of the ring around the scene (default: the present one).",
)
@click.option("--moves", type=click.Path(path_type=Path), help="Candidates of your own: a moves/1 or poses/1 file.")
@click.option(
    "--within",
    type=Number(0.0, min_open=True),
    metavar="METRES",
    help="All of a grid within this distance, turned to the scene.",
)
@click.option(
    "-n", "number", type=click.IntRange(1), default=5, show_default=True, help="Candidates to list, the best first."
)
@READING
@click.option("--seed", type=SEED, default=0, show_default=True)
@AS_JSON
def next_view(interpretation: str, number: int, seed: int, *, as_json: bool, **options: Any) -> None:  # noqa: ANN401 - click's
    """Say where to look next: the camera moves that would tell most, with their expected gains in bits, and why.

    INTERPRETATION is that of one image, or a sequence's panorama/1: what all its views leave open, from where the last
    one stood.

    Without --ring, --moves or --within the candidates are a ring of eleven places around the scene at the present
    height and distance.
    """
    if sum(options[name] is not None for name in ("ring", "moves", "within")) > 1:
        raise click.UsageError("--ring, --moves and --within exclude one another")
    text = next_view_command(interpretation, number, seed, Moves(**options), as_json=as_json)
    sys.stdout.write(text if text.endswith("\n") else text + "\n")


def next_view_command(source: str, number: int, seed: int, options: Moves, *, as_json: bool) -> str:
    """The table, or the document ``next-view/1``."""
    from plogic.base.errors import InterpretationError
    from plogic.face.commands.next_view_table import table_of
    from plogic.sequence.next_view.reading import read_looked

    document = read_looked(source)
    try:
        answer = looked(document, number, seed, options)
    except InterpretationError as error:
        raise InterpretationError(f"{'<stdin>' if source == '-' else source}: {error}") from None
    return json.dumps(answer) if as_json else table_of(answer)


def looked(document: Looked, number: int, seed: int, options: Moves) -> NextView:
    """The document of an interpretation's next views, or of those of what stands for one (``plogic.sequence.next_view.reading``)."""
    from geometry.camera import camera_from_dict
    from plogic.face.commands.next_view_table import outlook_document
    from plogic.facts.interpretation import situation_of
    from plogic.facts.stopped import stopped_in
    from plogic.scene.readings.unfinished import marks
    from plogic.sequence.next_view.gain import entropy
    from plogic.sequence.next_view.goal import answers_in
    from plogic.sequence.next_view.look import looked_ahead
    from plogic.sequence.next_view.reading import prospect_of

    camera, about = camera_from_dict(document["camera"]), options.about
    reading: Reading = options.reading or document["reading"]
    if "format" not in document:  # of a sequence
        _of_presence(document, reading, about)
        situation, (worlds, unlisted) = None, _listed(document)
    else:
        whole = cast("Interpretation", document)
        situation = situation_of(whole)
        worlds, unlisted = _worlds(whole, situation, options.reading)
        situation = replace(situation, reading=reading)
    prospect = prospect_of(document, worlds)
    answers = (
        None if about is None or situation is None else answers_in(situation, [members for _, members in worlds], about)
    )
    candidates, made = _candidates(prospect, camera, options)
    looks = looked_ahead(prospect, camera, candidates, answers, seed)
    uncertain = float(entropy(prospect.probability if answers is None else prospect.probability @ answers))
    return {
        "format": "next-view/1",
        "about": about,
        "reading": reading,
        "entropy_bits": round(uncertain, 6),
        "worlds": len(worlds),
        "unlisted_mass": unlisted,
        **marks(stopped_in(document)),
        "moves": made,
        "seed": seed,
        "of": len(looks),
        "candidates": [outlook_document(look, camera.world_from_camera) for look in looks[:number]],
    }


def _of_presence(document: LastView, reading: str, about: str | None) -> None:
    """Refuse what the worlds of a sequence do not say. Raises InterpretationError."""
    from plogic.base.errors import InterpretationError

    if about is not None:
        raise InterpretationError(
            "--about: the worlds of a sequence say who is present and no more; ask the interpretation of one of its views"
        )
    if reading != document["reading"]:
        raise InterpretationError(
            f"--reading: the worlds of this sequence are of the {document['reading']} reading; perceive it again for the other"
        )


def _listed(document: Looked) -> tuple[Worlds, list[float]]:
    """The worlds that the document lists, and what is not listed. Raises InterpretationError."""
    from plogic.base.errors import InterpretationError

    lacking = [key for key in ("worlds", "unlisted_mass") if key not in document]
    if lacking:
        raise InterpretationError(*(f"{key}: is missing" for key in lacking))
    low, high = document["unlisted_mass"]
    return [(float(w["probability"]), w["present"]) for w in document["worlds"]], [float(low), float(high)]


def _worlds(document: Interpretation, situation: Situation, reading: Reading | None) -> tuple[Worlds, list[float]]:
    """The worlds that the interpretation lists, or those of the other reading."""
    if reading is None or reading == situation.reading:
        return _listed(document)
    from plogic.scene.worlds.ranked_worlds import ranked_worlds

    ranking = ranked_worlds(replace(situation, reading=reading), LISTED_WORLDS)
    return [(w.probability, w.present) for w in ranking.worlds], list(ranking.unlisted)


def _candidates(prospect: Prospect, camera: Camera, options: Moves) -> tuple[list[Candidate], MovesRow]:
    from geometry.files.pose_files import read_moves
    from plogic.sequence.next_view.moves import Candidate, checked, ring, standing, within

    stand = standing(camera.world_from_camera)
    if options.moves is not None:
        moves = read_moves(options.moves)
        return checked([Candidate(m.name, m.present(camera.world_from_camera)) for m in moves]), {
            "moves": "list",
            "places": len(moves),
        }
    if options.within is not None:
        return within(prospect, stand, options.within)
    return ring(prospect, stand, options.ring)
