"""The variables of a scene's factor graph: one alternative for the rivals of one instance (§8).

Vocabulary, each with an example value:

* ``Alternative((None, "h1", "h4"))``: state 0 is that none of them is present, state i that the i-th is, and no other
* ``Cast.place["h4"] == (0, 2)``: h4 is present where variable 0 is in state 2
* a *literal* ``(0, (2,))``: variable 0 is in one of these states
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterable

    from plogic.facts.hypothesis import FeatureFact, Hypothesis
    from plogic.facts.situation import Situation


Literal: TypeAlias = tuple[int, tuple[int, ...]]
"""A variable, and the states of which it is in one."""


@dataclass(frozen=True)
class Alternative:
    """``states[0]`` is None, for none of them; ``states[i]`` the id of the hypothesis that is present."""

    states: tuple[str | None, ...]


@dataclass(frozen=True)
class Cast:
    """A situation with the variables of its graph and its look-ups.

    ``unhiding["h4"]``: h4 and its rivals, none of which hides h4 (§4.1).
    """

    situation: Situation
    variables: tuple[Alternative, ...]
    place: dict[str, tuple[int, int]]
    opaque: frozenset[str]
    unhiding: dict[str, set[str]]

    def hiders(self, h: Hypothesis, f: FeatureFact) -> list[str]:
        """The hypotheses that hide the feature in every world in which they are present (D4, D7), each once."""
        opaque, unhiding = self.opaque, self.unhiding[h.id]
        found = [g for g in f.hidden_by if g in opaque and g not in unhiding]
        return found if len(found) < 2 else list(dict.fromkeys(found))

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
    variables = tuple([Alternative((None, *members)) for members in units])
    place = {name: (v, s) for v, members in enumerate(units) for s, name in enumerate(members, 1)}
    unhiding = {h.id: {h.id} for h in situation.hypotheses}
    for x, y in situation.rivals:
        unhiding[x].add(y)
        unhiding[y].add(x)
    return Cast(situation, variables, place, frozenset([h.id for h in situation.hypotheses if h.opaque]), unhiding)


def _groups(situation: Situation) -> list[list[str]]:
    """Posterior: the hypotheses of one instance."""
    groups: dict[str, list[str]] = {}
    for h in situation.hypotheses:
        groups.setdefault(h.group, []).append(h.id)
    return list(groups.values())


def _cliques(situation: Situation) -> list[list[str]]:
    """Score: hypotheses of one group of which no two can be present together.

    Each joins the first clique that it fits.
    """
    cliques: list[list[str]] = []
    of_group: dict[str, list[list[str]]] = {}
    for h in situation.hypotheses:
        mine = of_group.setdefault(h.group, [])
        fitting = next((clique for clique in mine if _apart(situation, h.id, clique)), None) if mine else None
        if fitting is None:
            mine.append([h.id])
            cliques.append(mine[-1])
        else:
            fitting.append(h.id)
    return cliques


def _apart(situation: Situation, name: str, others: Iterable[str]) -> bool:
    """Whether constraints forbid the hypothesis to be present together with any of the others."""
    overlaps, exclusive = situation.overlaps, situation.exclusive
    for other in others:
        pair, converse = (name, other), (other, name)
        if not (pair in exclusive or converse in exclusive or pair in overlaps or converse in overlaps):
            return False
    return True
