"""From poses drawn from the prior to the posterior's, and how much of the prior's mass the reports leave.

Sequential Monte Carlo (Del Moral, Doucet, Jasra 2006): the reports are let in by and by, as a power of their
likelihood that rises from 0 to 1; after each step poses are drawn anew by their weights and moved a little, so that
what fits is refined, as far as the prior allows.
"""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices
from plogic.sequence.unposed.drawn import At, Prior
from plogic.sequence.unposed.standing import Target

KEPT = 500
"""Poses that are moved."""
MOVES = 3
"""Moves after each step."""
STEPS = 12
"""Steps at most: the last lets in all that is left."""
FRESH = 0.5
"""Effective share of the poses that a step keeps."""
TURN, SHIFT, DEPTH = 0.5, 0.25, 0.25
"""Largest moves: radians, radii of the body across the screen, log depth; a pose moves by 1 to 1/30 of them."""


class Annealed(NamedTuple):
    """Poses that are alike probable, and the logarithm of the mean likelihood under the prior."""

    at: At
    log_mean: float


def annealed(target: Target, start: At, rng: np.random.Generator) -> Annealed:
    """The posterior in the stratum near others, of which ``start`` are poses of the prior."""
    at, logs, power = start, target.log_likelihood(start), 0.0
    if not np.isfinite(logs).any():
        return Annealed(at.take(np.zeros(0, np.intp)), -np.inf)
    base = np.where(np.isfinite(logs), 0.0, -np.inf)
    mean = log_sum(base) - float(np.log(len(logs)))
    for step in range(STEPS):
        finite = np.where(np.isfinite(logs), logs, 0.0)
        more = 1.0 - power if step == STEPS - 1 else _step(base, finite, 1.0 - power)
        weights = base + more * finite
        mean += log_sum(weights) - log_sum(base)
        power += more
        chosen = systematic(np.exp(weights - weights.max()), KEPT)
        at, logs, base = at.take(chosen), logs[chosen], np.zeros(KEPT)
        for _ in range(MOVES):
            at, logs = _moved(target, at, logs, power, rng)
        if power >= 1.0:
            break
    return Annealed(at, mean)


def _step(base: Floats, logs: Floats, most: float) -> float:
    """The largest step of the power that keeps a share ``FRESH`` of the poses effective."""
    least = FRESH * min(_effective(base), KEPT)
    low, high = 0.0, most
    if _effective(base + most * logs) >= least:
        return most
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _effective(base + middle * logs) >= least else (low, middle)
    return max(low, 1e-4)


def _effective(logs: Floats) -> float:
    weights = np.exp(logs - logs.max())
    return float(weights.sum() ** 2 / (weights**2).sum())


def log_sum(logs: Floats) -> float:
    """Ln Σ exp; minus infinity where nothing is finite."""
    if not np.isfinite(logs.max()):
        return -np.inf
    return float(logs.max() + np.log(np.exp(logs - logs.max()).sum()))


def systematic(share: Floats, count: int) -> Indices:
    """(M,) indices, each ``count`` times its share (N,) but for rounding."""
    cumulative = np.cumsum(share) / share.sum()
    return np.minimum(np.searchsorted(cumulative, (np.arange(count) + 0.5) / count), len(share) - 1)


def _moved(target: Target, at: At, logs: Floats, power: float, rng: np.random.Generator) -> tuple[At, Floats]:
    """Every pose moved at random, or left where the move is refused (Metropolis)."""
    prior, count = target.prior, len(logs)
    new = _stepped(prior, at, rng)
    allowed = np.flatnonzero(prior.allows_near(new.middle))
    fresh, turned = np.full(count, -np.inf), np.zeros(count)
    if len(allowed):
        some = new.take(allowed)
        fresh[allowed] = target.log_likelihood(some)
        turned[allowed] = prior.log_direction(some) - prior.log_direction(at.take(allowed))
    taken = np.log(rng.uniform(size=count)) < power * (fresh - logs) + turned
    rotation = np.where(taken[:, None, None], new.rotation, at.rotation)
    return At(rotation, np.where(taken[:, None], new.middle, at.middle)), np.where(taken, fresh, logs)


def _stepped(prior: Prior, at: At, rng: np.random.Generator) -> At:
    from scipy.spatial.transform import Rotation

    count, camera = len(at.middle), prior.camera
    scale = 30.0 ** -rng.uniform(size=(count, 1))
    turn = Rotation.from_rotvec(rng.normal(size=(count, 3)) * scale * TURN).as_matrix()
    size = prior.cloud.radius * camera.f / at.middle[:, 2:]
    uv = camera.project(at.middle) + rng.normal(size=(count, 2)) * scale * SHIFT * size
    z = at.middle[:, 2:] * np.exp(rng.normal(size=(count, 1)) * scale * DEPTH)
    return At(turn @ at.rotation, np.concatenate([camera.normalised(uv), np.ones((count, 1))], axis=1) * z)
