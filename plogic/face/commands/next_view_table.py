"""What looking ahead came to, as a document ``next-view/1`` and as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NotRequired, TypedDict

from plogic.facts.document import Marks

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from plogic.facts.fact_rows import Interval, Pose
    from plogic.facts.situation import Reading
    from plogic.sequence.next_view.look import Outlook
    from plogic.sequence.next_view.moves import MovesRow

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
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from plogic.face.shown.printing import text_of_table
    from plogic.facts.stopped import stopped_in
    from plogic.scene.readings.unfinished import notice

    table = Table(title="next view", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("rank", justify="right")
    table.add_column("move")
    table.add_column("gain, bits", justify="right")
    table.add_column("why")
    for i, row in enumerate(document["candidates"], 1):
        bits = f"{row['gain_bits']:.3f}" + (f" ± {row['standard_error']:.3f}" if row["standard_error"] >= SHOWN else "")
        table.add_row(
            str(i), Text(row["name"]), Text(bits), Text("\n".join(r["text"] for r in row["why"]) or _nothing(row))
        )
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
