"""The oracle: the weight of every subset of the hypotheses, both readings, by the definitions and nothing else.

2^k of them.
"""

from __future__ import annotations

import numpy as np

from plogic.base.bounds import LEAST
from plogic.facts.dependence import Scene, dependence
from plogic.scene.readings.world_weights import (
    acceptance,
    appearance_weight,
    group_shares,
    miss_weight,
    pixel_odds,
    unmatched,
)


def subsets(members):
    """Every subset of the members, as columns (2^k,); row ``i`` holds the members whose bit of ``i`` is set."""
    rows = np.arange(2 ** len(members))
    return {name: (rows >> bit & 1).astype(np.bool_) for bit, name in enumerate(members)}


def log_weights(situation):
    """Natural logarithm of the weight of every subset, (2^k,), −inf where a constraint is violated.

    It sums to the evidence.
    """
    scene = Scene(situation)
    present = subsets([h.id for h in situation.hypotheses])
    score = situation.reading == "score"
    with np.errstate(divide="ignore"):
        logs = _score(scene, present) if score else _posterior(scene, present)
    for x, y in situation.overlaps | (situation.exclusive if score else frozenset()):
        logs[present[x] & present[y]] = -np.inf
    return logs + _floating(situation.gravity, present) + (0.0 if score else _resting(situation, present))


def _floating(gravity, present):
    """Once the chance of an unknown support for each that floats.

    It is there, no holder is, and the ground is lower.
    """
    if gravity is None:
        return 0.0
    count = 0
    for name, low, _ in gravity.feet:
        holders = [y for x, y in gravity.rests if x == name]
        held = np.logical_or.reduce([present[y] for y in holders if y in present] or [np.False_])
        lower = np.logical_or.reduce([present[f.id] for f in gravity.feet if f.high < low] or [np.False_])
        grounded = np.bool_("ground" in holders) if gravity.ground is not None else ~lower
        count = count + (present[name] & ~held & ~grounded)
    return np.log(gravity.unknown_support) * count


def _resting(situation, present):
    """Of each state of the image its prior times, of each that is there, being free and its ways to stand (§9.9).

    Of each that is absent, the same with the chance that it stands so, but where one is there that excludes it.
    """
    support, taken = situation.support, {}
    if support is None:
        return 0.0
    for x, y in situation.overlaps | situation.exclusive:
        taken[x], taken[y] = taken.get(x, False) | present[y], taken.get(y, False) | present[x]
    prior, by_chance = {plane.name: plane.prior for plane in support.planes}, dict(support.by_chance)
    level = {(name, state): ratio for name, state, ratio in support.level}
    total = np.full(len(next(iter(present.values()))), support.none)
    for state, p in [*prior.items(), ("elsewhere", max(0.0, 1.0 - support.none - sum(prior.values())))]:
        weight = p
        for name, there in present.items():
            ways = [s for s in support.stances if s.hypothesis == name and (s.on == state or s.on in present)]
            stands = [s.chance * np.exp(s.log_ratio) * present.get(s.on, 1.0) for s in ways]
            chance = np.where(there, 1.0, np.where(taken.get(name, False), 0.0, by_chance.get(name, 0.0)))
            free = (1.0 - support.rests) * np.exp(level.get((name, state), 0.0))
            weight = weight * (1.0 - chance + chance * (free + sum(stands)))
        total = total + weight
    with np.errstate(divide="ignore"):
        return np.log(total)


def _score(scene, present):
    graph = dependence(scene)
    return sum(np.log(_block(scene, graph, block, present)) for block in graph.blocks)


def _block(scene, graph, block, present):
    """P(state of the block | what is outside).

    Π p_h over the present Π (1 − p_h) over the absent, normalised if the block is cyclic.
    """
    weight = np.ones(len(present[block[0]]))
    for h in block:
        p = acceptance(scene, scene.by_id[h], present, graph.of[h])
        weight *= np.where(present[h], p, 1.0 - p)
    return weight if len(block) == 1 else _normalised(weight, block, present, scene.situation)


def _normalised(weight, block, present, situation):
    """Per context, sum to 1 over what Σc allows; where no state is stable, the empty one takes it all."""
    outside = [column for name, column in present.items() if name not in block]
    context = sum(
        (column.astype(np.int64) << bit for bit, column in enumerate(outside)), np.zeros(len(weight), np.int64)
    )
    lawful = weight.copy()
    for x, y in situation.overlaps | situation.exclusive:
        lawful[present[x] & present[y] & (x in block) & (y in block)] = 0.0
    weight = np.where(np.bincount(context, lawful)[context] > 0, lawful, weight)
    empty = ~np.logical_or.reduce([present[h] for h in block])
    weight = np.where(np.bincount(context, weight)[context] > 0, weight, empty)
    share = weight / np.bincount(context, weight)[context]
    lifted = np.where(share > 0, np.maximum(share, LEAST), 0.0)
    return lifted / np.bincount(context, lifted)[context]


def _posterior(scene, present):
    logs = np.zeros(len(next(iter(present.values()))))
    for shares in group_shares(scene).values():
        logs += np.log(_prior(shares, present))
    for h in scene.situation.hypotheses:
        logs += pixel_odds(h, present)
        for f in unmatched(h):
            logs += np.log(miss_weight(scene, h, f, present))
    for appearance in scene.claimants:
        logs += np.log(appearance_weight(scene, appearance, present))
    return logs


def _prior(shares, present):
    count = sum(present[name].astype(np.int64) for name, _ in shares)
    weight = np.where(count == 0, 1.0 - sum(p for _, p in shares), 1.0 * (count == 1))
    for name, p in shares:
        weight = np.where(present[name] & (count == 1), p, weight)
    return np.maximum(weight, 0.0)
