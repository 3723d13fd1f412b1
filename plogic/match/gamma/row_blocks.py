"""Large tables in blocks of rows: their memory is bounded, and the time can be asked between them.

* ``blocks(20_000, 20_000)``: slices of 52 rows
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

ENTRIES = 2**20
"""Entries of a block, one row at least: 8 MB of each array of floats; of the dozen that a search has at a time about
100 MB."""


def blocks(rows: int, columns: int) -> Iterator[slice]:
    """The rows of a table, as many at a time as have ``ENTRIES`` entries; none of an empty table."""
    some = max(1, ENTRIES // max(1, columns))
    return (slice(start, min(start + some, rows)) for start in range(0, rows, some))
