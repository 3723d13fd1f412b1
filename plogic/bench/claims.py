"""Claims of a benchmark: what was promised, the bar, the value seen, and whether it was met."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plogic.commands.printing import plain_table

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True)
class Claim:
    """``Claim("both towers right", ">=", 0.95, 0.97)``."""

    claim: str
    relation: str
    bar: float
    value: float

    @property
    def met(self) -> bool:
        """Whether the value keeps to the bar."""
        return self.value >= self.bar if self.relation == ">=" else self.value <= self.bar

    def document(self) -> dict[str, Any]:
        """As in the contract."""
        return {
            "claim": self.claim,
            "bar": f"{self.relation} {self.bar:g}",
            "value": round(self.value, 4),
            "met": self.met,
        }


def report(name: str, rows: Sequence[dict[str, Any]], claims: Sequence[Claim], *, as_json: bool) -> tuple[str, bool]:
    """The benchmark's text (or JSON document), and whether every claim was met."""
    documents = [claim.document() for claim in claims]
    met = all(claim.met for claim in claims)
    if as_json:
        return json.dumps({"bench": name, "rows": list(rows), "claims": documents}), met
    return plain_table(f"bench {name}", rows) + "\n" + plain_table("claims", documents), met
