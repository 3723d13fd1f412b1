"""Ranked possible worlds, exact, without ProbLog: tested equal to the program text (§8).

Vocabulary:

* ``World``, one assignment of present/1, ``World(0.961, ("h1", "h2"), {"a1": "h1/roof/apex", "a9": "noise"})``
* ``Ranking``, the most probable worlds with everything that a caller would otherwise normalise again
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.causes import causes
from plogic.components import components
from plogic.dependence import Scene, dependence
from plogic.errors import InconsistentError
from plogic.sanity import check
from plogic.weights import log_weights, subsets

if TYPE_CHECKING:
    from plogic.situation import Situation

    Ranked = list[tuple[float, tuple[str, ...]]]


@dataclass(frozen=True)
class World:
    """One possible world; ``present`` in the order of Δh, ``causes`` for every appearance of Γ."""

    probability: float
    present: tuple[str, ...]
    causes: dict[str, str]


@dataclass(frozen=True)
class Ranking:
    """The ``worlds``, most probable first, ties by ids; the interval of the mass ``unlisted``; ``marginals`` P(present(H)).

    ``log_evidence`` is ln P(constraints) in the score reading, and ln of the density of Γ's claimed part, of what is missing in it and of
    the constraints in the posterior reading.
    """

    worlds: tuple[World, ...]
    unlisted: tuple[float, float]
    log_evidence: float
    marginals: dict[str, float]


def ranked_worlds(situation: Situation, n: int = 10) -> Ranking:
    """The ``n`` most probable worlds; raises InconsistentError where none is possible, TooManyHypothesesError beyond the limit."""
    check(situation)
    scene = Scene(situation)
    ranked: Ranked = [(1.0, ())]
    marginals: dict[str, float] = {}
    log_evidence = 0.0
    graph = dependence(scene)
    for members in components(scene, graph):
        logs = log_weights(scene, graph, members)
        evidence = _log_sum(logs, members)
        probabilities = np.exp(logs - evidence)
        log_evidence += evidence
        marginals |= {name: float(probabilities[column].sum()) for name, column in subsets(members).items()}
        ranked = _best(_product(ranked, _ranked(probabilities, members, n)), n)
    order = [h.id for h in situation.hypotheses]
    worlds = tuple(_world(scene, p, tuple(h for h in order if h in present)) for p, present in ranked)
    rest = max(0.0, 1.0 - sum(w.probability for w in worlds))
    rest = 0.0 if rest < 1e-12 else rest
    return Ranking(worlds, (rest, rest), log_evidence, {h: min(marginals[h], 1.0) for h in order})


def _log_sum(logs: np.ndarray[tuple[int], np.dtype[np.float64]], members: tuple[str, ...]) -> float:
    top = logs.max()
    if top == -np.inf:
        raise InconsistentError(
            f"no world satisfies the constraints on {', '.join(members)}: "
            "each excludes what another holds for certain (smoothing would help)",
        )
    return float(top + np.log(np.exp(logs - top).sum()))


def _ranked(probabilities: np.ndarray[tuple[int], np.dtype[np.float64]], members: tuple[str, ...], n: int) -> Ranked:
    rows = np.flatnonzero(probabilities > 0)
    if len(rows) > n:
        least = np.partition(probabilities[rows], -n)[-n] if n else np.inf
        rows = rows[probabilities[rows] >= least * (1 - 1e-9)]
    return _best([(float(probabilities[r]), tuple(m for bit, m in enumerate(members) if r >> bit & 1)) for r in rows], n)


def _product(left: Ranked, right: Ranked) -> Ranked:
    return [(p * q, (*x, *y)) for p, x in left for q, y in right]


def _best(worlds: Ranked, n: int) -> Ranked:
    """The ``n`` best; probabilities that agree to twelve digits are ties, and go by ids."""
    return sorted(worlds, key=lambda world: (-float(f"{world[0]:.11e}"), world[1]))[:n]


def _world(scene: Scene, probability: float, present: tuple[str, ...]) -> World:
    return World(min(probability, 1.0), present, causes(scene, present))
