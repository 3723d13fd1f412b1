"""How much a look would tell: the information, in bits, between the worlds and which sites report, I(W; Z) = H(W) − E[H(W | Z)].

Sites with the same probabilities in every world are counted, not told apart (the count is all that they say): where the
outcomes are few the sum is exact, else it is taken over samples, the same for all candidates as far as they go, until
its standard error is below ``ERROR``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices


OUTCOMES = 200_000
"""Joint outcomes times worlds that are enumerated."""
ERROR = 0.004
"""Bits: the standard error at which sampling stops."""
BATCH, BATCHES = 2048, 40
"""Samples of a batch, shared out over the worlds, and the most batches."""
SAME = 12
"""Digits to which probabilities are the same."""


class Gain(NamedTuple):
    """``bits`` with the standard ``error`` of it, 0 where it is exact; ``sites``: how many differ between worlds."""

    bits: float
    error: float
    sites: int


class _Told(NamedTuple):
    """C classes of worlds alike, G groups of sites alike: P(class) (C,), P(answer | class) (C, A), sites (G,), report (C, G)."""

    mass: Floats
    answers: Floats
    sites: Indices
    report: Floats


def entropy(p: Floats, axis: int = -1) -> Floats:
    """−Σ p log2 p along an axis, 0 log 0 being 0."""
    from scipy.special import xlogy

    return np.asarray(-xlogy(p, p).sum(axis=axis) / np.log(2.0) + 0.0)  # −0 is 0


def gain(probability: Floats, report: Floats, answers: Floats | None = None, seed: int = 0) -> Gain:
    """I(W; Z), or I(T; Z) where ``answers`` (W, A) are P(answer | w): of worlds (W,) and independent sites that report with (W, S)."""
    alike = np.round(report, SAME)
    differs = np.flatnonzero(np.ptp(alike, axis=0) > 0.0) if len(alike) else np.zeros(0, np.intp)
    if not len(differs):
        return Gain(0.0, 0.0, 0)
    told = _told(probability, alike[:, differs], answers)
    before = float(entropy(told.mass @ told.answers))
    outcomes = float(np.prod(told.sites + 1.0)) * len(told.mass)
    after, error = _enumerated(told) if outcomes <= OUTCOMES else _sampled(told, seed)
    return Gain(min(max(before - after, 0.0), before), error, len(differs))


def _told(probability: Floats, report: Floats, answers: Floats | None) -> _Told:
    columns, sites = np.unique(report, axis=1, return_counts=True)
    rows, which = np.unique(columns, axis=0, return_inverse=True)
    member = np.zeros((len(rows), len(probability)))
    member[np.asarray(which).reshape(-1), np.arange(len(probability))] = probability
    mass = member.sum(axis=1)
    kept = mass > 0.0
    given = np.eye(len(rows)) if answers is None else member @ answers / np.where(kept, mass, 1.0)[:, None]
    return _Told(mass[kept], given[kept], sites, rows[kept])


def _enumerated(told: _Told) -> tuple[float, float]:
    """E[H(answer | Z)] over every joint outcome."""
    from scipy.stats import binom

    joint = told.mass[:, None]
    for n, p in zip(told.sites, told.report.T, strict=True):
        pmf = binom.pmf(np.arange(n + 1)[None], n, p[:, None])
        joint = (joint[:, :, None] * pmf[:, None, :]).reshape(len(joint), -1)
    total = joint.sum(axis=0)
    joint, total = joint[:, total > 0.0], total[total > 0.0]
    return float(total @ entropy((joint / total).T @ told.answers)), 0.0


def _sampled(told: _Told, seed: int) -> tuple[float, float]:
    """E[H(answer | Z)] over samples from each class in turn, and its standard error."""
    rng = np.random.default_rng([seed, 8])
    each = max(BATCH // len(told.mass), 8)
    found = np.zeros((len(told.mass), 0))
    error = np.inf
    for _ in range(BATCHES):
        found = np.concatenate([found, np.stack([_left(told, c, each, rng) for c in range(len(told.mass))])], axis=1)
        error = float(np.sqrt((told.mass**2 * found.var(axis=1, ddof=1) / found.shape[1]).sum()))
        if error <= ERROR:
            break
    return float(told.mass @ found.mean(axis=1)), error


def _left(told: _Told, which: int, count: int, rng: np.random.Generator) -> Floats:
    """(M,) H(answer | z) for samples z of what is reported where one class is true."""
    from scipy.special import log_softmax, xlog1py, xlogy

    z = rng.binomial(told.sites, told.report[which], (count, len(told.sites)))
    p = told.report[None]
    logs = np.log(told.mass)[None] + (xlogy(z[:, None], p) + xlog1py((told.sites - z)[:, None], -p)).sum(axis=2)
    return entropy(np.exp(log_softmax(logs, axis=1)) @ told.answers)


def each_site(probability: Floats, report: Floats, answers: Floats | None = None) -> Floats:
    """(S,) what each site alone would tell, bits."""
    given = np.eye(len(probability)) if answers is None else answers
    joint = probability[:, None] * given
    mass = joint.sum(axis=0)
    by_answer = (joint / np.where(mass > 0.0, mass, 1.0)).T @ report
    return np.maximum(_flip(probability @ report) - mass @ _flip(by_answer), 0.0)


def _flip(p: Floats) -> Floats:
    return entropy(np.stack([p, 1.0 - p], axis=-1))
