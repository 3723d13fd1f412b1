"""The factors of the score reading: P(present(H) | its occluders) = P(ev), picks summed out analytically; cyclic blocks jointly (§8)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.acceptance import acceptance, lifted_smoothing
from plogic.bounds import LEAST, alternative
from plogic.dependence import Scene, dependence
from plogic.factors.pick import add_pick
from plogic.factors.tables import IMPOSSIBLE, WIDEST, log

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.dependence import Dependence
    from plogic.factors.alternatives import Cast
    from plogic.factors.tables import Tables
    from plogic.situation import HypothesisFact

    Chances = NDArray[np.float64]


class Seen(NamedTuple):
    """What decides a score: the scene, its graph of dependence, ε as programs carry it."""

    scene: Scene
    graph: Dependence
    epsilon: float


def add_score(tables: Tables, cast: Cast) -> None:
    """One factor a hypothesis, or a cyclic block; raises TooManyHypothesesError for a cycle that is too large."""
    scene = Scene(cast.situation)
    seen = Seen(scene, dependence(scene), lifted_smoothing(scene))
    for block in seen.graph.blocks:
        if len(block) > 1:
            _add_block(tables, cast, seen, block)
        else:
            _add_one(tables, cast, seen, scene.by_id[block[0]])


def _add_one(tables: Tables, cast: Cast, seen: Seen, h: HypothesisFact) -> None:
    names = seen.graph.of[h.id]
    linear = cast.situation.reconsider == "to_B"
    if len(names) > WIDEST and cast.situation.reconsider != "drop":
        add_pick(tables, cast, seen.scene, h, seen.epsilon)
        return
    p = linear_chances(cast, h, names, seen.epsilon) if linear else chances(seen, h, names)
    if len(p) == 1:
        v, s = cast.place[h.id]
        absent, present = log(1.0 - float(p[0])), log(float(p[0]))
        tables.unary[v] = [x + (present if i == s else absent) for i, x in enumerate(tables.unary[v])]
        return
    with np.errstate(divide="ignore"):
        logs = np.log(np.stack([1.0 - p, p], axis=1)).ravel()
    tables.add_bits(_literals(cast, (h.id, *names)), logs)


def _literals(cast: Cast, names: tuple[str, ...]) -> list[tuple[int, tuple[int, ...]]]:
    return [(v, (s,)) for v, s in (cast.place[name] for name in names)]


def chances(seen: Seen, h: HypothesisFact, names: tuple[str, ...]) -> Chances:
    """P(present(h) | which of ``names`` are present), a bit table (2^n,)."""
    rows = np.arange(2 ** len(names))
    nobody = np.zeros(len(rows), np.bool_)
    present = dict.fromkeys(seen.scene.by_id, nobody) | {name: (rows >> i & 1).astype(np.bool_) for i, name in enumerate(names)}
    return acceptance(seen.scene, h, present, names)


def linear_chances(cast: Cast, h: HypothesisFact, names: tuple[str, ...], epsilon: float) -> Chances:
    """As ``chances`` in mode `to_B`, which is linear in the features."""
    seen = [f for f in h.features if f.in_image]
    shares = alternative([f.dv for f in seen])
    if not shares or all(f.match is None for f in seen):
        return np.zeros(1)
    bit = {name: 1 << i for i, name in enumerate(names)}
    fixed, changing = 0.0, np.zeros(2 ** len(names))
    for f, share in zip(seen, shares, strict=True):
        found, candidate = f.match is not None, h.candidate(f)
        mask = sum(bit[g] for g in cast.hiders(h, f)) if candidate and f.hidden_by else 0
        if mask:
            hidden = (np.arange(len(changing)) & mask) > 0
            changing += share * (hidden != found)
        elif candidate == found:
            fixed += share
    total = changing + fixed
    total = np.where(total > 1.0 - 1e-12, 1.0, np.where(total < 1e-12, 0.0, total))  # the certain stays certain
    return epsilon + (1.0 - 2.0 * epsilon) * total


def _add_block(tables: Tables, cast: Cast, seen: Seen, block: tuple[str, ...]) -> None:
    """One alternative over the joint states S: Π_{h∈S} p_h(S) · Π_{h∉S} (1 − p_h(S)), normalised for each context of outside occluders."""
    outside = seen.graph.outside(block)
    rows = np.arange(2 ** (len(block) + len(outside)))
    present = {name: (rows >> i & 1).astype(np.bool_) for i, name in enumerate((*block, *outside))}
    nobody = np.zeros(len(rows), np.bool_)
    everyone = dict.fromkeys(seen.scene.by_id, nobody) | present
    weight = np.ones(len(rows))
    for name in block:
        p = acceptance(seen.scene, seen.scene.by_id[name], everyone, seen.graph.of[name])
        weight *= np.where(present[name], p, 1.0 - p)
    shares = normalised(weight.reshape(-1, 2 ** len(block))).ravel()
    logs = np.full(len(shares), IMPOSSIBLE)
    logs[shares > 0] = np.log(shares[shares > 0])
    tables.add_bits(_literals(cast, (*block, *outside)), logs)


def normalised(weight: Chances) -> Chances:
    """(contexts, 2^k): rows that sum to 1, nothing possible below LEAST; where no state is stable, the empty one takes it all."""
    weight = weight.copy()
    weight[weight.sum(axis=1) <= 0, 0] = 1.0
    share = weight / weight.sum(axis=1, keepdims=True)
    lifted = np.where(share > 0, np.maximum(share, LEAST), 0.0)
    result: Chances = lifted / lifted.sum(axis=1, keepdims=True)
    return result
