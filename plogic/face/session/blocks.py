r"""What a result is shown as: notes, tables and trees; one description, from which the text and the HTML are made.

Vocabulary, each with an example value:

* ``Note``, a sentence, ``Note("nothing is observed")``
* ``Table``, ``Table("answers", (Column("probability", right=True), Column("goal")), (("0.970", "present(h1)"),))``
* ``Lines``, preformatted lines under a heading, ``Lines("why 1: ...", ("present(h1)  [rule]", ...))``

Names come from strangers: whatever no terminal prints (escape sequences, line breaks, changes of direction) is shown as
its escape, ``\\x1b``.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

WIDTH = 118
"""Columns of a text where no terminal says how many there are: the same result gives the same bytes."""


@dataclass(frozen=True)
class Note:
    """One sentence, on a line of its own."""

    text: str


@dataclass(frozen=True)
class Column:
    """A column's heading; numbers stand to the right."""

    name: str
    right: bool = False


@dataclass(frozen=True)
class Table:
    """Rows of as many cells as there are columns."""

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Lines:
    """Preformatted lines; in HTML they fold under their heading."""

    heading: str
    lines: tuple[str, ...]


Block = Note | Table | Lines


def visible(text: str) -> str:
    """The text on one line, with an escape for every character that cannot be printed."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def text_of(blocks: Iterable[Block], *, width: int = WIDTH, styled: bool = False) -> str:
    """The blocks as text for a terminal of ``width`` columns; colours and emphasis only where ``styled``."""
    return "\n".join(_text(block, width, styled=styled) for block in blocks)


def html_of(blocks: Iterable[Block]) -> str:
    """The blocks as one element of HTML, everything escaped, nothing that runs and nothing fetched."""
    return f'<div class="plogic">{"".join(_html(block) for block in blocks)}</div>'


def _text(block: Block, width: int, *, styled: bool) -> str:
    if isinstance(block, Note):
        return visible(block.text)
    if isinstance(block, Lines):
        return "\n".join(
            [*([visible(block.heading)] if block.heading else []), *(visible(line) for line in block.lines)]
        )
    return _table_text(block, width, styled=styled)


def _table_text(block: Table, width: int, *, styled: bool) -> str:
    from rich import box
    from rich.console import Console
    from rich.table import Table as Grid
    from rich.text import Text

    grid = Grid(box=box.SIMPLE_HEAD, header_style="dim", pad_edge=False)
    for column in block.columns:
        grid.add_column(column.name, justify="right" if column.right else "left", overflow="fold")
    for row in block.rows:
        grid.add_row(*(Text(visible(cell)) for cell in row))
    buffer = io.StringIO()
    console = Console(file=buffer, force_terminal=styled, force_jupyter=False, width=width, highlight=False)
    console.print(Text(visible(block.title), style="bold"), soft_wrap=True)
    console.print(grid)
    return "\n".join(line.rstrip() for line in buffer.getvalue().splitlines())


def _html(block: Block) -> str:
    if isinstance(block, Note):
        return f"<p>{_safe(block.text)}</p>"
    if isinstance(block, Lines):
        lines = "\n".join(_safe(line) for line in block.lines)
        return (
            f"<details open><summary>{_safe(block.heading)}</summary><pre>{lines}</pre></details>"
            if block.heading
            else f"<pre>{lines}</pre>"
        )
    return _table_html(block)


def _table_html(block: Table) -> str:
    sides = [' style="text-align: right"' if column.right else ' style="text-align: left"' for column in block.columns]
    head = "".join(f"<th{side}>{_safe(column.name)}</th>" for column, side in zip(block.columns, sides, strict=True))
    rows = [
        "".join(f"<td{side}>{_safe(cell)}</td>" for cell, side in zip(row, sides, strict=True)) for row in block.rows
    ]
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    return f"<table><caption>{_safe(block.title)}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _safe(text: str) -> str:
    return escape(visible(text), quote=True)
