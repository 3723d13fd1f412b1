"""Tables as text: plain where stdout is no terminal, and where NO_COLOR is set.

Those of answers, worlds and measures.
"""

import io
import os
import sys
from collections.abc import Iterable, Mapping, Sequence

from rich import box
from rich import table as grids
from rich.console import Console
from rich.text import Text

from geometry.printable import shown
from plogic.face.shown.figures import NONE, chance, interval, signed
from plogic.facts.document import Cells, Interpretation
from plogic.facts.stances import words_of_standing
from plogic.scene.document import Answers
from plogic.scene.readings.unfinished import unlisted_beyond


class Table(grids.Table):
    """A table whose cells are texts, never markup: what cannot be printed is escaped before it is laid out.

    A ``Text`` is one of our own, with a style: it loses control characters.
    """

    def add_row(self, *cells: str | Text, end_section: bool = False) -> None:  # type: ignore[override]
        """One row more."""
        texts = (Text(shown(cell)) if isinstance(cell, str) else cell for cell in cells)
        super().add_row(*texts, end_section=end_section)


CELLS = ("expected_detected", "expected_missed", "hidden_missed", "hidden_detected")
"""The four cases in the paper's column order: A, C, B, D."""


def worlds(document: Interpretation, limit: int = 10) -> Table:
    """Return the ranked possible worlds, most probable first, with the mass of those that are not in the table.

    Intervals where they are told.
    """
    names = {h["id"]: f"{h.get('label') or h['type']} {h['id']}" for h in document.get("hypotheses", [])}
    listed = document.get("worlds", [])
    bounded = any("interval" in world for world in listed[:limit])
    stands = any("support" in world for world in listed[:limit])
    between = [("interval", "right")] * bounded
    columns = [
        ("rank", "right"),
        ("probability", "right"),
        *between,
        ("present", "left"),
        ("explained", "right"),
        ("noise", "right"),
        *[("stands on", "left")] * stands,
    ]
    table = _table("possible worlds", *columns)
    data = [a["id"] for a in document.get("appearances", [])] if document.get("causes_else") == "noise" else []
    for i, world in enumerate(listed[:limit], 1):
        causes = list(world.get("causes", {}).values())
        causes += ["noise"] * sum(a not in world.get("causes", {}) for a in data)
        noise = causes.count("noise")
        who = ", ".join(names.get(h, h) for h in world["present"]) or "nothing known"
        within = [interval(*world["interval"])] if bounded else []
        on = [words_of_standing(world.get("support"), world.get("stances", {}))] if stands else []
        told = str(len(causes) - noise), str(noise)
        table.add_row(str(i), chance(world["probability"]), *within, who, *told, *on)
    low, high = unlisted_beyond(document, limit)
    if high > 0:
        table.add_row("", *[""] * bounded, interval(low, high), Text("not listed", style="dim"), "", "")
    return table


def answers(document: Answers) -> Table:
    """Return the answers, in the order given.

    One known only within bounds prints both, and those of what is unfinished their probability too.
    """
    apart = bool(document.get("unfinished"))
    # as a Text a goal in it is no markup, and is not broken to the width of the table
    told = f" to {' '.join(document['asked'].split())}" if "asked" in document else ""
    title = Text(f"answers{told}", style="bold", no_wrap=True, overflow="ignore")
    table = _table(title, ("probability", "right"), *[("interval", "right")] * apart, ("goal", "left"))
    for answer in document.get("answers", []):
        low, high = answer.get("interval") or [answer["probability"]] * 2
        shown = chance(answer["probability"]) if low == high or apart else interval(low, high)
        table.add_row(shown, *[interval(low, high)] * apart, str(answer["goal"]))
    return table


def measures(document: Interpretation) -> Table:
    """Return the support of every hypothesis per feature type and its explanatory values (§7.2.4, Table 1)."""
    posed = any("pose_probability" in h for h in document.get("hypotheses", []))
    names = ("dv", "A", "C", "B", "D", "ev", "P(ev)", "reconsidered", "probability", *["P(pose)"] * posed)
    right = [(n, "right") for n in names]
    table = _table(
        f"measures{over_instances(document)}",
        ("hypothesis", "left"),
        ("status", "left"),
        ("feature type", "left"),
        *right,
    )
    dv = document["measures"]["dv"] if "measures" in document else {}
    for h in document.get("hypotheses", []):
        head = (f"{h.get('label') or h['type']} {h['id']}", h["status"])
        tail = (
            signed(h.get("ev")),
            chance(h.get("p_ev")),
            signed(h.get("ev_reconsidered")),
            chance(h.get("probability")),
            *[chance(h.get("pose_probability"))] * posed,
        )
        rows = _support_rows(h.get("support", {}), dv)
        for i, row in enumerate(rows):
            last = i == len(rows) - 1
            table.add_row(
                *(head if i == 0 else ("", "")), *row, *(tail if i == 0 else ("",) * len(tail)), end_section=last
            )
    return table


def over_instances(document: Interpretation) -> str:
    """What a title says where dv is not over the types of Σo (§5.1)."""
    said = document["measures"].get("dv_over", "types") if "measures" in document else "types"
    return "" if said == "types" else f", dv over the {said} in Δ"


def _support_rows(support: Mapping[str, Cells], dv: Mapping[str, float]) -> list[tuple[str, ...]]:
    """Feature type, dv and the four cells, the most distinctive type first; one row of dashes where there is none."""
    if not support:
        return [(NONE, NONE, *("0" for _ in CELLS))]
    kinds = sorted(support, key=lambda t: (-dv.get(t, 0.0), t))
    return [
        (kind, f"{dv[kind]:.3f}" if kind in dv else NONE, *(str(support[kind].get(cell, 0)) for cell in CELLS))
        for kind in kinds
    ]


def _table(title: str | Text, *columns: tuple[str, str]) -> Table:
    table = Table(
        title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, header_style="dim", pad_edge=False
    )
    for name, justify in columns:
        table.add_column(name, justify="right" if justify == "right" else "left", overflow="fold")
    return table


WIDTH = 118
"""Columns where stdout is no terminal: the same input gives the same bytes."""


def text_of_table(table: Table) -> str:
    """A table as the text to write; colours and emphasis only on a terminal, and not where NO_COLOR is set."""
    terminal = sys.stdout.isatty()
    buffer = io.StringIO()
    width = None if terminal else WIDTH
    styled = terminal and not os.environ.get("NO_COLOR")
    Console(file=buffer, force_terminal=styled, width=width, highlight=False).print(table, crop=False)
    return "\n".join(line.rstrip() for line in buffer.getvalue().splitlines())


def light_table(title: str, right: Iterable[str], left: Iterable[str]) -> Table:
    """An empty table whose first columns stand to the right, as numbers do."""
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in right:
        table.add_column(name, justify="right")
    for name in left:
        table.add_column(name)
    return table


def plain_table(title: str, rows: Sequence[Mapping[str, object]]) -> str:
    """Rows of one shape as a table, numbers to the right."""
    table = light_table(title, (), ())
    for name, value in rows[0].items() if rows else []:
        table.add_column(name, justify="right" if isinstance(value, (int, float)) else "left")
    for row in rows:
        table.add_row(*(f"{v:.3f}" if isinstance(v, float) else str(v) for v in row.values()))
    return text_of_table(table)
