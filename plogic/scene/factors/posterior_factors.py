"""The factors of the posterior reading, causes and hits summed out analytically (§8): priors, misses in Γ, and Γ.

Vocabulary:

* ``Claim``: a candidate feature that is matched to an appearance; ``Datum``: an appearance with all its claims
* a *row*: the number of a joint state of the variables of a scope, in C order
* a *pair* ``(weight of no cause among the claims, weight of exactly one)``
"""

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from geometry.arrays import Mask
from plogic.base.bounds import LEAST, bounded
from plogic.facts.hypothesis import expected
from plogic.scene.factors.weight_tables import (
    IMPOSSIBLE,
    LONGEST_LIST,
    Cast,
    Choice,
    Literal,
    Table,
    Tables,
    log,
    logs_of,
    too_wide,
)
from plogic.scene.readings.world_weights import DEFAULT_PRIOR, shares_of

Pair = tuple[float, float]
Scope = tuple[int, ...]

Shape = dict[int, range]
"""The variables of a scope, each with what its states add to the number of a row."""
NOBODY = (1.0, 0.0)
"""The pair of no claim."""


class Claim(NamedTuple):
    """A candidate feature of the hypothesis at (variable, state).

    It is hidden where one of ``hiders`` holds, all of other variables.
    """

    variable: int
    state: int
    hit: float
    density: float
    hiders: tuple[Literal, ...]
    name: tuple[str, str]


class Datum(NamedTuple):
    """One claimed appearance: each claim's share of its alternative, noise's share, and the density of a share of 1."""

    claims: list[Claim]
    shares: list[float]
    noise: float
    scale: float


def datum_of(claims: list[Claim], clutter: float) -> Datum:
    """N_i / Z for each claim, f / Z for noise, Z = ΣN + f; where all are 0 nothing can cause the appearance."""
    return Datum(claims, *shares_of([claim.density for claim in claims], clutter))


def scope_of(claims: Sequence[Claim]) -> Scope:
    """The variables that have a say."""
    return tuple(sorted({c.variable for c in claims} | {v for c in claims for v, _ in c.hiders}))


def add_datum(tables: Tables, datum: Datum, scope: Scope, cards: tuple[int, ...]) -> None:
    """Σ_i N_i h_i Π_{j≠i}(1−h_j) + f Π_j(1−h_j) over present, expected claimants, in every relevant joint state."""
    size = math.prod(cards)
    if size > LONGEST_LIST:
        tables.add(scope, _large(tables, datum, scope))
        return
    by_variable = _unhidden(datum, scope, cards)
    tables.add_list(
        scope,
        _row_by_row(datum, _steps(scope, cards, size), size) if by_variable is None else _joined(datum, by_variable),
    )


def add_miss(tables: Tables, claim: Claim) -> None:
    """1 − h_F where the feature, which something hides, is expected; no appearance was found for it."""
    scope = scope_of([claim])
    cards = tables.shape(scope)
    logs, missed = [0.0] * math.prod(cards), log(1.0 - claim.hit)
    for row in _rows(claim, _steps(scope, cards, len(logs))):
        logs[row] = missed
    tables.add_list(scope, logs)


def _unhidden(datum: Datum, scope: Scope, cards: tuple[int, ...]) -> list[list[Pair]] | None:
    """One pair a state of each variable of the scope, whose states exclude each other.

    None where something hides a claim.
    """
    found = {v: [NOBODY] * card for v, card in zip(scope, cards, strict=True)}
    for (variable, state, hit, _, hiders, _), share in zip(datum.claims, datum.shares, strict=True):
        if hiders:
            return None
        found[variable][state] = (1.0 - hit, share * hit)
    return list(found.values())


def _joined(datum: Datum, lists: list[list[Pair]]) -> list[float]:
    """The logs of every row: exactly one cause is before or here, so one before and none here, or the reverse."""
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


def _row_by_row(datum: Datum, steps: Shape, size: int) -> list[float]:
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
            bare = [step for s, step in enumerate(steps) if s not in hidden[v]]
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
        return np.asarray(np.log((datum.noise * none + one) * datum.scale))


def add_posterior(tables: Tables, cast: Cast, explicit: Collection[str] = ()) -> dict[str, Choice]:
    """All of it.

    Appearances in ``explicit`` (and those with too many claimants) get a variable of their cause, returned by
    appearance.
    """
    _add_priors(tables, cast)
    _add_pixels(tables, cast)
    claimed = _add_features(tables, cast)
    clutter = {a.id: a.clutter for a in cast.situation.appearances}
    causes: dict[str, Choice] = {}
    for name, claims in claimed.items():
        datum = datum_of(claims, clutter[name])
        scope = scope_of(claims)
        cards = tables.shape(scope)
        if name in explicit or (len(claims) > 1 and too_wide(cards)):
            causes[name] = Choice(_add_cause(tables, datum), (("noise",), *(claim.name for claim in claims)))
        else:
            add_datum(tables, datum, scope, cards)
    return causes


