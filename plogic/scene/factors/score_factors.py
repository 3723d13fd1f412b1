"""The factors of the score reading: P(present(H) | its occluders) = P(ev), picks summed out analytically.

Cyclic blocks jointly (§8).

In mode `to_B` P(ev) is linear in the features: one look at each, then a sum for every set of others that are present.
This is the second form of ``plogic.scene.readings.world_weights.acceptance`` in this mode, tested equal to it.

* ``Linear(["h2", "h5"], 0.7, [(1, 0.1, True), (3, 0.2, False)])``: of the shares of dv, 0.7 is concordant whoever is
  present; 0.1 where h2 (bit 0 of 1) is absent, since an appearance was found for it; and 0.2 where h2 or h5 is present,
  since none was

Where very many others bear on a hypothesis, so that one factor over all is too wide, its pick is a variable of its own:
present(h) holds iff h is supported and the feature that it picks is concordant, a boolean formula over the pick and
over who is present, which the graph takes as gates.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Mask
from plogic.base.bounds import LEAST, alternative
from plogic.facts.dependence import Dependence, Scene, arranged, dependence, ordered
from plogic.facts.hypothesis import FeatureFact, Hypothesis, expected
from plogic.inference.gates import And, Formula, Literal, Not, Or
from plogic.scene.factors.weight_tables import IMPOSSIBLE, LONGEST_LIST, WIDEST, Cast, Tables, log, logs_of
from plogic.scene.readings.world_weights import acceptance, lifted_smoothing, snapped

Cell = tuple[int, float, bool]
Chances = NDArray[np.float64]


class Linear(NamedTuple):
    """``names``: who changes a cell, most cells first; ``fixed``: None where nothing is detected or ev is undefined.

    ``cells`` that change.
    """

    names: list[str]
    fixed: float | None
    cells: list[Cell]

    def chances(self, epsilon: float) -> list[float] | Floats:
        """P(present(h) | which of ``names`` are present), a bit table (2^n,); of length 1 where it is impossible."""
        if self.fixed is None:
            return [0.0]
        size = 1 << len(self.names)
        if size > LONGEST_LIST:
            return _array(size, self.fixed, self.cells, epsilon)
        changing = [0.0] * size
        for mask, share, found in self.cells:
            changing = [x if (row & mask != 0) is found else x + share for row, x in enumerate(changing)]
        fixed, spread = self.fixed, 1.0 - 2.0 * epsilon
        return [epsilon + spread * _snapped(x + fixed) for x in changing]


def linear(cast: Cast, h: Hypothesis) -> Linear:
    """One look at the features of a hypothesis."""
    opaque, unhiding, solid = cast.opaque, cast.unhiding[h.id], h.opaque
    weights: list[float] = []
    same: list[int] = []
    changing: list[tuple[int, set[str], bool]] = []
    cells: dict[str, int] = {}
    detected = False
    for f in h.features:
        if not f.in_image:
            continue
        found, awaited = f.match is not None, expected(f, solid)
        detected = detected or found
        hiders = {g for g in f.hidden_by if g in opaque and g not in unhiding} if awaited and f.hidden_by else None
        if hiders:
            for g in hiders:
                cells[g] = cells.get(g, 0) + 1
            changing.append((len(weights), hiders, found))
        elif awaited == found:
            same.append(len(weights))
        weights.append(f.dv)
    names = ordered(cells)
    shares = alternative(weights) if detected else []
    if not shares:
        return Linear(names, None, [])
    bit = {name: 1 << i for i, name in enumerate(names)}
    fixed = sum([shares[i] for i in same], 0.0)
    return Linear(names, fixed, [(sum([bit[g] for g in hiders]), shares[i], found) for i, hiders, found in changing])


def _snapped(total: float) -> float:
    """A sum of shares that is 0 or 1 but for rounding is 0 or 1: the certain stays certain."""
    return 1.0 if total > 1.0 - 1e-12 else 0.0 if total < 1e-12 else total


def _array(size: int, fixed: float, cells: Sequence[Cell], epsilon: float) -> Floats:
    rows, changing = np.arange(size), np.zeros(size)
    for mask, share, found in cells:
        changing += share * (((rows & mask) > 0) != found)
    return epsilon + (1.0 - 2.0 * epsilon) * snapped(changing + fixed)


def add_pick(tables: Tables, cast: Cast, scene: Scene, h: Hypothesis, epsilon: float) -> None:
    """Modes `to_B` and `reassign`: state 0 and 1 of the pick are luck, good and bad (ε each).

    State i > 1 is the i-th feature in the image.
    """
    seen = [f for f in h.features if f.in_image]
    shares = alternative([f.dv for f in seen])
    if not shares:  # every dv is 0: ev is undefined, and the hypothesis is never present
        variable, state = cast.place[h.id]
        tables.unary[variable][state] = IMPOSSIBLE
        return
    pick = tables.variable([log(epsilon), log(epsilon), *(log((1 - 2 * epsilon) * share) for share in shares)])
    agrees = [_picked(pick, 0)]
    agrees += [And((_picked(pick, i), _concordant(cast, scene, h, f))) for i, f in enumerate(seen, 2)]
    accepted = And((Or(tuple(_is_found(cast, scene, h, f) for f in seen)), Or(tuple(agrees))))
    present = _is_present(cast, h.id)
    tables.required.append(Or((And((present, accepted)), And((Not(present), Not(accepted))))))


def _picked(pick: int, state: int) -> Formula:
    return Literal(pick, frozenset({state}))


def _is_present(cast: Cast, name: str) -> Formula:
    variable, state = cast.place[name]
    return Literal(variable, frozenset({state}))


def _in_view(cast: Cast, h: Hypothesis, f: FeatureFact) -> Formula:
    """D7, given that ``h`` is in the world."""
    if not h.expects(f):
        return Or(())
    return Not(Or(tuple(Literal(v, frozenset(states)) for v, states in cast.literals(cast.hiders(h, f)))))


def _robbed(cast: Cast, scene: Scene, h: Hypothesis, f: FeatureFact) -> Formula:
    """Mode `reassign`: another present object's expected feature claims the appearance (§5.5)."""
    robbers = scene.robbers(h, f) if cast.situation.reconsider == "reassign" else []
    return Or(tuple(And((_is_present(cast, g.id), _in_view(cast, g, e))) for g, e in robbers))


