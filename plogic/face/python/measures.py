"""The measures of §5 side by side, as a table: a row each hypothesis, and one each feature type."""

from dataclasses import dataclass

from plogic.face.session.blocks import Block, Column, Rows, Table
from plogic.face.shown.figures import chance, signed
from plogic.facts.document import Interpretation
from plogic.run.measured import Distinctive, Measure, measured

TITLES = {
    "ev": "ev",
    "ev_to_B": "to_B",
    "ev_drop": "drop",
    "ev_reassign": "reassign",
    "ev_over_instances": "ev, Δ's dv",
    "shanahan": "Shanahan",
    "posterior": "posterior",
    "dv": "dv",
    "dv_over_instances": "Δ's dv",
    "rank": "rank",
}
"""Titles of a hypothesis' measures in the table."""
FEATURES = (
    Column("feature type"),
    Column("dv over types", right=True),
    Column("dv over instances in Δ", right=True),
)


@dataclass(frozen=True, repr=False)
class Measures(Rows[Measure]):
    """A row each hypothesis of Δh, in its order; ``features``: dv of each feature type."""

    hypotheses: tuple[Measure, ...]
    features: tuple[Distinctive, ...]

    @property
    def rows(self) -> tuple[Measure, ...]:
        """The hypotheses' measures."""
        return self.hypotheses

    def blocks(self) -> tuple[Block, ...]:
        """Both tables."""
        columns = (Column("hypothesis"), Column("status"), *(Column(title, right=True) for title in TITLES.values()))
        rows = tuple((f"{h.type} {h.id}", h.status, *(_cell(h, name) for name in TITLES)) for h in self.hypotheses)
        kinds = tuple((f.type, chance(f.over_types), chance(f.over_instances)) for f in self.features)
        return Table("hypotheses", columns, rows), Table("feature types", FEATURES, kinds)


def measures_of(document: Interpretation) -> Measures:
    """Return the measures of an interpretation. Raises SituationError where the posterior cannot be computed exactly."""
    return Measures(*measured(document))


def _cell(h: Measure, name: str) -> str:
    value: float | None = getattr(h, name)
    return signed(value) if name.startswith("ev") else chance(value)
