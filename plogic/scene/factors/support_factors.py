"""The factors of what things stand on (§9.9): the image's one choice of a plane, and each hypothesis' stance.

In the posterior reading stances are summed out but where they are spoken of, or where a hypothesis may stand on very
many others; in the score reading they change nothing, and are there where they are spoken of alone.

A stance's variable says ``UNSAID`` where its hypothesis is absent, or nothing says where things stand.
"""

from collections.abc import Collection
from itertools import product
from typing import NamedTuple

import numpy as np

from plogic.facts.stances import FREE, NONE
from plogic.scene.factors.weight_tables import IMPOSSIBLE, Cast, Choice, Literal, Tables, log, logs_of
from plogic.scene.readings.standing import Standing

MOST_HOLDERS = 6
"""Hypotheses to stand on that one factor looks at."""
UNSAID = ("",)


class Supports(NamedTuple):
    """The choice of the image, and those stances that are variables."""

    image: Choice | None = None
    stances: dict[str, Choice] = {}  # noqa: RUF012 - nobody adds to it


def add_support(tables: Tables, cast: Cast, spoken: Collection[str], *, planes: bool) -> Supports:
    """All of it; ``spoken``: whose stance is spoken of; ``planes``: whether anybody's, or the image's choice, is."""
    support, posterior = cast.situation.support, cast.situation.reading == "posterior"
    if support is None or not (posterior or planes):
        return Supports()
    standing = Standing(cast.situation, support)
    told = [
        name for name in standing.posed if name in spoken or (posterior and len(standing.holders(name)) > MOST_HOLDERS)
    ]
    stances = {name: _variable(tables, standing, name) for name in told}
    image = Choice(tables.variable(logs_of(standing.states.values())), tuple((state,) for state in standing.states))
    for name in standing.posed if posterior else told:
        if name in stances:
            _add_stance(tables, cast, standing, name, (stances[name], image))
        else:
            _add_summed(tables, cast, standing, name, image)
    return Supports(image, stances)


def _variable(tables: Tables, standing: Standing, name: str) -> Choice:
    ways = dict.fromkeys((s.on, str(s.face)) for s in standing.support.stances if s.hypothesis == name)
    states = (UNSAID, (FREE, NONE), *ways)
    return Choice(tables.variable([0.0] * len(states)), states)


def _add_stance(tables: Tables, cast: Cast, standing: Standing, name: str, made: tuple[Choice, Choice]) -> None:
    """The weight of each stance in each state of the image; in the posterior nothing stands on what is absent."""
    stance, image = made
    variable, state = cast.place[name]
    table = np.full((tables.cards[variable], len(stance.states), len(image.states)), IMPOSSIBLE)
    table[:, 0] = 0.0
    for i, (plane,) in enumerate(image.states):
        ways = standing.choice(name, plane)
        table[state, 0, i] = IMPOSSIBLE if ways else 0.0
        for way in ways:
            table[state, stance.states.index((way.on, way.face)), i] = log(way.weight)
    tables.add((variable, stance.variable, image.variable), table)
    for holder in standing.holders(name) if cast.situation.reading == "posterior" else ():
        on_it = tuple(i for i, (on, *_) in enumerate(stance.states) if on == holder)
        literals: list[Literal] = [(stance.variable, on_it), (cast.place[holder][0], (cast.place[holder][1],))]
        tables.add_bits(literals, [0.0, IMPOSSIBLE, 0.0, 0.0])


def _add_summed(tables: Tables, cast: Cast, standing: Standing, name: str, image: Choice) -> None:
    """The sum over a hypothesis' stances, by who is present of those that it may stand on."""
    names, count = (name, *standing.holders(name)), len(image.states)
    digits = range((count - 1).bit_length())
    literals: list[Literal] = [(cast.place[one][0], (cast.place[one][1],)) for one in names]
    literals += [(image.variable, tuple(i for i in range(count) if i >> digit & 1)) for digit in digits]
    logs = np.zeros((2 ** len(digits), 2 ** len(names)))
    for i, row in product(range(count), range(1, 2 ** len(names), 2)):
        world = {one for bit, one in enumerate(names) if row >> bit & 1}
        logs[i, row] = standing.log_factor(name, image.states[i][0], world)
    tables.add_bits(literals, logs.ravel())
