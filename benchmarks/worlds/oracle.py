"""Marginals from the definition, for the benchmark to be held to: nothing of this comes from the engine that it judges.

Vocabulary: a *term* is one factor of a world's weight, ``(("h1", "h4"), table)``: the hypotheses that it looks at, and
plain weights of shape ``(2, 2)``, 1 for present. Of the score reading only mode `to_B` without cyclic occlusion and
smoothing, which the families keep to.
"""

from __future__ import annotations

from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.bounds import alternative, bounded
from plogic.base.errors import SituationError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from plogic.facts.hypothesis import FeatureFact, Hypothesis
    from plogic.facts.situation import Situation

    Table = NDArray[np.float64]
    Term = tuple[tuple[str, ...], Table]
    Claim = tuple[Hypothesis, FeatureFact]

MOST = 14
"""Hypotheses up to which every world is enumerated."""
ROUNDING = 1e-12
"""A sum of shares that is this near to 0 or 1 is 0 or 1."""


def enumerated(situation: Situation) -> Table:
    """P(world) of all 2^K worlds, one axis of length 2 a hypothesis, in the order of Δh."""
    names = [h.id for h in situation.hypotheses]
    if len(names) > MOST:
        raise SituationError(f"{len(names)} hypotheses: worlds are enumerated for at most {MOST}")
    weight = np.ones((2,) * len(names))
    for scope, table in terms(situation):
        weight = weight * _spread(scope, table, names)
    return np.asarray(weight / weight.sum())


def marginals_of(situation: Situation, chances: Table) -> dict[str, float]:
    """P(present(H)) of every hypothesis, from ``enumerated``."""
    return {h.id: float(chances.take(1, axis=i).sum()) for i, h in enumerate(situation.hypotheses)}


def by_frontier(situation: Situation, columns: int, asked: tuple[str, ...]) -> dict[str, float]:
    """P(present(H)) of those asked for, of a grid filled row by row.

    Cell after cell, the states of the last ``columns`` cells are kept.
    """
    found = list(terms(situation))
    whole, whole_log = _swept(situation, columns, found)
    result = {}
    for name in asked:
        part, part_log = _swept(situation, columns, [*found, ((name,), np.array([0.0, 1.0]))])
        result[name] = float(part / whole * np.exp(part_log - whole_log))
    return result


def _swept(situation: Situation, columns: int, found: list[Term]) -> tuple[float, float]:
    """The sum of all weights as (x, y), x·e^y."""
    names = [h.id for h in situation.hypotheses]
    place = {name: i for i, name in enumerate(names)}
    last: dict[str, list[Term]] = {name: [] for name in names}
    for term in found:
        last[max(term[0], key=place.__getitem__)].append(term)
    kept, log = np.zeros((2,) * columns), 0.0
    kept[(0,) * columns] = 1.0
    for i, name in enumerate(names):
        column = i % columns
        seen = [names[i - 1] if column else "", names[i - columns] if i >= columns else "", name]
        table = reduce(np.multiply, (_spread(scope, t, seen) for scope, t in last[name]), np.ones((2, 2, 2)))
        shape = (2 ** max(0, column - 1), 2 if column else 1, 2, 2 ** (columns - 1 - column))
        kept = np.einsum("alur,lux->alxr", kept.reshape(shape), table[: shape[1]])
        top = kept.max()
        kept, log = kept / top, log + float(np.log(top))
    return float(kept.sum()), log


def _spread(scope: tuple[str, ...], table: Table, names: list[str]) -> Table:
    """The table with one axis a name, of length 1 where it does not look."""
    axes = [names.index(name) for name in scope]
    ordered = table.transpose(np.argsort(axes))
    return ordered.reshape([2 if i in axes else 1 for i in range(len(names))])


def terms(situation: Situation) -> Iterator[Term]:
    """Every factor of the weight of a world (§8)."""
    yield from _score(situation) if situation.reading == "score" else _posterior(situation)
    both = np.array([[1.0, 1.0], [1.0, 0.0]])
    pairs = situation.overlaps | (situation.exclusive if situation.reading == "score" else frozenset())
    yield from ((pair, both) for pair in sorted(pairs))
    if situation.gravity is not None or situation.support is not None:
        raise SituationError(
            "gravity, support: the families say nothing of them, and this oracle knows nothing of them"
        )


