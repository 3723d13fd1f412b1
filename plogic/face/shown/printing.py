"""Tables as text: plain where stdout is no terminal, and where NO_COLOR is set."""

from __future__ import annotations

import io
import os
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

WIDTH = 118
"""Columns where stdout is no terminal: the same input gives the same bytes."""


def text_of_table(table: Table) -> str:
    """A table as the text to write; colours and emphasis only on a terminal, and not where NO_COLOR is set."""
    from rich.console import Console

    terminal = sys.stdout.isatty()
    buffer = io.StringIO()
    width = None if terminal else WIDTH
    styled = terminal and not os.environ.get("NO_COLOR")
    Console(file=buffer, force_terminal=styled, width=width, highlight=False).print(table)
    return "\n".join(line.rstrip() for line in buffer.getvalue().splitlines())


def plain_table(title: str, rows: Sequence[dict[str, Any]]) -> str:
    """Rows of one shape as a table, numbers to the right."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for name, value in rows[0].items() if rows else []:
        table.add_column(name, justify="right" if isinstance(value, (int, float)) else "left")
    for row in rows:
        table.add_row(*(Text(f"{v:.3f}" if isinstance(v, float) else str(v)) for v in row.values()))
    return text_of_table(table)
