"""What a question comes to: it prints as the commands show it, shows itself in a notebook, and is a table of rows where it has any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, TypeVar, overload

from plogic.face.session.blocks import html_of, text_of

if TYPE_CHECKING:
    import pandas as pd

    from plogic.face.session.blocks import Block

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

    def to_pandas(self) -> pd.DataFrame:
        """Return the rows as a ``pandas.DataFrame``, with the columns of ``records``.

        Raises:
            InputError: where pandas is not installed; the message says how to install it.
        """
        from plogic.base.errors import InputError

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