def _posterior(situation: Situation) -> Iterator[Term]:
    """One alternative an instance; 1 − h for what is missed; one cause for what is claimed."""
    groups: dict[str, list[Hypothesis]] = {}
    claims: dict[str, list[Claim]] = {}
    for h in situation.hypotheses:
        groups.setdefault(h.group, []).append(h)
        for f in (f for f in h.features if h.expects(f)):
            if f.match is None:
                yield _missed(situation, h, f)
            else:
                claims.setdefault(f.match, []).append((h, f))
    yield from (_instance(situation, members) for members in groups.values())
    clutter = {a.id: a.clutter for a in situation.appearances}
    yield from (_cause(situation, claimants, clutter[a]) for a, claimants in claims.items())


def _instance(situation: Situation, members: list[Hypothesis]) -> Term:
    table = np.zeros((2,) * len(members))
    shares = [bounded(situation.priors.get(h.type, 0.5) / len(members)) for h in members]
    table[(0,) * len(members)] = max(0.0, 1.0 - sum(shares))
    for i, share in enumerate(shares):
        table[tuple(int(i == j) for j in range(len(members)))] = share
    return tuple(h.id for h in members), table


def _missed(situation: Situation, h: Hypothesis, f: FeatureFact) -> Term:
    scope = _looked_at(situation, [(h, f)])
    return scope, 1.0 - bounded(f.hit_rate) * _expected(situation, h, f, scope)


def _cause(situation: Situation, claimants: list[Claim], clutter: float) -> Term:
    """Exactly one cause: Σ_i N_i h_i Π_{j≠i}(1−h_j) + f Π_j(1−h_j), densities over their sum."""
    scope = _looked_at(situation, claimants)
    shares = alternative([*(f.density for _, f in claimants), clutter])
    hits = [bounded(f.hit_rate) * _expected(situation, h, f, scope) for h, f in claimants]
    total = shares[-1] * reduce(np.multiply, [1.0 - hit for hit in hits])
    for i, share in enumerate(shares[:-1]):
        total = total + reduce(np.multiply, [1.0 - hit for j, hit in enumerate(hits) if j != i], share * hits[i])
    return scope, total


def _score(situation: Situation) -> Iterator[Term]:
    """P(ev) of what is present, 1 − P(ev) of what is not, given who stands before it."""
    for h in situation.hypotheses:
        seen = [f for f in h.features if f.in_image]
        scope = _looked_at(situation, [(h, f) for f in seen])
        shares = alternative([f.dv for f in seen])
        p = np.zeros((2,) * len(scope))
        for f, share in zip(seen, shares, strict=True):
            p += share * (_expected(situation, h, f, scope, alone=True) == float(f.match is not None))
        p = np.where(p > 1.0 - ROUNDING, 1.0, np.where(p < ROUNDING, 0.0, p)) * any(f.match is not None for f in seen)
        yield scope, np.where(_axis(scope, h.id) == 1.0, p, 1.0 - p)


def _looked_at(situation: Situation, claims: list[Claim]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for h, f in claims for name in (h.id, *_hiders(situation, h, f))))


def _hiders(situation: Situation, h: Hypothesis, f: FeatureFact) -> list[str]:
    """The opaque hypotheses, no rivals, that lie before the feature (D4, D7)."""
    if not h.expects(f):
        return []
    opaque = {g.id for g in situation.hypotheses if g.opaque}
    rivals = situation.rivals
    return [g for g in f.hidden_by if g in opaque and g != h.id and (g, h.id) not in rivals and (h.id, g) not in rivals]


def _expected(
    situation: Situation, h: Hypothesis, f: FeatureFact, scope: tuple[str, ...], *, alone: bool = False
) -> Table:
    """1.0 in the worlds of the scope where the feature is expected (D7); ``alone`` takes its host as present."""
    result = np.full((2,) * len(scope), float(h.expects(f)))
    if not alone:
        result = result * _axis(scope, h.id)
    for g in _hiders(situation, h, f):
        result = result * (1.0 - _axis(scope, g))
    return result


def _axis(scope: tuple[str, ...], name: str) -> Table:
    """1.0 where ``name`` is present, over the scope."""
    return np.array([0.0, 1.0]).reshape([2 if other == name else 1 for other in scope])