def _is_found(cast: Cast, scene: Scene, h: Hypothesis, f: FeatureFact) -> Formula:
    """D8."""
    return Or(()) if f.match is None else Or((_in_view(cast, h, f), Not(_robbed(cast, scene, h, f))))


def _concordant(cast: Cast, scene: Scene, h: Hypothesis, f: FeatureFact) -> Formula:
    """Expected ⇔ Detected: what is matched is in view or lost to another; what is not is out of view."""
    in_view = _in_view(cast, h, f)
    return Not(in_view) if f.match is None else Or((in_view, _robbed(cast, scene, h, f)))


class Seen(NamedTuple):
    """What decides a score: the scene, its graph of dependence, ε as in programs, and `to_B`'s summed features."""

    scene: Scene
    graph: Dependence
    epsilon: float
    sums: dict[str, Linear]


def add_score(tables: Tables, cast: Cast) -> None:
    """One factor a hypothesis, or a cyclic block; raises TooManyHypothesesError for a cycle that is too large."""
    seen = _seen(cast)
    for block in seen.graph.blocks:
        if len(block) > 1:
            _add_block(tables, cast, seen, block)
        else:
            _add_one(tables, cast, seen, block[0])


def _seen(cast: Cast) -> Seen:
    scene = Scene(cast.situation)
    if cast.situation.reconsider != "to_B":
        return Seen(scene, dependence(scene), lifted_smoothing(scene), {})
    sums = {h.id: linear(cast, h) for h in cast.situation.hypotheses}
    return Seen(scene, arranged({name: s.names for name, s in sums.items()}, "to_B"), lifted_smoothing(scene), sums)


