"""The factors of what things stand on (§9.9): the image's one choice of a plane, and each hypothesis' stance.

In the posterior reading stances are summed out but where they are spoken of, or where a hypothesis may stand on very
many others; in the score reading they change nothing, and are there where they are spoken of alone.

A footing's variable says ``UNSAID`` where its hypothesis has none, or nothing says where things stand.
"""

from collections.abc import Collection
from itertools import product
from typing import NamedTuple

import numpy as np

from plogic.facts.stances import FREE, NONE
from plogic.scene.factors.weight_tables import IMPOSSIBLE, Cast, Choice, Literal, Tables, logs_of
from plogic.scene.readings.standing import Standing

MOST_HOLDERS = 6
"""Hypotheses to stand on that one factor looks at."""
UNSAID = ("",)


class Supports(NamedTuple):
    """The choice of the image, and those footings that are variables."""

    image: Choice | None = None
    footings: dict[str, Choice] = {}  # noqa: RUF012 - nobody adds to it


def add_support(tables: Tables, cast: Cast, spoken: Collection[str], *, planes: bool) -> Supports:
    """All of it; ``spoken``: whose stance is spoken of; ``planes``: whether anybody's, or the image's choice, is."""
    support, posterior = cast.situation.support, cast.situation.reading == "posterior"
    if support is None or not (posterior or planes):
        return Supports()
    standing = Standing(cast.situation, support)
    told = [
        name for name in standing.posed if name in spoken or (posterior and len(standing.holders(name)) > MOST_HOLDERS)
    ]
    footings = {name: _variable(tables, standing, name) for name in told}
    image = Choice(tables.variable(logs_of(standing.states.values())), tuple((state,) for state in standing.states))
    for name in standing.posed if posterior else told:
        if name in footings:
            _add_footing(tables, cast, standing, name, (footings[name], image))
        else:
            _add_summed(tables, cast, standing, name, image)
    return Supports(image, footings)


def _variable(tables: Tables, standing: Standing, name: str) -> Choice:
    ways = dict.fromkeys((s.on, str(s.face)) for s in standing.support.stances if s.hypothesis == name)
    states = (UNSAID, (FREE, NONE), *ways)
    return Choice(tables.variable([0.0] * len(states)), states)


def _add_footing(tables: Tables, cast: Cast, standing: Standing, name: str, made: tuple[Choice, Choice]) -> None:
    """The weight of each stance in each state of the image; in the posterior nothing stands on what is absent."""
    footing, image = made
    variable, state = cast.place[name]
    inside, beyond = _taken(tables, cast, standing, name)
    chance = np.full((tables.cards[variable], len(beyond) + 1), standing.by_chance.get(name, 0.0))
    chance[list(inside)] = 0.0
    chance[:, 1:] = 0.0
    chance[state] = 1.0
    weights = np.zeros((tables.cards[variable], len(footing.states), len(image.states), len(beyond) + 1))
    for i, (plane,) in enumerate(image.states):
        ways = standing.choice(name, plane)
        weights[:, 0, i] = 1.0 - chance if ways else 1.0
        for way in ways:
            weights[:, footing.states.index((way.on, way.face)), i] = chance * way.weight
    scope = (variable, footing.variable, image.variable, *beyond)
    with np.errstate(divide="ignore"):
        tables.add(scope, np.log(weights).reshape([tables.cards[v] for v in scope]))
    for holder in standing.holders(name) if cast.situation.reading == "posterior" else ():
        on_it = tuple(i for i, (on, *_) in enumerate(footing.states) if on == holder)
        literals: list[Literal] = [(footing.variable, on_it), (cast.place[holder][0], (cast.place[holder][1],))]
        tables.add_bits(literals, [0.0, IMPOSSIBLE, 0.0, 0.0])


def _add_summed(tables: Tables, cast: Cast, standing: Standing, name: str, image: Choice) -> None:
    """The sum over a hypothesis' stances, by who is present of those that it may stand on."""
    names, count = (name, *standing.holders(name)), len(image.states)
    digits = range((count - 1).bit_length())
    inside, beyond = _taken(tables, cast, standing, name)
    taken: list[Literal] = [*([(cast.place[name][0], inside)] if inside else []), *((v, (1,)) for v in beyond)]
    literals: list[Literal] = [(cast.place[one][0], (cast.place[one][1],)) for one in names]
    literals += [*taken, *((image.variable, tuple(i for i in range(count) if i >> digit & 1)) for digit in digits)]
    logs = np.zeros((2 ** len(digits), 2 ** len(taken), 2 ** len(names)))
    for i, by, row in product(range(count), range(2 ** len(taken)), range(2 ** len(names))):
        world = {one for bit, one in enumerate(names) if row >> bit & 1}
        logs[i, by, row] = standing.log_factor(name, image.states[i][0], world, taken=by > 0)
    tables.add_bits(literals, logs.ravel())


def _taken(tables: Tables, cast: Cast, standing: Standing, name: str) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Where one is present that excludes a hypothesis of which it matters.

    These states of its own variable; and a variable that is 1 where one of the others is, if there are any.
    """
    places = [cast.place[other] for other in standing.taking.get(name, ())]
    inside = tuple(state for variable, state in places if variable == cast.place[name][0])
    others: list[Literal] = [(variable, (state,)) for variable, state in places if variable != cast.place[name][0]]
    return inside, (tables.indicator(others),) if others else ()
