"""Claims of a benchmark: what was promised, the bar, the value seen, and whether it was met."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plogic.face.shown.tables import plain_table

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


@dataclass(frozen=True)
class Claim:
    """``Claim("both towers right", ">=", 0.95, 0.97)``; a value of None: it could not be measured."""

    claim: str
    relation: str
    bar: float
    value: float | None

    @property
    def met(self) -> bool:
        """Whether the value keeps to the bar."""
        if self.value is None:
            return False
        return self.value >= self.bar if self.relation == ">=" else self.value <= self.bar

    def document(self) -> dict[str, Any]:
        """As in the contract."""
        return {
            "claim": self.claim,
            "bar": f"{self.relation} {self.bar:g}",
            "value": None if self.value is None else round(self.value, 4),
            "met": self.met,
        }


def report(
    name: str,
    rows: Sequence[dict[str, Any]],
    claims: Sequence[Claim],
    *,
    as_json: bool,
    more: Mapping[str, Sequence[dict[str, Any]]] | None = None,
) -> tuple[str, bool]:
    """The benchmark's text (or JSON document), and whether every claim was met; ``more``: further tables, by name."""
    more = more or {}
    documents = [claim.document() for claim in claims]
    met = all(claim.met for claim in claims)
    if as_json:
        return json.dumps(
            {
                "bench": name,
                "rows": list(rows),
                **{key: list(table) for key, table in more.items()},
                "claims": documents,
            }
        ), met
    tables = [
        plain_table(f"bench {name}", rows),
        *(plain_table(key, table) for key, table in more.items()),
        plain_table("claims", documents),
    ]
    return "\n".join(tables), met
