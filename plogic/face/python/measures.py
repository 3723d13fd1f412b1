"""The measures of §5 of each hypothesis, side by side: ev in each mode, Shanahan's, the posterior, dv and rank."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, get_args

import numpy as np

from plogic.base.errors import InconsistentError
from plogic.face.session.blocks import Column, Table
from plogic.face.session.rows import Rows
from plogic.facts.dependence import Scene
from plogic.facts.situation import Reading, Reconsider
from plogic.measures.distinctiveness import distinctiveness
from plogic.measures.shanahan import shanahan_values
from plogic.scene.readings.score_reading import p_ev
from plogic.scene.worlds.ranked_worlds import ranked_worlds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from plogic.face.session.blocks import Block
    from plogic.facts.hypothesis import Hypothesis
    from plogic.facts.situation import Situation

NOISE = 0.02
"""Prior of "this appearance is noise", an abducible of Shanahan's measure."""
LEAST = 1e-9
"""Least prior of an abducible: a hit rate of 1 makes a miss improbable, not impossible."""


@dataclass(frozen=True)
class Measure:
    """The measures of one hypothesis.

    ``ev`` is that of the hypothesis alone; ``ev_to_B``, ``ev_drop`` and ``ev_reassign`` are taken beside the accepted
    ones in each mode of §5.5; None where ev is 0/0. ``shanahan`` compares the hypotheses as rival explanations, each
    alone; ``score`` and ``posterior`` are P(present) in the two readings, None where no world is possible there. ``dv``
    of its feature types over Σ, ``dv_in_delta`` over the accepted hypotheses, ``rank`` of its type.
    """

    hypothesis: str
    type: str
    status: str
    ev: float | None
    ev_to_B: float | None  # noqa: N815 - the mode is called so
    ev_drop: float | None
    ev_reassign: float | None
    shanahan: float
    score: float | None
    posterior: float | None
    dv: dict[str, float]
    dv_in_delta: dict[str, float]
    rank: float | None


@dataclass(frozen=True, repr=False)
class Measures(Rows[Measure]):
    """A row each hypothesis of Δh, in its order."""

    measures: tuple[Measure, ...]

    @property
    def rows(self) -> tuple[Measure, ...]:
        """The hypotheses' measures."""
        return self.measures

    def blocks(self) -> tuple[Block, ...]:
        """One table; dv by feature type only in the data."""
        from plogic.face.shown.tables import NONE, chance

        numbers = ("ev", "to_B", "drop", "reassign", "Shanahan", "score", "posterior", "rank")
        columns = (Column("hypothesis"), Column("status"), *(Column(name, right=True) for name in numbers))
        rows = tuple(
            (
                f"{m.type} {m.hypothesis}", m.status, _signed(m.ev), _signed(m.ev_to_B), _signed(m.ev_drop),
                _signed(m.ev_reassign), chance(m.shanahan), chance(m.score), chance(m.posterior),
                NONE if m.rank is None else f"{m.rank:.3f}",
            )
            for m in self.measures
        )  # fmt: skip
        return (Table("measures", columns, rows),)


def _signed(value: float | None) -> str:
    """A value to two places; noise in its last digits decides no tie."""
    from plogic.face.shown.tables import signed

    return signed(None if value is None else float(f"{value:.12g}"))


def measures_of(situation: Situation, ev: Mapping[str, float | None], status: Mapping[str, str]) -> Measures:
    """Return the measures of every hypothesis; ``ev`` of each alone and ``status`` come from the interpretation."""
    by_mode = {mode: _beside(replace(situation, reconsider=mode), status) for mode in get_args(Reconsider)}
    chances = {reading: _chances(replace(situation, reading=reading)) for reading in get_args(Reading)}
    values = shanahan_values({h.id: abducibles(h, situation) for h in situation.hypotheses})
    in_delta = _dv_in_delta(situation, status)
    return Measures(
        tuple(
            Measure(
                h.id,
                h.type,
                status[h.id],
                ev[h.id],
                by_mode["to_B"][h.id],
                by_mode["drop"][h.id],
                by_mode["reassign"][h.id],
                values[h.id],
                chances["score"].get(h.id),
                chances["posterior"].get(h.id),
                {kind: situation.dv[kind] for kind in _kinds(h) if kind in situation.dv},
                {kind: in_delta[kind] for kind in _kinds(h) if kind in in_delta},
                situation.rank.get(h.type),
            )
            for h in situation.hypotheses
        )
    )


def abducibles(h: Hypothesis, situation: Situation) -> list[float]:
    """Priors of what the explanation "it alone stands there" takes on: the object, each hit, each miss, and noise for what it leaves over."""
    expected = [f for f in h.features if h.expects(f)]
    found = [f for f in expected if f.match is not None]
    left = len(situation.appearances) - len({f.match for f in found})
    hits = [f.hit_rate for f in found]
    misses = [1.0 - f.hit_rate for f in expected if f.match is None]
    priors = [situation.priors.get(h.type, 1.0), *hits, *misses, *[NOISE] * left]
    return [min(max(prior, LEAST), 1.0) for prior in priors]


def _beside(situation: Situation, status: Mapping[str, str]) -> dict[str, float | None]:
    """Ev of each hypothesis beside the accepted ones, in the situation's mode (§5.5)."""
    scene = Scene(situation)
    values: dict[str, float | None] = {}
    for h in situation.hypotheses:
        present = {g.id: np.array([g.id == h.id or status[g.id] == "accepted"]) for g in situation.hypotheses}
        share = float(p_ev(scene, h, present)[0])
        values[h.id] = None if np.isnan(share) else 2.0 * share - 1.0
    return values


def _chances(situation: Situation) -> dict[str, float]:
    """P(present) of each hypothesis; nothing where no world is possible."""
    try:
        return ranked_worlds(situation, 1).marginals
    except InconsistentError:
        return {}


def _dv_in_delta(situation: Situation, status: Mapping[str, str]) -> dict[str, float]:
    """Dv over the instances in Δ; over Σ where nothing is accepted (the variant of §9)."""
    counts = Counter(
        part.type
        for h in situation.hypotheses
        if status[h.id] == "accepted"
        for part in h.parts
        if part.kind == "feature"
    )
    if not counts:
        return situation.dv
    return distinctiveness({kind: counts.get(kind, 0) for kind in situation.dv})


def _kinds(h: Hypothesis) -> list[str]:
    return sorted({f.type for f in h.features})
