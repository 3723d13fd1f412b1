"""The variables of a scene's factor graph: one alternative for the rivals of one instance (§8).

Vocabulary, each with an example value:

* ``Alternative((None, "h1", "h4"))``: state 0 is that none of them is present, state i that the i-th is, and no other
* ``Cast.place["h4"] == (0, 2)``: h4 is present where variable 0 is in state 2
* a *literal* ``(0, (2,))``: variable 0 is in one of these states
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from plogic.situation import FeatureFact, HypothesisFact, Situation

    Literal = tuple[int, tuple[int, ...]]


@dataclass(frozen=True)
class Alternative:
    """``states[0]`` is None, for none of them; ``states[i]`` the id of the hypothesis that is present."""

    states: tuple[str | None, ...]


@dataclass(frozen=True)
class Cast:
    """A situation with the variables of its graph and its look-ups; ``rivals`` holds both orders of a pair."""

    situation: Situation
    variables: tuple[Alternative, ...]
    place: dict[str, tuple[int, int]]
    opaque: frozenset[str]
    rivals: frozenset[tuple[str, str]]

    def hiders(self, h: HypothesisFact, f: FeatureFact) -> list[str]:
        """The hypotheses that hide the feature in every world in which they are present (D4, D7), each once."""
        return [g for g in dict.fromkeys(f.hidden_by) if g in self.opaque and g != h.id and (g, h.id) not in self.rivals]

    def literals(self, names: Iterable[str]) -> list[Literal]:
        """One literal a variable: one of ``names`` is present; by variable."""
        states: dict[int, list[int]] = {}
        for name in names:
            variable, state = self.place[name]
            states.setdefault(variable, []).append(state)
        return [(variable, tuple(sorted(states[variable]))) for variable in sorted(states)]


def cast_of(situation: Situation) -> Cast:
    """The variables, in the order of Δh of their first members, with the look-ups."""
    units = _groups(situation) if situation.reading == "posterior" else _cliques(situation)
    variables = tuple(Alternative((None, *members)) for members in units)
    place = {name: (v, s) for v, members in enumerate(units) for s, name in enumerate(members, 1)}
    rivals = situation.rivals | {(y, x) for x, y in situation.rivals}
    return Cast(situation, variables, place, frozenset(h.id for h in situation.hypotheses if h.opaque), rivals)


def _groups(situation: Situation) -> list[list[str]]:
    """Posterior: the hypotheses of one instance."""
    groups: dict[str, list[str]] = {}
    for h in situation.hypotheses:
        groups.setdefault(h.group, []).append(h.id)
    return list(groups.values())


def _cliques(situation: Situation) -> list[list[str]]:
    """Score: hypotheses of one group of which no two can be present together; each joins the first clique that it fits."""
    apart = situation.overlaps | situation.exclusive
    apart |= {(y, x) for x, y in apart}
    cliques: list[list[str]] = []
    of_group: dict[str, list[list[str]]] = {}
    for h in situation.hypotheses:
        mine = of_group.setdefault(h.group, [])
        fitting = next((clique for clique in mine if all((h.id, other) in apart for other in clique)), None)
        if fitting is None:
            mine.append([h.id])
            cliques.append(mine[-1])
        else:
            fitting.append(h.id)
    return cliques
