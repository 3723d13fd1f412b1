"""Whether probabilities mean what they say: of all that was given 0.7, seven in ten should be true.

N forecasts p (N,) in [0, 1] and what came of them, y (N,), 0 or 1. Vocabulary:

* ``Bin(0.31, 0.39, forecast=0.35, true=0.27, count=68)``: forecasts between two bounds, their mean, and the share of
  them that came true
* *skill*: 1 for the perfect, 0 for whoever always says the base rate, below 0 for worse

Sources: Brier 1950 (the score), Murphy 1973 (its parts), Naeini, Cooper and Hauskrecht 2015 (ECE), Roelofs, Cain,
Shlens and Mozer 2022 (why the bins should be of equal mass), Wilson 1927 (the interval of a share), Efron and
Tibshirani 1993 (the bootstrap).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Statistic = Callable[[Floats, Floats], float]

BINS = 15
"""Bins of equal mass, as many as the literature takes."""
LEAST = 1e-6
"""Log loss takes no forecast as surer than this: to be wrong once, being quite sure, would cost without end."""
RESAMPLES, LEVEL = 1000, 0.95
"""Times that scenes are drawn anew, and the share of what comes out that an interval holds."""
DEVIATIONS = 1.959964
"""Standard deviations of a normal variable that hold that share."""


@dataclass(frozen=True)
class Bin:
    """Forecasts from ``low`` to ``high``, both of which are among them.

    ``forecast`` is their mean, ``true`` the share that came true.
    """

    low: float
    high: float
    forecast: float
    true: float
    count: int

    @property
    def interval(self) -> tuple[float, float]:
        """Where the true share lies with 95 %, were the forecasts independent (Wilson)."""
        n, z = self.count, DEVIATIONS
        middle = (self.true + z**2 / (2 * n)) / (1 + z**2 / n)
        half = z / (1 + z**2 / n) * np.sqrt(self.true * (1 - self.true) / n + z**2 / (4 * n**2))
        return max(0.0, float(middle - half)), min(1.0, float(middle + half))


@dataclass(frozen=True)
class Parts:
    """Brier score = ``reliability`` − ``resolution`` + ``uncertainty``, where a bin's forecasts are alike (Murphy)."""

    reliability: float
    resolution: float
    uncertainty: float


def brier(p: ArrayLike, y: ArrayLike) -> float:
    """Mean of (p − y)²: 0 at best, 1 at worst.

    Raises ValueError, as all here do, where p and y are no forecasts and outcomes.
    """
    p, y = _checked(p, y)
    return float(((p - y) ** 2).mean())


def brier_skill(p: ArrayLike, y: ArrayLike) -> float:
    """1 − Brier score over that of the base rate, ȳ (1 − ȳ).

    NaN where all outcomes are the same, and nothing is left to be said.
    """
    p, y = _checked(p, y)
    base = float(y.mean() * (1.0 - y.mean()))
    return 1.0 - brier(p, y) / base if base > 0.0 else float("nan")


def log_loss(p: ArrayLike, y: ArrayLike, least: float = LEAST) -> float:
    """Mean of −ln of the probability that was given to what came, forecasts clipped to [``least``, 1 − ``least``]."""
    p, y = _checked(p, y)
    clipped = np.clip(p, least, 1.0 - least)
    return float(-np.where(y > 0.5, np.log(clipped), np.log1p(-clipped)).mean())


def reliability(p: ArrayLike, y: ArrayLike, bins: int = BINS) -> tuple[Bin, ...]:
    """At most so many bins of about equal mass, lowest forecasts first.

    Equal forecasts are in one bin, so that no order matters.
    """
    p, y = _checked(p, y)
    which = _equal_mass(p, bins)
    members = [which == b for b in range(bins) if (which == b).any()]
    return tuple(
        Bin(float(p[m].min()), float(p[m].max()), float(p[m].mean()), float(y[m].mean()), int(m.sum())) for m in members
    )


def expected_calibration_error(p: ArrayLike, y: ArrayLike, bins: int = BINS) -> float:
    """ECE = Σ_b n_b / N · |ȳ_b − p̄_b| over bins of equal mass: 0 at best.

    Of few forecasts it is above 0 even where these are right.
    """
    p, y = _checked(p, y)
    which = _equal_mass(p, bins)
    return float(np.abs(np.bincount(which, y - p)).sum() / len(p))


def parts(p: ArrayLike, y: ArrayLike, bins: int = BINS) -> Parts:
    """Murphy's parts of the Brier score, over the same bins."""
    p, y = _checked(p, y)
    table, base = reliability(p, y, bins), float(y.mean())
    wrong = sum(b.count * (b.forecast - b.true) ** 2 for b in table) / len(p)
    told = sum(b.count * (b.true - base) ** 2 for b in table) / len(p)
    return Parts(wrong, told, base * (1.0 - base))


def bootstrap_interval(
    statistic: Statistic, p: ArrayLike, y: ArrayLike, scene: ArrayLike, *, seed: int = 0, resamples: int = RESAMPLES
) -> tuple[float, float]:
    """The percentile interval of ``LEVEL`` of a statistic, over scenes drawn anew, stretched to hold the estimate.

    ``scene`` (N,) tells the scene of each forecast: those of one scene depend on each other, so they are drawn
    together. Drawing anew adds noise, which raises an ECE; so its upper end is cautious.
    """
    p, y = _checked(p, y)
    _, which = np.unique(np.asarray(scene), return_inverse=True)
    members = np.split(np.argsort(which, kind="stable"), np.cumsum(np.bincount(which))[:-1])
    rng = np.random.default_rng(seed)
    drawn = [
        np.concatenate([members[i] for i in rng.integers(len(members), size=len(members))]) for _ in range(resamples)
    ]
    values = np.array([statistic(p[rows], y[rows]) for rows in drawn])
    low, high = np.nanquantile(values, [(1.0 - LEVEL) / 2.0, (1.0 + LEVEL) / 2.0])
    estimate = statistic(p, y)
    return min(float(low), estimate), max(float(high), estimate)


def _equal_mass(p: Floats, bins: int) -> NDArray[np.intp]:
    """(N,) the bin of each forecast.

    Where the middle of all that are equal to it stands in the order, in ``bins`` equal parts.
    """
    if bins < 1:
        raise ValueError(f"{bins} bins: at least one is needed")
    _, group, count = np.unique(p, return_inverse=True, return_counts=True)
    middle = np.cumsum(count) - count / 2.0
    return np.asarray(np.floor(bins * middle / len(p)), np.intp)[group]


def _checked(p: ArrayLike, y: ArrayLike) -> tuple[Floats, Floats]:
    """Both as floats (N,), N > 0."""
    forecasts, outcomes = np.asarray(p, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if forecasts.ndim != 1 or forecasts.shape != outcomes.shape or not len(forecasts):
        raise ValueError(
            f"forecasts and outcomes must be two rows of equal length, not {forecasts.shape} and {outcomes.shape}"
        )
    if not ((forecasts >= 0.0) & (forecasts <= 1.0)).all():
        raise ValueError("a forecast is no probability")
    if not np.isin(outcomes, (0.0, 1.0)).all():
        raise ValueError("an outcome is neither 0 nor 1")
    return forecasts, outcomes
