"""From a situation to its factor graph: the second form of what ``plogic.scene.text.program_text`` says, tested equal to it (§8).

A joint state of ``variables`` is a world, an assignment of present/1; its weight is the world's weight in the program.
Causes, hits and picks are summed out; where that would take a factor over too many hypotheses, they stay as auxiliary
variables, numbered last.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from plogic.scene.factors.alternatives import Alternative, Cast, cast_of
from plogic.scene.factors.floating_factors import add_floating
from plogic.scene.factors.posterior_factors import add_posterior
from plogic.scene.factors.score_factors import add_score
from plogic.scene.factors.weight_tables import Tables

if TYPE_CHECKING:
    from collections.abc import Collection

    from plogic.facts.situation import Situation
    from plogic.inference.graph import FactorGraph
    from plogic.scene.factors.posterior_factors import Cause


@dataclass(frozen=True)
class SceneGraph:
    """``variables[v]`` is what variable v of the graph decides; ``place["h4"]`` is the (variable, state) in which h4 is present.

    ``causes["a3"]``: the cause of an appearance, as a variable, if one was asked for, or that has very many claimants.
    ``decided``: auxiliary variables of which each has one possible state in a world.
    """

    graph: FactorGraph
    variables: tuple[Alternative, ...]
    place: dict[str, tuple[int, int]]
    causes: dict[str, Cause]
    decided: frozenset[int] = frozenset()

    @property
    def auxiliary(self) -> tuple[int, ...]:
        """The variables that are no alternative of hypotheses."""
        return tuple(range(len(self.variables), len(self.graph.cards)))

    def present(self, states: tuple[int, ...]) -> list[str]:
        """The hypotheses that are present in a joint state, by variable."""
        return [str(v.states[s]) for v, s in zip(self.variables, states, strict=False) if s]


def scene_graph(situation: Situation, *, explicit: Collection[str] = ()) -> SceneGraph:
    """The graph of a checked situation (``plogic.facts.sanity.check``); of appearances in ``explicit`` the cause is a variable (posterior)."""
    cast = cast_of(situation)
    tables = Tables([len(v.states) for v in cast.variables])
    causes: dict[str, Cause] = {}
    if situation.reading == "posterior":
        causes = add_posterior(tables, cast, explicit)
    else:
        add_score(tables, cast)
    _add_constraints(tables, cast)
    decided = add_floating(tables, cast)
    return SceneGraph(tables.graph(), cast.variables, cast.place, causes, decided)


def _add_constraints(tables: Tables, cast: Cast) -> None:
    """A4, and in the score reading that an appearance serves one feature: the two are never present together."""
    situation, place = cast.situation, cast.place
    pairs = situation.overlaps | (situation.exclusive if situation.reading == "score" else frozenset())
    tables.forbid([(place[x], place[y]) for x, y in pairs])
