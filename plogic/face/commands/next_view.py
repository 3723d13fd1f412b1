"""``plogic next-view``: the camera moves that would tell most, as a document ``next-view/1`` and as a table."""

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NotRequired, TypedDict, cast

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera, camera_from_dict
from geometry.camera_row import Pose
from geometry.files.pose_files import read_moves
from plogic.base.errors import InputError, InterpretationError
from plogic.face.shown.options import Moves
from plogic.face.shown.tables import light_table, text_of_table
from plogic.facts.document import Interpretation, Marks
from plogic.facts.fact_rows import Interval
from plogic.facts.interpretation import situation_of
from plogic.facts.situation import Reading, Situation, stopped_in
from plogic.scene.asking.query import unknown_names
from plogic.scene.readings.unfinished import marks, notice
from plogic.scene.worlds.ranked_worlds import ranked_worlds
from plogic.sequence.next_view.expected import Prospect
from plogic.sequence.next_view.look import Outlook, answers_in, entropy, looked_ahead
from plogic.sequence.next_view.moves import Candidate, MovesRow, checked, ring, standing, within
from plogic.sequence.next_view.reading import LastView, prospect_of, read_looked

Worlds = list[tuple[float, Sequence[str]]]
Looked = Interpretation | LastView


LISTED_WORLDS = 100
"""Worlds that are taken in the other reading: as many as an interpretation lists."""


def next_view_command(source: str, number: int, seed: int, options: Moves, *, as_json: bool) -> str:
    """The table, or the document ``next-view/1``."""
    document = read_looked(source)
    try:
        answer = looked(document, number, seed, options)
    except InterpretationError as error:
        raise InterpretationError(f"{'<stdin>' if source == '-' else source}: {error}") from None
    return json.dumps(answer) if as_json else table_of(answer)


def looked(document: Looked, number: int, seed: int, options: Moves) -> "NextView":
    """The document of an interpretation's next views, or of its stand-in's (``plogic.sequence.next_view.reading``)."""
    about = options.about
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
    camera = camera_from_dict(document["camera"])
    answers = (
        None if about is None or situation is None else answers_in(situation, [members for _, members in worlds], about)
    )
    if about is not None and situation is not None and answers is not None and (answers == answers[:1]).all():
        unknown = unknown_names(situation, about)  # else every move would be said to tell nothing
        if unknown:
            raise InputError(f"--about: {'; '.join(unknown)}")
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
    lacking = [key for key in ("worlds", "unlisted_mass") if key not in document]
    if lacking:
        raise InterpretationError(*(f"{key}: is missing" for key in lacking))
    low, high = document["unlisted_mass"]
    return [(float(w["probability"]), w["present"]) for w in document["worlds"]], [float(low), float(high)]


def _worlds(document: Interpretation, situation: Situation, reading: Reading | None) -> tuple[Worlds, list[float]]:
    """The worlds that the interpretation lists, or those of the other reading."""
    if reading is None or reading == situation.reading:
        return _listed(document)

    ranking = ranked_worlds(replace(situation, reading=reading), LISTED_WORLDS)
    return [(w.probability, w.present) for w in ranking.worlds], list(ranking.unlisted)


def _candidates(prospect: Prospect, camera: Camera, options: Moves) -> tuple[list[Candidate], MovesRow]:

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


SHOWN = 0.0005
"""Least standard error that the table shows."""
DIGITS = 6
"""Of bits and masses in the document."""


class WhyRow(TypedDict):
    """One reason in words, with the mass that it tells apart and its bits."""

    text: str
    mass: float
    sites: int
    bits: float


class WorldPoseKey(TypedDict):
    """Where the camera's pose in the world is known."""

    T_world_camera: NotRequired[Pose]


class CandidateRow(WorldPoseKey):
    """One candidate: where, how much it would tell, and why."""

    name: str
    T_present_candidate: Pose
    gain_bits: float
    standard_error: float
    sites: int
    why: list[WhyRow]


class NextView(Marks):
    """The document ``next-view/1``; ``of``: how many candidates there were."""

    format: Literal["next-view/1"]
    about: str | None
    reading: Reading
    entropy_bits: float
    worlds: int
    unlisted_mass: Interval
    moves: MovesRow
    seed: int
    of: int
    candidates: list[CandidateRow]


def outlook_document(look: Outlook, world_from_reference: NDArray[np.float64] | None) -> CandidateRow:
    """One candidate: where, how much it would tell, and why."""
    pose = look.candidate.reference_from_camera
    world: WorldPoseKey = {}
    if world_from_reference is not None:
        world = {"T_world_camera": (world_from_reference @ pose).tolist()}
    return {
        "name": look.candidate.name,
        "T_present_candidate": pose.tolist(),
        **world,
        "gain_bits": round(look.gain.bits, DIGITS),
        "standard_error": round(look.gain.error, DIGITS),
        "sites": look.gain.sites,
        "why": [
            {"text": r.text, "mass": round(r.mass, DIGITS), "sites": r.sites, "bits": round(r.bits, DIGITS)}
            for r in look.why
        ],
    }


def table_of(document: NextView) -> str:
    """The candidates with their gains and reasons, under what would be told."""
    table = light_table("next view", ["rank"], ["move"])
    table.add_column("gain, bits", justify="right")
    table.add_column("why")
    for i, row in enumerate(document["candidates"], 1):
        bits = f"{row['gain_bits']:.3f}" + (f" ± {row['standard_error']:.3f}" if row["standard_error"] >= SHOWN else "")
        table.add_row(str(i), row["name"], bits, "\n".join(r["text"] for r in row["why"]) or _nothing(row))
    unfinished = notice(stopped_in(document), anew=False)
    return "\n".join([_open(document), *[unfinished] * bool(unfinished), text_of_table(table)])


def _nothing(row: CandidateRow) -> str:
    return (
        "no feature that would tell the worlds apart"
        if row["sites"] == 0
        else "no feature that tells more than 0.001 bits by itself"
    )


def _open(document: NextView) -> str:
    """What is uncertain, and of how much of the mass that is said."""
    low, high = document["unlisted_mass"]
    about = "the worlds" if document["about"] is None else document["about"]
    missing = "" if high <= 0.0 else f"; worlds of mass {low:.3g} to {high:.3g} are not listed and left out"
    worlds = f"{document['worlds']} world{'s' * (document['worlds'] != 1)}"
    listed = f"{len(document['candidates'])} of {document['of']} candidates" if document["of"] else "no candidates"
    return f"uncertain of {about}: {document['entropy_bits']:.3f} bits over {worlds}{missing}; {listed}"
