"""Which tracks there are, all together: a datum has one cause.

A packing of greatest weight, and the probability of each track in it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices


def packing(data: Indices, weight: Floats) -> Indices:
    """Indices, ascending, of tracks ``data`` (T, V) that share no datum, of great total ``weight`` (T,).

    Greedy, the heaviest first; then one is put in wherever it weighs more than all that it displaces, the most gainful
    first, until none does. Of equally heavy ones the first. It ends, for the total rises each time.
    """
    owner = _owners(data)
    for t in np.argsort(-weight, kind="stable").tolist():
        if weight[t] <= 0.0:
            break
        if not displaced(data[t : t + 1], owner)[0].any():
            _put(owner, data[t], t)
    while True:
        gain = weight - _cost(data, owner, weight)
        best = int(gain.argmax()) if len(gain) else -1
        if best < 0 or gain[best] <= 1e-9:
            break
        owner[np.isin(owner, displaced(data[best : best + 1], owner)[1])] = -1
        _put(owner, data[best], best)
    return np.unique(owner[owner >= 0])


def probabilities(data: Indices, weight: Floats, chosen: Indices) -> Floats:
    """(C,) that each chosen track is a physical feature, with all others as they are.

    Of the worlds that differ from the packing in what takes this track's data: itself, nothing, or a rival that
    displaces it (and, at their cost, others). Those count for it that keep two of its data together.
    """
    owner = _owners(data)
    for t in chosen.tolist():
        _put(owner, data[t], t)
    cost, own = _cost(data, owner, weight), _owned(data, owner)
    answers = []
    for t in chosen.tolist():
        shared = (own == t).sum(axis=1)
        rivals = np.flatnonzero((shared > 0) & (np.arange(len(data)) != t))
        logs = weight[rivals] - (cost[rivals] - weight[t])
        every = np.concatenate([[weight[t], 0.0], logs])
        top = float(every.max())
        total = np.exp(every - top).sum()
        answers.append((np.exp(weight[t] - top) + np.exp(logs[shared[rivals] > 1] - top).sum()) / total)
    return np.array(answers)


def displaced(data: Indices, owner: Indices) -> tuple[Indices, Indices]:
    """Of tracks (T, V): (T, V) whether a datum is taken; and all those that took one."""
    own = _owned(data, owner)
    return np.asarray(own >= 0), np.unique(own[own >= 0])


def _owners(data: Indices) -> Indices:
    """(V, N) the chosen track of each datum: -1, nobody yet."""
    return np.full((data.shape[1], int(data.max(initial=0)) + 1), -1, np.intp)


def _put(owner: Indices, row: Indices, track: int) -> None:
    views = np.flatnonzero(row >= 0)
    owner[views, row[views]] = track


def _owned(data: Indices, owner: Indices) -> Indices:
    """(T, V) the chosen track that has each datum of each track, -1 where nobody has."""
    return np.where(data >= 0, owner[np.arange(data.shape[1]), data], -1)


def _cost(data: Indices, owner: Indices, weight: Floats) -> Floats:
    """(T,) the weight of all the chosen tracks that each would displace, each counted once."""
    own = np.sort(_owned(data, owner), axis=1)
    first = own >= 0
    first[:, 1:] &= own[:, 1:] != own[:, :-1]
    return np.where(first, weight[own], 0.0).sum(axis=1) if len(data) else np.zeros(0)
