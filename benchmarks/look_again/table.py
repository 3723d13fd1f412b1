"""The table of ``plogic bench look-again``, and what it claims."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.look_again.episode import MOST_VIEWS, SURE
from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

RESAMPLES = 10_000
CAPTION = f"""Views until the probability of the true world (which objects, within 5° and 5 %, and nothing else) is {SURE:g}; the first counts, and
leaves it below that. {MOST_VIEWS} views are the most: where they do not do, {MOST_VIEWS + 1} are counted. Intervals: 95 %, bootstrap over scenes."""


@dataclass(frozen=True)
class Counted:
    """One scene: its sort, the true world's probability after the first view, views per policy, and scenes tried."""

    sort: str
    first: float
    needed: Mapping[str, int]
    tried: int


def rows(found: Sequence[Counted], seed: int) -> list[dict[str, Any]]:
    """Mean views of each policy, in all and by sort of scene."""
    sorts = sorted({one.sort for one in found})
    table = []
    for name in found[0].needed:
        views = np.array([one.needed[name] for one in found])
        low, high = interval(views.astype(float), seed)
        of_sort = {sort: float(np.mean([one.needed[name] for one in found if one.sort == sort])) for sort in sorts}
        shares = {"in two": float((views <= 2).mean()), "never": float((views > MOST_VIEWS).mean())}
        table.append({"policy": name, "views": float(views.mean()), "low": low, "high": high, **of_sort, **shares})
    return table


def claims(found: Sequence[Counted], ours: str, seed: int, few: int | None = None) -> list[Claim]:
    """That ours needs fewer than each other, beyond chance, over 50 scenes.

    Over a ``few``, that it needs no more, on the average.
    """
    mine = np.array([one.needed[ours] for one in found], float)
    saved = {name: np.array([one.needed[name] for one in found]) - mine for name in found[0].needed if name != ours}
    if few is not None:
        means = [Claim(f"views saved over {name}", ">=", 0.0, float(some.mean())) for name, some in saved.items()]
        return [Claim("ambiguous scenes", ">=", few, len(found)), *means]
    listed = [
        Claim(f"views saved over {name}, low end", ">=", 0.001, interval(some, seed)[0]) for name, some in saved.items()
    ]
    return [Claim("ambiguous scenes", ">=", 50, len(found)), *listed]


def interval(values: NDArray[np.float64], seed: int) -> tuple[float, float]:
    """95 % of the means of scenes drawn again."""
    rng = np.random.default_rng([seed, 2009])
    means = values[rng.integers(len(values), size=(RESAMPLES, len(values)))].mean(axis=1)
    low, high = np.quantile(means, [0.025, 0.975])
    return float(low), float(high)