def _add_priors(tables: Tables, cast: Cast) -> None:
    """Rivals for one instance share the prior of their types evenly; the rest of it says that there is none."""
    each = {h.id: cast.situation.priors.get(h.type, DEFAULT_PRIOR) for h in cast.situation.hypotheses}
    for v, (_, *members) in enumerate(variable.states for variable in cast.variables):
        shares = [bounded(each[name or ""] / len(members)) for name in members]
        tables.unary[v] = logs_of([1.0 - sum(shares), *shares])


def _add_pixels(tables: Tables, cast: Cast) -> None:
    """e^L of each hypothesis whose pixels were asked, where it is present, by who is present before it (§9.10)."""
    for h in cast.situation.hypotheses:
        if h.pixel_table is not None:
            names = h.id, *h.pixel_table.occluders
            literals = [(cast.place[name][0], (cast.place[name][1],)) for name in names]
            tables.add_bits(literals, [odds for told in h.pixel_table.odds for odds in (0.0, told)])


def _add_features(tables: Tables, cast: Cast) -> dict[str, list[Claim]]:
    """Weigh the candidate features that no appearance was found for by 1 − h_F where they are expected.

    Hand back the others by appearance.
    """
    claimed: dict[str, list[Claim]] = {}
    opaque = cast.opaque
    for h in cast.situation.hypotheses:
        name, unhiding, solid = h.id, cast.unhiding[h.id], h.opaque
        v, s = cast.place[name]
        weight = tables.unary[v][s]
        for f in h.features:
            if not expected(f, solid):
                continue
            names = [g for g in f.hidden_by if g in opaque and g not in unhiding] if f.hidden_by else None
            hiders = _hiders(tables, cast, v, names) if names else ()
            match, hit = f.match, f.hit_rate
            if not LEAST <= hit <= 1.0 - LEAST:
                hit = bounded(hit)
            if match is not None:
                claimed.setdefault(match, []).append(Claim(v, s, hit, f.density, hiders, (name, f.id)))
            elif hiders:
                add_miss(tables, Claim(v, s, hit, 0.0, hiders, (name, f.id)))
            else:
                weight += log(1.0 - hit)
        tables.unary[v][s] = weight
    return claimed


def _hiders(tables: Tables, cast: Cast, mine: int, names: list[str]) -> tuple[Literal, ...]:
    """The names as literals, without the rivals that cannot be present with a state of ``mine``.

    One auxiliary literal for very many.
    """
    if len(names) == 1:
        v, s = cast.place[names[0]]
        return ((v, (s,)),) if v != mine else ()
    literals = [literal for literal in cast.literals(dict.fromkeys(names)) if literal[0] != mine]
    if len(literals) > 1 and too_wide(tables.shape([mine, *(v for v, _ in literals)])):
        return ((tables.indicator(literals), (1,)),)
    return tuple(literals)


def _live(tables: Tables, scope: tuple[int, ...], claim: Claim) -> Mask:
    """Where the claim's hypothesis is present and its feature expected, over the scope (other axes: length 1)."""
    hiders = dict(claim.hiders)
    live = np.ones((1,) * len(scope), dtype=bool)
    for axis, v in enumerate(scope):
        if v == claim.variable:
            holds = [s == claim.state for s in range(tables.cards[v])]
        elif v in hiders:
            holds = [s not in hiders[v] for s in range(tables.cards[v])]
        else:
            continue
        live = live & np.array(holds).reshape([-1 if a == axis else 1 for a in range(len(scope))])
    return live


def _add_cause(tables: Tables, datum: Datum) -> int:
    """The cause as a variable of its own: a star of factors, each of one claim, instead of one over all of them.

    Its number.
    """
    cause = tables.variable(logs_of([datum.noise * datum.scale, *(share * datum.scale for share in datum.shares)]))
    for i, claim in enumerate(datum.claims, 1):
        scope = (*scope_of([claim]), cause)
        live, chosen = _live(tables, scope, claim), np.arange(tables.cards[cause]) == i
        missed, caused = np.where(live, log(1.0 - claim.hit), 0.0), np.where(live, log(claim.hit), IMPOSSIBLE)
        tables.add(scope, np.where(chosen, caused, missed))
    return cause
