"""The factors of the posterior reading, causes and hits summed out analytically (§8): priors, what is missing in Γ, and Γ."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.base.bounds import LEAST, bounded
from plogic.facts.expected import expected
from plogic.scene.factors.claims import Claim, add_datum, add_miss, datum_of, scope_of
from plogic.scene.factors.weight_tables import IMPOSSIBLE, log, logs_of, too_wide
from plogic.scene.readings.posterior_reading import DEFAULT_PRIOR

if TYPE_CHECKING:
    from collections.abc import Collection

    from numpy.typing import NDArray

    from plogic.scene.factors.alternatives import Cast, Literal
    from plogic.scene.factors.claims import Datum
    from plogic.scene.factors.weight_tables import Tables


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
        datum = datum_of(claims, clutter[name])
        scope = scope_of(claims)
        cards = tables.shape(scope)
        if name in explicit or (len(claims) > 1 and too_wide(cards)):
            causes[name] = Cause(_add_cause(tables, datum), (("noise",), *(claim.name for claim in claims)))
        else:
            add_datum(tables, datum, scope, cards)
    return causes


def _add_priors(tables: Tables, cast: Cast) -> None:
    """Rivals for one instance share the prior of their types evenly; the rest of it says that there is none."""
    situation = cast.situation
    each = {h.id: situation.priors.get(h.type, DEFAULT_PRIOR) for h in situation.hypotheses}
    for v, variable in enumerate(cast.variables):
        members = variable.states[1:]
        shares = [bounded(each[name or ""] / len(members)) for name in members]
        tables.unary[v] = logs_of([1.0 - sum(shares), *shares])


def _add_features(tables: Tables, cast: Cast) -> dict[str, list[Claim]]:
    """Weigh the candidate features that no appearance was found for by 1 − h_F where they are expected; hand back the others by appearance."""
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
                claim = Claim(v, s, hit, f.density, hiders, (name, f.id))
                if match in claimed:
                    claimed[match].append(claim)
                else:
                    claimed[match] = [claim]
            elif hiders:
                add_miss(tables, Claim(v, s, hit, 0.0, hiders, (name, f.id)))
            else:
                weight += log(1.0 - hit)
        tables.unary[v][s] = weight
    return claimed


def _hiders(tables: Tables, cast: Cast, mine: int, names: list[str]) -> tuple[Literal, ...]:
    """The names as literals, without the rivals that cannot be present with a state of ``mine``; one auxiliary literal for very many."""
    if len(names) == 1:
        v, s = cast.place[names[0]]
        return ((v, (s,)),) if v != mine else ()
    literals = [literal for literal in cast.literals(dict.fromkeys(names)) if literal[0] != mine]
    if len(literals) > 1 and too_wide(tables.shape([mine, *(v for v, _ in literals)])):
        return ((tables.indicator(literals), (1,)),)
    return tuple(literals)


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
    cause = tables.variable(logs_of([datum.noise * datum.scale, *(share * datum.scale for share in datum.shares)]))
    for i, claim in enumerate(datum.claims, 1):
        scope = (*scope_of([claim]), cause)
        live = _live(tables, scope, claim)
        chosen = np.arange(tables.cards[cause]) == i
        missed = np.where(live, log(1.0 - claim.hit), 0.0)
        caused = np.where(live, log(claim.hit), IMPOSSIBLE)
        tables.add(scope, np.where(chosen, caused, missed))
    return cause
