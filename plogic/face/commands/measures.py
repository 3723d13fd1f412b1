"""``plogic measures``: ev in each mode, Shanahan's value, the posterior, dv and rank of each hypothesis, side by side."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict

import click

from plogic.face.shown.options import AS_JSON, INTERPRETATION


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
    from plogic.face.python.measures import measures_of
    from plogic.facts.interpretation import read_interpretation
    from plogic.facts.situation import stopped_in
    from plogic.scene.readings.unfinished import marks, with_notice

    document = read_interpretation(source)
    found, stopped = measures_of(document), stopped_in(document)
    if as_json:
        return json.dumps({"format": "measures/1", **asdict(found), **marks(stopped)})
    return with_notice(str(found), stopped)
