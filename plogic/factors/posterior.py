"""The factors of the posterior reading, causes and hits summed out analytically (§8): priors, what is missing in Γ, and Γ."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.bounds import alternative, bounded
from plogic.factors.tables import IMPOSSIBLE, log
from plogic.likelihood import DEFAULT_PRIOR

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from numpy.typing import NDArray

    from plogic.factors.alternatives import Cast, Literal
    from plogic.factors.tables import Tables
    from plogic.situation import FeatureFact, HypothesisFact

LONGEST_LIST = 64
"""Joint states up to which plain lists are quicker than arrays."""


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


class Cause(NamedTuple):
    """The variable of an appearance's cause, and what its states say: ``(("noise",), ("h1", "roof/apex"), ...)``, in the order of Δh."""

    variable: int
    states: tuple[tuple[str, ...], ...]


def add_posterior(tables: Tables, cast: Cast, explicit: Collection[str] = ()) -> dict[str, Cause]:
    """All of it; appearances in ``explicit`` (and those with too many claimants) get a variable of their cause, returned by appearance."""
    _add_priors(tables, cast)
    claimed = _add_features(tables, cast)
    clutter = {a.id: a.clutter for a in cast.situation.appearances}
    causes: dict[str, Cause] = {}
    for name, claims in claimed.items():
        datum = _datum(claims, clutter[name])
        if name in explicit or (len(claims) > 1 and tables.too_wide(_scope(claims))):
            causes[name] = Cause(_add_cause(tables, datum), (("noise",), *(claim.name for claim in claims)))
        else:
            _add_datum(tables, datum)
    return causes


def _add_priors(tables: Tables, cast: Cast) -> None:
    """Rivals for one instance share the prior of their types evenly; the rest of it says that there is none."""
    kinds = {h.id: h.type for h in cast.situation.hypotheses}
    priors = cast.situation.priors
    for v, variable in enumerate(cast.variables):
        members = variable.states[1:]
        shares = [bounded(priors.get(kinds[name or ""], DEFAULT_PRIOR) / len(members)) for name in members]
        tables.unary[v] = [log(1.0 - sum(shares)), *(log(p) for p in shares)]


def _add_features(tables: Tables, cast: Cast) -> dict[str, list[Claim]]:
    """Weigh the candidate features that no appearance was found for by 1 − h_F where they are expected; hand back the others by appearance."""
    claimed: dict[str, list[Claim]] = {}
    for h in cast.situation.hypotheses:
        v, s = cast.place[h.id]
        unary = tables.unary[v]
        for f in h.features:
            if not f.in_image or not f.in_lobe or (f.self_hidden and h.opaque):
                continue
            hiders = _hiders(tables, cast, h, f) if f.hidden_by else ()
            if f.match is not None:
                claim = Claim(v, s, bounded(f.hit_rate), f.density, hiders, (h.id, f.id))
                claimed.setdefault(f.match, []).append(claim)
            elif hiders:
                claim = Claim(v, s, bounded(f.hit_rate), 0.0, hiders, (h.id, f.id))
                _add_miss(tables, claim)
            else:
                unary[s] += log(1.0 - bounded(f.hit_rate))
    return claimed


def _hiders(tables: Tables, cast: Cast, h: HypothesisFact, f: FeatureFact) -> tuple[Literal, ...]:
    """What hides the feature, without the rivals that cannot be present with ``h``; one auxiliary literal where they are very many."""
    mine = cast.place[h.id][0]
    names = cast.hiders(h, f)
    if not names:
        return ()
    literals = [literal for literal in cast.literals(names) if literal[0] != mine]
    if len(literals) > 1 and tables.too_wide([mine, *(v for v, _ in literals)]):
        return ((tables.indicator(literals), (1,)),)
    return tuple(literals)


def _add_miss(tables: Tables, claim: Claim) -> None:
    scope = _scope([claim])
    cards = tables.shape(scope)
    logs = np.zeros(math.prod(cards))
    logs[_rows(claim, scope, cards)] = log(1.0 - claim.hit)
    tables.add(scope, logs.reshape(cards))


