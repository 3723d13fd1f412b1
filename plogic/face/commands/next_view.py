"""``plogic next-view``: where to look next, and why."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plogic.face.shown.options import AS_JSON, INTERPRETATION, READING, SEED, Number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geometry.camera import Camera
    from plogic.facts.situation import Situation
    from plogic.sequence.next_view.moves import Candidate
    from plogic.sequence.next_view.prospect import Prospect

    Worlds = list[tuple[float, Sequence[str]]]

LISTED_WORLDS = 100
"""Worlds that are taken in the other reading: as many as an interpretation lists."""


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
    text = next_view_command(interpretation, number, seed, options, as_json=as_json)
    sys.stdout.write(text if text.endswith("\n") else text + "\n")


def next_view_command(source: str, number: int, seed: int, options: dict[str, Any], *, as_json: bool) -> str:
    """The table, or the document ``next-view/1``. ``options``: about, ring, moves, within, reading."""
    from plogic.base.errors import InterpretationError
    from plogic.face.commands.next_view_table import table_of
    from plogic.sequence.next_view.of_sequence import read_looked

    document = read_looked(source)
    try:
        answer = looked(document, number, seed, options)
    except InterpretationError as error:
        raise InterpretationError(f"{'<stdin>' if source == '-' else source}: {error}") from None
    return json.dumps(answer) if as_json else table_of(answer)


def looked(document: dict[str, Any], number: int, seed: int, options: dict[str, Any]) -> dict[str, Any]:
    """The document of an interpretation's next views, or of those of what stands for one (``plogic.sequence.next_view.of_sequence``)."""
    from geometry.camera import camera_from_dict
    from plogic.face.commands.next_view_table import next_view_document
    from plogic.facts.interpretation import situation_of
    from plogic.facts.stopped import stopped_in
    from plogic.scene.readings.unfinished import marks
    from plogic.sequence.next_view.gain import entropy
    from plogic.sequence.next_view.goal import answers_in
    from plogic.sequence.next_view.look import looked_ahead
    from plogic.sequence.next_view.reading import prospect_of

    camera, reading, about = (
        camera_from_dict(document["camera"]),
        options["reading"] or document["reading"],
        options["about"],
    )
    if "format" not in document:  # of a sequence
        _of_presence(document, reading, about)
        situation, (worlds, unlisted) = None, _listed(document)
    else:
        situation = situation_of(document)
        worlds, unlisted = _worlds(document, situation, options["reading"])
        situation = replace(situation, reading=reading)
    prospect = prospect_of(document, worlds)
    answers = (
        None if about is None or situation is None else answers_in(situation, [members for _, members in worlds], about)
    )
    candidates, made = _candidates(prospect, camera, options)
    looks = looked_ahead(prospect, camera, candidates, answers, seed)
    uncertain = float(entropy(prospect.probability if answers is None else prospect.probability @ answers))
    stated = {
        "about": about,
        "reading": reading,
        "entropy_bits": round(uncertain, 6),
        "worlds": len(worlds),
        "unlisted_mass": unlisted,
    }
    stated |= marks(stopped_in(document))
    return next_view_document(looks, stated | {"moves": made, "seed": seed}, camera.world_from_camera, number)


def _of_presence(document: dict[str, Any], reading: str, about: str | None) -> None:
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


def _listed(document: dict[str, Any]) -> tuple[Worlds, list[float]]:
    """The worlds that the document lists, and what is not listed. Raises InterpretationError."""
    from plogic.base.errors import InterpretationError

    try:
        low, high = document["unlisted_mass"]
        return [(float(w["probability"]), list(w["present"])) for w in document["worlds"]], [float(low), float(high)]
    except (KeyError, TypeError, ValueError) as error:
        raise InterpretationError(f"worlds, unlisted_mass: not complete: {error}") from error


def _worlds(document: dict[str, Any], situation: Situation, reading: str | None) -> tuple[Worlds, list[float]]:
    """The worlds that the interpretation lists, or those of the other reading."""
    if reading is None or reading == situation.reading:
        return _listed(document)
    from plogic.scene.worlds.ranked_worlds import ranked_worlds

    ranking = ranked_worlds(
        replace(situation, reading="posterior" if reading == "posterior" else "score"), LISTED_WORLDS
    )
    return [(w.probability, w.present) for w in ranking.worlds], list(ranking.unlisted)


def _candidates(prospect: Prospect, camera: Camera, options: dict[str, Any]) -> tuple[list[Candidate], dict[str, Any]]:
    from geometry.files.pose_files import read_moves
    from plogic.sequence.next_view.moves import Candidate, checked, ring, standing, within

    stand = standing(camera.world_from_camera)
    if options["moves"] is not None:
        moves = read_moves(options["moves"])
        return checked([Candidate(m.name, m.present(camera.world_from_camera)) for m in moves]), {
            "moves": "list",
            "places": len(moves),
        }
    if options["within"] is not None:
        return within(prospect, stand, options["within"])
    return ring(prospect, stand, options["ring"])
