"""The weight of every subset of one component, both readings: the definition of the program text, done by enumeration."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.acceptance import acceptance
from plogic.bounds import LEAST
from plogic.errors import TooManyHypothesesError
from plogic.likelihood import appearance_weight, group_shares, miss_weight, unmatched

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.acceptance import Flags
    from plogic.dependence import Dependence, Scene

    Weights = NDArray[np.float64]

LARGEST_COMPONENT = 16
"""Hypotheses that one component may have: it has 2 to that power worlds."""


def subsets(members: tuple[str, ...]) -> dict[str, Flags]:
    """Every subset of the members, as columns (2^k,); row ``i`` holds the members whose bit of ``i`` is set."""
    if len(members) > LARGEST_COMPONENT:
        raise TooManyHypothesesError(
            f"{len(members)} hypotheses hang together (first: {members[0]}); exact worlds are enumerated for at most {LARGEST_COMPONENT}",
        )
    rows = np.arange(2 ** len(members))
    return {name: (rows >> bit & 1).astype(np.bool_) for bit, name in enumerate(members)}


def log_weights(scene: Scene, graph: Dependence, members: tuple[str, ...]) -> Weights:
    """Natural logarithm of the weight of every subset, (2^k,), −inf where a constraint is violated; it sums to the component's evidence."""
    present = subsets(members)
    score = scene.situation.reading == "score"
    with np.errstate(divide="ignore"):
        logs = _score(scene, graph, present) if score else _posterior(scene, present)
    constraints = scene.situation.overlaps | (scene.situation.exclusive if score else frozenset())
    for x, y in constraints:
        if x in present and y in present:
            logs[present[x] & present[y]] = -np.inf
    return logs


def _score(scene: Scene, graph: Dependence, present: dict[str, Flags]) -> Weights:
    logs = np.zeros(len(next(iter(present.values()))))
    for block in graph.blocks:
        if block[0] in present:
            logs += np.log(_block(scene, graph, block, present))
    return logs


def _block(scene: Scene, graph: Dependence, block: tuple[str, ...], present: dict[str, Flags]) -> Weights:
    """P(state of the block | what is outside): Π p_h over the present Π (1 − p_h) over the absent, normalised if the block is cyclic."""
    weight = np.ones(len(present[block[0]]))
    for h in block:
        p = acceptance(scene, scene.by_id[h], present, graph.of[h])
        weight *= np.where(present[h], p, 1.0 - p)
    return weight if len(block) == 1 else _normalised(weight, block, present)


def _normalised(weight: Weights, block: tuple[str, ...], present: dict[str, Flags]) -> Weights:
    """Per context, sum to 1; where no state is stable, the empty one takes it all."""
    outside = [column for name, column in present.items() if name not in block]
    context = sum((column.astype(np.int64) << bit for bit, column in enumerate(outside)), np.zeros(len(weight), np.int64))
    empty = ~np.logical_or.reduce([present[h] for h in block])
    weight = np.where(np.bincount(context, weight)[context] > 0, weight, empty)
    share = weight / np.bincount(context, weight)[context]
    lifted = np.where(share > 0, np.maximum(share, LEAST), 0.0)
    result: Weights = lifted / np.bincount(context, lifted)[context]
    return result


def _posterior(scene: Scene, present: dict[str, Flags]) -> Weights:
    logs = np.zeros(len(next(iter(present.values()))))
    for shares in group_shares(scene).values():
        if shares[0][0] in present:
            logs += np.log(_prior(shares, present))
    for name in (name for name in present):
        h = scene.by_id[name]
        for f in unmatched(h):
            logs += np.log(miss_weight(scene, h, f, present))
    for appearance, claimants in scene.claimants.items():
        if claimants[0][0].id in present:
            logs += np.log(appearance_weight(scene, appearance, present))
    return logs


def _prior(shares: list[tuple[str, float]], present: dict[str, Flags]) -> Weights:
    count = sum(present[name].astype(np.int64) for name, _ in shares)
    weight = np.where(count == 0, 1.0 - sum(p for _, p in shares), 1.0 * (count == 1))
    for name, p in shares:
        weight = np.where(present[name] & (count == 1), p, weight)
    return np.maximum(weight, 0.0)