def _datum(claims: list[Claim], clutter: float) -> Datum:
    """N_i / Z for each claim, f / Z for noise, Z = ΣN + f; where all are 0 nothing can cause the appearance."""
    densities = [claim.density for claim in claims]
    shares = alternative([*densities, clutter])
    if not shares:
        return Datum(claims, [0.0] * len(claims), 0.0, 1.0)
    return Datum(claims, shares[:-1], shares[-1], sum(densities) + clutter)


def _scope(claims: Sequence[Claim]) -> tuple[int, ...]:
    scope = {claim.variable for claim in claims}
    for claim in claims:
        for v, _ in claim.hiders:
            scope.add(v)
    return tuple(sorted(scope))


def _add_datum(tables: Tables, datum: Datum) -> None:
    """Σ_i N_i h_i Π_{j≠i}(1−h_j) + f Π_j(1−h_j) over the present, expected claimants, in every joint state of those who have a say."""
    scope = _scope(datum.claims)
    cards = tables.shape(scope)
    if math.prod(cards) > LONGEST_LIST:
        _add_large(tables, datum, scope)
        return
    logs = _weighed(datum, scope, cards)
    if len(scope) == 1:
        tables.unary[scope[0]] = [x + y for x, y in zip(tables.unary[scope[0]], logs, strict=True)]
    else:
        tables.add(scope, np.array(logs).reshape(cards))


def _weighed(datum: Datum, scope: tuple[int, ...], cards: tuple[int, ...]) -> list[float]:
    """Log weights in C order: claim by claim, (weight of no cause among those before, weight of exactly one)."""
    size = math.prod(cards)
    none, one = [1.0] * size, [0.0] * size
    for claim, share in zip(datum.claims, datum.shares, strict=True):
        hit, miss = share * claim.hit, 1.0 - claim.hit
        for r in _rows(claim, scope, cards):
            one[r] = one[r] * miss + none[r] * hit
            none[r] *= miss
    noise, scale = datum.noise, datum.scale
    return [log((noise * x + y) * scale) for x, y in zip(none, one, strict=True)]


def _rows(claim: Claim, scope: tuple[int, ...], cards: tuple[int, ...]) -> list[int]:
    """The joint states (row numbers in C order) in which the claim's hypothesis is present and its feature expected."""
    rows = [0]
    hiders = dict(claim.hiders)
    for v, card in zip(scope, cards, strict=True):
        if v == claim.variable:
            rows = [r * card + claim.state for r in rows]
        else:
            hidden = hiders.get(v, ())
            rows = [r * card + s for r in rows for s in range(card) if s not in hidden]
    return rows


def _add_large(tables: Tables, datum: Datum, scope: tuple[int, ...]) -> None:
    """As ``_weighed``, with arrays, variable by variable: of the claims at one variable at most one is present."""
    none, one = np.ones(()), np.zeros(())
    for v in sorted({claim.variable for claim in datum.claims}):
        mine = [(claim, share) for claim, share in zip(datum.claims, datum.shares, strict=True) if claim.variable == v]
        local = _scope([claim for claim, _ in mine])
        cards = tables.shape(local)
        free, hit = np.ones(math.prod(cards)), np.zeros(math.prod(cards))
        for claim, share in mine:
            rows = _rows(claim, local, cards)
            free[rows], hit[rows] = 1.0 - claim.hit, share * claim.hit
        shape = [tables.cards[u] if u in local else 1 for u in scope]
        free, hit = free.reshape(shape), hit.reshape(shape)
        none, one = none * free, one * free + none * hit
    with np.errstate(divide="ignore"):
        tables.add(scope, np.log((datum.noise * none + one) * datum.scale))


def _live(tables: Tables, scope: tuple[int, ...], claim: Claim) -> NDArray[np.bool_]:
    """Where the claim's hypothesis is present and its feature expected, over the scope (its other axes have length 1)."""
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
    """The cause as a variable of its own: a star of factors, each of one claim, instead of one over all of them; its number."""
    cause = tables.variable([log(datum.noise * datum.scale), *(log(share * datum.scale) for share in datum.shares)])
    for i, claim in enumerate(datum.claims, 1):
        scope = (*_scope([claim]), cause)
        live = _live(tables, scope, claim)
        chosen = np.arange(tables.cards[cause]) == i
        missed = np.where(live, log(1.0 - claim.hit), 0.0)
        caused = np.where(live, log(claim.hit), IMPOSSIBLE)
        tables.add(scope, np.where(chosen, caused, missed))
    return cause
