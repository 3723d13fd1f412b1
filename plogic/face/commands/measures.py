"""``plogic measures``: ev in each mode, Shanahan's value, the posterior, dv and rank of each hypothesis, side by side."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from plogic.face.shown.options import AS_JSON, INTERPRETATION

if TYPE_CHECKING:
    from plogic.run.measured import Measured, Measures

COLUMNS = {
    "ev": "ev",
    "ev_to_B": "to_B",
    "ev_drop": "drop",
    "ev_reassign": "reassign",
    "ev_over_instances": "ev, Δ's dv",
    "shanahan": "Shanahan",
    "posterior": "posterior",
    "dv": "dv",
    "dv_over_instances": "Δ's dv",
    "rank": "rank",
}
"""Titles of a hypothesis' measures in the table."""
SIGNED = ("ev", "ev_to_B", "ev_drop", "ev_reassign", "ev_over_instances")


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@INTERPRETATION
@AS_JSON
def measures(interpretation: str, *, as_json: bool) -> None:
    """Compare the measures of each hypothesis: ev alone and in each mode beside Δi, Shanahan's value, the posterior, dv, rank.

    Distinctiveness is told over the types of the knowledge base, and over the instances in Δi.
    """
    text = measures_command(interpretation, as_json=as_json)
    sys.stdout.write(text if text.endswith("\n") else text + "\n")


def measures_command(source: str, *, as_json: bool) -> str:
    """The document ``measures/1``, or both tables. Raises InterpretationError, SituationError."""
    from plogic.facts.interpretation import read_interpretation
    from plogic.facts.stopped import stopped_in
    from plogic.run.measured import measured
    from plogic.scene.readings.unfinished import marks, with_notice

    document = read_interpretation(source)
    found, stopped = measured(document), stopped_in(document)
    if as_json:
        return json.dumps({"format": "measures/1", **asdict(found), **marks(stopped)})
    return with_notice(_tables(found), stopped)


def _tables(found: Measures) -> str:
    from rich import box
    from rich.table import Table

    from plogic.face.shown.tables import chance, text_of_table

    rows = Table(title="hypotheses", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for title in ("hypothesis", "status"):
        rows.add_column(title)
    for title in COLUMNS.values():
        rows.add_column(title, justify="right")
    for h in found.hypotheses:
        rows.add_row(f"{h.type} {h.id}", h.status, *(_cell(h, name) for name in COLUMNS))
    types = Table(title="feature types", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    types.add_column("feature type")
    for title in ("dv over types", "dv over instances in Δ"):
        types.add_column(title, justify="right")
    for f in found.features:
        types.add_row(f.type, chance(f.over_types), chance(f.over_instances))
    return f"{text_of_table(rows)}\n{text_of_table(types)}"


def _cell(h: Measured, name: str) -> str:
    from plogic.face.shown.tables import chance, signed

    value: float | None = getattr(h, name)
    return signed(value) if name in SIGNED else chance(value)
