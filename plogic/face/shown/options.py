"""Options and arguments that several commands share."""

from __future__ import annotations

import math
from typing import Any

import click

READINGS = click.Choice(["score", "posterior"])
SEED = click.IntRange(0)
MODES = click.Choice(["to_B", "drop", "reassign"])
INTERPRETATION = click.argument("interpretation", metavar="INTERPRETATION")
SOURCE = click.argument("source", metavar="INTERPRETATION|PROGRAM.pl")
GIVEN = click.option("--given", multiple=True, metavar="EVIDENCE", help="A literal that is observed; may be repeated.")
READING = click.option(
    "--reading", type=READINGS, help="The other reading of the same Δh (default: the interpretation's own)."
)
TRUST = click.option(
    "--trust",
    is_flag=True,
    help="Lift the allow-list from a program of your own: it may then run Python and read files.",
)
AS_JSON = click.option("--json", "as_json", is_flag=True, help="One versioned JSON document on stdout.")


class Number(click.FloatRange):
    """A range that NaN is outside of: every comparison with NaN is false, so that click lets it pass."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:  # noqa: ANN401 - click's
        """The number; fails as bad usage."""
        number = super().convert(value, param, ctx)
        return self.fail(f"{value} is no number", param, ctx) if math.isnan(number) else number


KB = click.option(
    "--kb", "kb_folder", required=True, help="Folder of the knowledge base; `first` and `towers` are shipped."
)
CAMERA = click.option("--camera", type=click.Path(), help="Camera file of an image: ours, ROS, OpenCV, BOP or COLMAP.")
FIRST_READING = click.option("--reading", type=READINGS, default="score", show_default=True)
RECONSIDER = click.option(
    "--reconsider", type=MODES, default="to_B", show_default=True, help="How explained misses count (score reading)."
)
SMOOTHING = click.option(
    "--smoothing",
    type=Number(0.0, 0.5, max_open=True),
    default=0.0,
    show_default=True,
    help="ε of the score program's choices.",
)
GENERATOR = click.option(
    "--generator",
    type=click.Choice(["index", "quadruples", "softposit"]),
    default="index",
    show_default=True,
    help="Who proposes poses of types written by hand: the fast search, or the paper's plain ones; learned types have their own.",
)
BEST_BY = click.option(
    "--deadline",
    type=Number(0.0, min_open=True),
    help="Seconds from when KB, index and Γ are there (several views: all frames together, with detection); "
    "then the best answer so far is marked unfinished (exit 3).",
)
DEADLINE = click.option(
    "--deadline",
    type=Number(0.0, min_open=True),
    help="Seconds; then every answer is an interval that contains the exact one (exit 3).",
)
