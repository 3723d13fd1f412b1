r"""What a result is shown as: notes, tables and trees; one description, from which the text and the HTML are made.

Vocabulary, each with an example value:

* ``Note``, a sentence, ``Note("nothing is observed")``
* ``Table``, ``Table("answers", (Column("probability", right=True), Column("goal")), (("0.970", "present(h1)"),))``
* ``Lines``, preformatted lines under a heading, ``Lines("why 1: ...", ("present(h1)  [rule]", ...))``

Names come from strangers: whatever no terminal prints (escape sequences, line breaks, changes of direction) is shown as
its escape, ``\\x1b``.
"""

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from html import escape
from typing import TYPE_CHECKING, Any, TypeVar, overload

from geometry.printable import visible
from plogic.base.errors import InputError

if TYPE_CHECKING:
    import pandas as pd


WIDTH = 118
"""Columns of a text where no terminal says how many there are: the same result gives the same bytes."""


@dataclass(frozen=True)
class Note:
    """One sentence, on a line of its own."""

    text: str

    def lines(self, width: int, *, styled: bool) -> list[str]:  # noqa: ARG002 - a terminal wraps it
        """The sentence."""
        return [visible(self.text)]

    def html(self) -> str:
        """A paragraph."""
        return f"<p>{_safe(self.text)}</p>"


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

    def lines(self, width: int, *, styled: bool) -> list[str]:
        """The title, then the rows under their headings."""
        from rich import box
        from rich.console import Console
        from rich.table import Table as Grid
        from rich.text import Text

        grid = Grid(box=box.SIMPLE_HEAD, header_style="dim", pad_edge=False)
        for column in self.columns:
            grid.add_column(column.name, justify="right" if column.right else "left", overflow="fold")
        for row in self.rows:
            grid.add_row(*(Text(visible(cell)) for cell in row))
        buffer = io.StringIO()
        console = Console(file=buffer, force_terminal=styled, force_jupyter=False, width=width, highlight=False)
        console.print(Text(visible(self.title), style="bold"), soft_wrap=True)
        console.print(grid)
        return [line.rstrip() for line in buffer.getvalue().splitlines()]

    def html(self) -> str:
        """A table with its caption."""
        sides = [
            ' style="text-align: right"' if column.right else ' style="text-align: left"' for column in self.columns
        ]
        head = "".join(f"<th{side}>{_safe(column.name)}</th>" for column, side in zip(self.columns, sides, strict=True))
        rows = [
            "".join(f"<td{side}>{_safe(cell)}</td>" for cell, side in zip(row, sides, strict=True)) for row in self.rows
        ]
        body = "".join(f"<tr>{row}</tr>" for row in rows)
        return (
            f"<table><caption>{_safe(self.title)}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        )


@dataclass(frozen=True)
class Lines:
    """Preformatted lines; in HTML they fold under their heading."""

    heading: str
    body: tuple[str, ...]

    def lines(self, width: int, *, styled: bool) -> list[str]:  # noqa: ARG002 - they are laid out already
        """The heading, where there is one, and the lines."""
        return [visible(line) for line in ((self.heading, *self.body) if self.heading else self.body)]

    def html(self) -> str:
        """The lines, in an element that opens and closes where they have a heading."""
        lines = "\n".join(_safe(line) for line in self.body)
        heading = f"<details open><summary>{_safe(self.heading)}</summary>" if self.heading else ""
        return f"{heading}<pre>{lines}</pre>{'</details>' * bool(heading)}"


Block = Note | Table | Lines


def text_of(blocks: Iterable[Block], *, width: int = WIDTH, styled: bool = False) -> str:
    """The blocks as text for a terminal of ``width`` columns; colours and emphasis only where ``styled``."""
    return "\n".join(line for block in blocks for line in block.lines(width, styled=styled))


def html_of(blocks: Iterable[Block]) -> str:
    """The blocks as one element of HTML, everything escaped, nothing that runs and nothing fetched."""
    return f'<div class="plogic">{"".join(block.html() for block in blocks)}</div>'


def _safe(text: str) -> str:
    return escape(visible(text), quote=True)


Row_co = TypeVar("Row_co", covariant=True)


class Result:
    """Anything that a question comes to; the subclasses are frozen dataclasses, equal by value."""

    def blocks(self) -> tuple[Block, ...]:
        """What there is to show, in order."""
        raise NotImplementedError

    def text(self, *, width: int = 118, styled: bool = False) -> str:
        """The text for a terminal of so many columns."""
        return text_of(self.blocks(), width=width, styled=styled)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        return html_of(self.blocks())


class Rows(Result, Sequence[Row_co]):
    """A table: a sequence of rows with named fields."""

    @property
    def rows(self) -> tuple[Row_co, ...]:
        """The rows, in the order in which they are shown."""
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, index: int) -> Row_co: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Row_co, ...]: ...
    def __getitem__(self, index: int | slice) -> Row_co | tuple[Row_co, ...]:
        return self.rows[index]

    def records(self) -> list[dict[str, Any]]:
        """The rows as dictionaries: a column each field, and of bindings a column each variable."""
        return [_record(row) for row in self.rows]

    def to_pandas(self) -> "pd.DataFrame":
        """Return the rows as a ``pandas.DataFrame``, with the columns of ``records``.

        Raises:
            InputError: where pandas is not installed; the message says how to install it.
        """
        try:
            import pandas as pd
        except ImportError:
            raise InputError("to_pandas: pandas is not installed; install it: pip install pandas") from None
        return pd.DataFrame(self.records())


def _record(row: object) -> dict[str, Any]:
    """A row's fields by their names; those of ``bindings`` in its place."""
    if not is_dataclass(row):
        raise TypeError(f"{type(row).__name__} is no row")
    record: dict[str, Any] = {}
    for field in fields(row):
        value = getattr(row, field.name)
        record |= dict(value) if field.name == "bindings" else {field.name: value}
    return record
