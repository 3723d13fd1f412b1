"""Distinctiveness dv of feature types (§5.1), and what could be here before any pose is known.

Valuation and rank (§5.2, §5.3).

Vocabulary:

* ``Counts``, the number of instances |S(F)| of each feature type F, ``{"apex": 1, "corner": 16, "patch": 95}``
* a substitution θ, a partial injective map from features to appearances, ``{0: 3, 4: 1}`` by their indices
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType


def instance_counts(types: Iterable[ObjectType]) -> dict[str, int]:
    """Count S(F): the Feature nodes of each type over ``types``, instances and not appearances.

    Compounds and their parts alike (§2.2).

    The same type given twice counts twice: that is what dv over Δ wants (§5.1, variant of §9).
    """
    counts: Counter[str] = Counter()
    for object_type in types:
        counts.update(feature.type for feature in object_type.all_features)
    return dict(sorted(counts.items()))


def probability_of_distinctiveness(counts: Mapping[str, int]) -> dict[str, float]:
    """P(dv(F)) = |S(F)| / |S|; it sums to 1 over the feature types, and is empty where S is."""
    total = sum(counts.values())
    return {name: number / total for name, number in counts.items() if total}


def distinctiveness(counts: Mapping[str, int]) -> dict[str, float]:
    """dv(F) = 1 − |S(F)| / |S| (§5.1). With one feature type in all of S every dv is 0."""
    return {name: 1.0 - share for name, share in probability_of_distinctiveness(counts).items()}


def distinctiveness_over_delta(accepted: Iterable[ObjectType], background: Iterable[ObjectType]) -> dict[str, float]:
    """Dv over the instances in Δ, falling back to Σo when Δ is empty (§5.1, the variant of the paper's §9).

    A feature type of Σo without an instance in Δ is as distinctive as can be: its dv is 1.
    """
    over_background = instance_counts(background)
    over_delta = instance_counts(accepted)
    if not over_delta:
        return distinctiveness(over_background)
    return distinctiveness({name: over_delta.get(name, 0) for name in over_background})


def compatible(feature_types: Sequence[frozenset[str]], appearance_types: Sequence[str]) -> NDArray[np.bool_]:
    """(F, A) mask: appearance a is of one of the types in which feature f can appear."""
    number: dict[str, int] = {}
    which = [number.setdefault(name, len(number)) for name in appearance_types]
    mask = np.array([[name in types for name in number] for types in feature_types], dtype=bool).reshape(
        len(feature_types), len(number)
    )
    return np.asarray(mask[:, which])


def is_legal(substitution: Mapping[int, int], allowed: NDArray[np.bool_]) -> bool:
    """Whether θ is legal: compatible, and injective: an appearance serves one feature, matched once (§5.2)."""
    values = list(substitution.values())
    return len(set(values)) == len(values) and all(bool(allowed[f, a]) for f, a in substitution.items())


Kind = TypeVar("Kind", bound="Hashable")
"""What appearances are told apart by: their type, or which one it is."""


def best_substitution(
    weights: NDArray[np.float64], ways: Sequence[Iterable[Kind]], there: Mapping[Kind, int]
) -> dict[int, Kind]:
    """The legal θ of greatest Σ weight over matched features, in their order: a maximum-weight matching (§5.3).

    ``weights`` (F,) ≥ 0; ``ways``: the kinds of appearance that each feature may match, of which so many are ``there``.
    The heaviest comes first, and whom it displaces is matched otherwise: sets that can be matched together are a
    matroid, so the greedy choice is the best, and who finds no way now finds none later. Features of weight 0 are
    matched where that costs nothing. Oracles: brute force, and SciPy's ``linear_sum_assignment``.
    """
    room = dict(there)
    serves: dict[int, Kind] = {}
    held: dict[Kind, list[int]] = {kind: [] for kind in room}
    full: set[Kind] = {kind for kind, count in room.items() if not count}
    for feature in np.argsort(-weights, kind="stable").tolist():
        asks: dict[Kind, int] = {}
        free = _free_kind(feature, ways, room, held, full, asks)
        if free is None:
            full.update(asks)
            continue
        room[free] -= 1
        while True:
            one = asks[free]
            held[free].append(one)
            before = serves.get(one)
            serves[one] = free
            if before is None:
                break
            held[before].remove(one)
            free = before
    return dict(sorted(serves.items()))


def _free_kind(
    feature: int,
    ways: Sequence[Iterable[Kind]],
    room: Mapping[Kind, int],
    held: Mapping[Kind, list[int]],
    full: Collection[Kind],
    asks: dict[Kind, int],
) -> Kind | None:
    """A kind with room that a feature comes to, others giving way; ``asks``: who asks for each kind."""
    asking = [feature]
    for one in asking:  # it grows
        for kind in ways[one]:
            if kind in room and kind not in asks and kind not in full:
                asks[kind] = one
                if room[kind]:
                    return kind
                asking += held[kind]
    return None


def valuation(weights: NDArray[np.float64], substitution: Iterable[int]) -> float:
    """Take v(Type, θ) = Σ dv(matched features) / Σ dv(all features of Type); 0 where every dv is 0 (§5.3, §5.1)."""
    total = float(weights.sum())
    heavy = weights.tolist()
    return (
        min(1.0, sum(heavy[f] for f in substitution) / total) if total > 0.0 else 0.0
    )  # sums of different order may differ


def rank(weights: NDArray[np.float64], ways: Sequence[Iterable[Kind]], there: Mapping[Kind, int]) -> float:
    """Best valuation of a type over all legal θ (§5.3); the arguments are those of ``best_substitution``."""
    return valuation(weights, best_substitution(weights, ways, there))


def rank_of_kinds(weights: NDArray[np.float64], kinds: Kinds, there: Mapping[str, int]) -> float:
    """``rank`` where feature f is matched by appearances of one type alone.

    Of each type the heaviest features, as many as are ``there``.
    """
    matched = kinds.place < np.array([there.get(name, 0) for name in kinds.names], np.intp)[kinds.code]
    total = float(weights.sum())
    return min(1.0, float(weights[matched].sum()) / total) if total > 0.0 else 0.0


class Kinds(NamedTuple):
    """Features by their one appearance type.

    Its ``names`` (K), each feature's ``code`` (F,) among them, and its ``place`` (F,) in it.

    Of one type the heaviest is in place 0, the next in place 1.
    """

    names: tuple[str, ...]
    code: NDArray[np.intp]
    place: NDArray[np.intp]


def kinds_of(weights: NDArray[np.float64], types: Sequence[str]) -> Kinds:
    """Of F features of these weights (F,) and appearance types."""
    names, code = np.unique(np.array(types, dtype=str), return_inverse=True)
    order = np.lexsort((-weights, code))
    place = np.empty(len(order), np.intp)
    place[order] = np.arange(len(order)) - np.searchsorted(code[order], code[order])
    return Kinds(tuple(names.tolist()), code, place)
