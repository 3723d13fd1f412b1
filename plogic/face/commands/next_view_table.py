"""What looking ahead came to, as a document ``next-view/1`` and as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from plogic.sequence.next_view.look import Outlook

SHOWN = 0.0005
"""Least standard error that the table shows."""
DIGITS = 6
"""Of bits and masses in the document."""


def outlook_document(look: Outlook, world_from_reference: NDArray[np.float64] | None) -> dict[str, Any]:
    """One candidate: where, how much it would tell, and why."""
    pose = look.candidate.reference_from_camera
    world = {} if world_from_reference is None else {"T_world_camera": (world_from_reference @ pose).tolist()}
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


def table_of(document: dict[str, Any]) -> str:
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


def _nothing(row: dict[str, Any]) -> str:
    return (
        "no feature that would tell the worlds apart"
        if row["sites"] == 0
        else "no feature that tells more than 0.001 bits by itself"
    )


def _open(document: dict[str, Any]) -> str:
    """What is uncertain, and of how much of the mass that is said."""
    low, high = document["unlisted_mass"]
    about = "the worlds" if document["about"] is None else document["about"]
    missing = "" if high <= 0.0 else f"; worlds of mass {low:.3g} to {high:.3g} are not listed and left out"
    worlds = f"{document['worlds']} world{'s' * (document['worlds'] != 1)}"
    listed = f"{len(document['candidates'])} of {document['of']} candidates" if document["of"] else "no candidates"
    return f"uncertain of {about}: {document['entropy_bits']:.3f} bits over {worlds}{missing}; {listed}"


def next_view_document(
    looks: Sequence[Outlook], stated: dict[str, Any], world_from_reference: NDArray[np.float64] | None, shown: int
) -> dict[str, Any]:
    """``stated``: about, reading, entropy, worlds, unlisted mass and how the candidates were made."""
    rows = [outlook_document(look, world_from_reference) for look in looks[:shown]]
    return {"format": "next-view/1", **stated, "of": len(looks), "candidates": rows}
