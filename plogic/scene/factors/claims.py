"""What one appearance, or one miss, says of who is present, with causes and hits summed out (§8, posterior).

Vocabulary:

* ``Claim``: a candidate feature that is matched to an appearance; ``Datum``: an appearance with all its claims
* a *row*: the number of a joint state of the variables of a scope, in C order
* a *pair* ``(weight of no cause among the claims, weight of exactly one)``
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.base.bounds import alternative
from plogic.scene.factors.weight_tables import IMPOSSIBLE, LONGEST_LIST, log

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.scene.factors.alternatives import Literal
    from plogic.scene.factors.weight_tables import Table, Tables

    Pair = tuple[float, float]
    Scope = tuple[int, ...]

Shape = dict[int, range]
"""The variables of a scope, each with what its states add to the number of a row."""
NOBODY = (1.0, 0.0)
"""The pair of no claim."""


class Claim(NamedTuple):
    """A candidate feature of the hypothesis at (variable, state); it is hidden where one of ``hiders`` holds, all of other variables."""

    variable: int
    state: int
    hit: float
    density: float
    hiders: tuple[Literal, ...]
    name: tuple[str, str]


class Datum(NamedTuple):
    """One claimed appearance: each claim's share of its alternative, the share of noise, and the density that a share of 1 stands for."""

    claims: list[Claim]
    shares: list[float]
    noise: float
    scale: float


def datum_of(claims: list[Claim], clutter: float) -> Datum:
    """N_i / Z for each claim, f / Z for noise, Z = ΣN + f; where all are 0 nothing can cause the appearance."""
    densities = [claim.density for claim in claims]
    densities.append(clutter)
    shares = alternative(densities)
    if not shares:
        return Datum(claims, [0.0] * len(claims), 0.0, 1.0)
    noise = shares.pop()
    return Datum(claims, shares, noise, sum(densities))


def scope_of(claims: Sequence[Claim]) -> Scope:
    """The variables that have a say."""
    scope = {claim.variable for claim in claims}
    for claim in claims:
        if claim.hiders:
            scope.update([v for v, _ in claim.hiders])
    return tuple(sorted(scope))


def add_datum(tables: Tables, datum: Datum, scope: Scope, cards: tuple[int, ...]) -> None:
    """Σ_i N_i h_i Π_{j≠i}(1−h_j) + f Π_j(1−h_j) over the present, expected claimants, in every joint state of those who have a say."""
    size = math.prod(cards)
    if size > LONGEST_LIST:
        tables.add(scope, _large(tables, datum, scope))
        return
    by_variable = _unhidden(datum, scope, cards)
    tables.add_list(
        scope, _hidden(datum, _steps(scope, cards, size), size) if by_variable is None else _joined(datum, by_variable)
    )


def add_miss(tables: Tables, claim: Claim) -> None:
    """1 − h_F where the feature, which something hides, is expected; no appearance was found for it."""
    scope = scope_of([claim])
    cards = tables.shape(scope)
    size = math.prod(cards)
    logs = [0.0] * size
    missed = log(1.0 - claim.hit)
    for row in _rows(claim, _steps(scope, cards, size)):
        logs[row] = missed
    tables.add_list(scope, logs)


def _unhidden(datum: Datum, scope: Scope, cards: tuple[int, ...]) -> list[list[Pair]] | None:
    """One pair a state of each variable of the scope, whose states exclude each other; None where something hides a claim."""
    found = {v: [NOBODY] * card for v, card in zip(scope, cards, strict=True)}
    for (variable, state, hit, _, hiders, _), share in zip(datum.claims, datum.shares, strict=True):
        if hiders:
            return None
        found[variable][state] = (1.0 - hit, share * hit)
    return list(found.values())


def _joined(datum: Datum, lists: list[list[Pair]]) -> list[float]:
    """The logs of every row: exactly one cause is one among the variables before and none here, or none before and one here."""
    last = lists.pop()
    pairs = lists[0] if lists else [NOBODY]
    for mine in lists[1:]:
        pairs = [(none * free, one * free + none * hit) for none, one in pairs for free, hit in mine]
    noise, scale, ln = datum.noise, datum.scale, math.log
    return [
        ln(weight) if (weight := (noise * (none * free) + (one * free + none * hit)) * scale) > 0.0 else IMPOSSIBLE
        for none, one in pairs
        for free, hit in last
    ]


def _hidden(datum: Datum, steps: Shape, size: int) -> list[float]:
    """The logs of every row, claim by claim."""
    none, one = [1.0] * size, [0.0] * size
    for claim, share in zip(datum.claims, datum.shares, strict=True):
        hit, miss = share * claim.hit, 1.0 - claim.hit
        for r in _rows(claim, steps):
            one[r] = one[r] * miss + none[r] * hit
            none[r] *= miss
    noise, scale, ln = datum.noise, datum.scale, math.log
    return [
        ln(weight) if (weight := (noise * x + y) * scale) > 0.0 else IMPOSSIBLE for x, y in zip(none, one, strict=True)
    ]


def _steps(scope: Scope, cards: tuple[int, ...], size: int) -> Shape:
    shape: Shape = {}
    step = size
    for v, card in zip(scope, cards, strict=True):
        above, step = step, step // card
        shape[v] = range(0, above, step)
    return shape


def _rows(claim: Claim, shape: Shape) -> list[int]:
    """Where the claim's hypothesis is present and its feature expected."""
    mine, hidden = claim.variable, dict(claim.hiders)
    rows = [shape[mine][claim.state]]
    for v, steps in shape.items():
        if v in hidden:
            states = hidden[v]
            bare = [step for s, step in enumerate(steps) if s not in states]
            rows = [row + step for row in rows for step in bare]
        elif v != mine:
            rows = [row + step for row in rows for step in steps]
    return rows


def _large(tables: Tables, datum: Datum, scope: Scope) -> Table:
    """As ``_joined``, with arrays, and with what hides claims; one axis a variable."""
    none, one = np.ones(()), np.zeros(())
    for v in sorted({claim.variable for claim in datum.claims}):
        mine = [(claim, share) for claim, share in zip(datum.claims, datum.shares, strict=True) if claim.variable == v]
        local = scope_of([claim for claim, _ in mine])
        cards = tables.shape(local)
        size = math.prod(cards)
        free, hit = np.ones(size), np.zeros(size)
        for claim, share in mine:
            rows = _rows(claim, _steps(local, cards, size))
            free[rows], hit[rows] = 1.0 - claim.hit, share * claim.hit
        shape = [tables.cards[u] if u in local else 1 for u in scope]
        free, hit = free.reshape(shape), hit.reshape(shape)
        none, one = none * free, one * free + none * hit
    with np.errstate(divide="ignore"):
        logs: Table = np.log((datum.noise * none + one) * datum.scale)
    return logs
