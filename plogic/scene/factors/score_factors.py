"""The factors of the score reading: P(present(H) | its occluders) = P(ev), picks summed out analytically; cyclic blocks jointly (§8)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.base.bounds import LEAST
from plogic.facts.dependence import Scene, arranged, dependence
from plogic.scene.factors.linear import linear
from plogic.scene.factors.pick import add_pick
from plogic.scene.factors.weight_tables import IMPOSSIBLE, WIDEST, log, logs_of
from plogic.scene.readings.score_reading import acceptance, lifted_smoothing

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.facts.dependence import Dependence
    from plogic.facts.hypothesis import Hypothesis
    from plogic.scene.factors.alternatives import Cast
    from plogic.scene.factors.linear import Linear
    from plogic.scene.factors.weight_tables import Tables

    Chances = NDArray[np.float64]


class Seen(NamedTuple):
    """What decides a score: the scene, its graph of dependence, ε as programs carry it, and in mode `to_B` the features summed up."""

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
        logs: Chances = np.log(np.stack([1.0 - p, p], axis=1)).ravel()
    return logs


def _literals(cast: Cast, names: tuple[str, ...]) -> list[tuple[int, tuple[int, ...]]]:
    place = cast.place
    return [(place[name][0], place[name][1:]) for name in names]


def chances(seen: Seen, h: Hypothesis, names: tuple[str, ...]) -> Chances:
    """P(present(h) | which of ``names`` are present), a bit table (2^n,)."""
    rows = np.arange(2 ** len(names))
    nobody = np.zeros(len(rows), np.bool_)
    present = dict.fromkeys(seen.scene.by_id, nobody) | {
        name: (rows >> i & 1).astype(np.bool_) for i, name in enumerate(names)
    }
    return acceptance(seen.scene, h, present, names)


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