def _add_one(tables: Tables, cast: Cast, seen: Seen, name: str) -> None:
    names = seen.graph.of[name]
    if len(names) > WIDEST and cast.situation.reconsider != "drop":
        add_pick(tables, cast, seen.scene, seen.scene.by_id[name], seen.epsilon)
        return
    p = seen.sums[name].chances(seen.epsilon) if seen.sums else chances(seen, seen.scene.by_id[name], names)
    if len(p) == 1:
        v, s = cast.place[name]
        absent, present = log(1.0 - float(p[0])), log(float(p[0]))
        tables.unary[v] = [x + (present if i == s else absent) for i, x in enumerate(tables.unary[v])]
    else:
        tables.add_bits(_literals(cast, (name, *names)), _logs(p))


def _logs(p: Sequence[float] | Chances) -> list[float] | Chances:
    """ln(1 − p), ln p, row by row: a bit table in which the hypothesis itself is the first bit."""
    if not isinstance(p, np.ndarray):
        return logs_of([q for x in p for q in (1.0 - x, x)])
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.stack([1.0 - p, p], axis=1)).ravel())


def _literals(cast: Cast, names: tuple[str, ...]) -> list[tuple[int, tuple[int, ...]]]:
    place = cast.place
    return [(place[name][0], place[name][1:]) for name in names]


def chances(seen: Seen, h: Hypothesis, names: tuple[str, ...]) -> Chances:
    """P(present(h) | which of ``names`` are present), a bit table (2^n,)."""
    return acceptance(seen.scene, h, _columns(seen, names), names)


def _columns(seen: Seen, names: tuple[str, ...]) -> dict[str, Mask]:
    """Who is present in all 2^n worlds of ``names``, row by row of a bit table; nobody else is."""
    rows = np.arange(2 ** len(names))
    present = {name: (rows >> i & 1).astype(np.bool_) for i, name in enumerate(names)}
    return dict.fromkeys(seen.scene.by_id, np.zeros(len(rows), np.bool_)) | present


def _add_block(tables: Tables, cast: Cast, seen: Seen, block: tuple[str, ...]) -> None:
    """One alternative over the joint states S that Σc allows.

    Π_{h∈S} p_h(S) · Π_{h∉S} (1 − p_h(S)), normalised for each context of outside occluders (§8).
    """
    names = (*block, *seen.graph.outside(block))
    present, weight, allowed = _columns(seen, names), np.ones(2 ** len(names)), np.ones(2 ** len(names), np.bool_)
    for name in block:
        p = acceptance(seen.scene, seen.scene.by_id[name], present, seen.graph.of[name])
        weight *= np.where(present[name], p, 1.0 - p)
    for x, y in combinations(block, 2):
        if (x, y) in seen.scene.apart:
            allowed &= ~(present[x] & present[y])
    shares = normalised(*(row.reshape(-1, 2 ** len(block)) for row in (weight, allowed))).ravel()
    logs = np.full(len(shares), IMPOSSIBLE)
    logs[shares > 0] = np.log(shares[shares > 0])
    tables.add_bits(_literals(cast, names), logs)


def normalised(weight: Chances, allowed: Mask) -> Chances:
    """(contexts, 2^k): rows that sum to 1 over the states that Σc allows, nothing possible below LEAST.

    Where no state is stable, the empty one takes it all; where only such are as Σc forbids, it is left to cut them.
    """
    lawful = weight * allowed
    weight = np.where(lawful.sum(axis=1, keepdims=True) > 0, lawful, weight)
    weight[weight.sum(axis=1) <= 0, 0] = 1.0
    share = weight / weight.sum(axis=1, keepdims=True)
    lifted = np.where(share > 0, np.maximum(share, LEAST), 0.0)
    return np.asarray(lifted / lifted.sum(axis=1, keepdims=True))
