"""From records to counts, and from counts to rates.

Where every object of a scene is known, its counts are counted. Where a slot's presence is not known, its share comes
from EM (``plogic.rates.estimates``): expected counts, which need not be whole numbers.
"""

from __future__ import annotations

import math
import warnings
from collections import Counter
from typing import TYPE_CHECKING, Any

from kb.clouds.cloud import Counts, Rates
from plogic.base.walk import by_key

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence

    from plogic.rates.scene_records import Record, Slot

    Pairs = Mapping[str, tuple[float, float]]


def counted(records: Sequence[Record]) -> Counts:
    """What is observed: [hits, expected] a feature type, [appearances, images] a look, [present, slots] a type."""
    known = [slot for record in records for slot in record.slots if slot.present is not None]
    slots = by_key((slot.object_type, bool(slot.present)) for slot in known)
    hits = by_key((s.feature_type, s.near) for slot in known if slot.present for s in slot.sightings)
    whole = [record.clutter for record in records if record.clutter is not None]
    noise = Counter({name: 0 for clutter in whole for name in clutter})
    for clutter in whole:
        noise.update(clutter)
    return Counts(
        hit={name: (float(sum(flags)), float(len(flags))) for name, flags in sorted(hits.items())},
        clutter={name: (float(number), float(len(whole))) for name, number in sorted(noise.items())},
        prior={name: (float(sum(flags)), float(len(flags))) for name, flags in sorted(slots.items())},
    )


def open_slots(records: Sequence[Record]) -> list[Slot]:
    """The slots of which nobody knows whether an object is there."""
    return [slot for record in records for slot in record.slots if slot.present is None]


def added(*counts: Counts) -> Counts:
    """The sum of counts, key by key."""
    return Counts(*(_sum([getattr(c, name) for c in counts]) for name in ("hit", "clutter", "prior")))


def without(counts: Counts, names: Collection[str]) -> Counts:
    """Counts but those of some features and appearances.

    Of visual words, whose rates are measured in learning and whose names change with it.
    """
    hit, clutter = (
        {name: pair for name, pair in table.items() if name not in names} for table in (counts.hit, counts.clutter)
    )
    return Counts(hit=hit, clutter=clutter, prior=counts.prior)


def _sum(tables: Sequence[Pairs]) -> dict[str, tuple[float, float]]:
    names = sorted({name for table in tables for name in table})
    pairs = {name: [table[name] for table in tables if name in table] for name in names}
    return {name: (sum(n for n, _ in rows), sum(m for _, m in rows)) for name, rows in pairs.items()}


def share(pair: tuple[float, float]) -> float:
    """(n + 1)/(m + 2), Laplace's rule: never 0 or 1, whatever few scenes show."""
    return (pair[0] + 1.0) / (pair[1] + 2.0)


def mean(pair: tuple[float, float]) -> float:
    """(n + 1/2)/m appearances an image.

    The mean of a Poisson rate under Jeffreys' prior, above 0 even where none was seen.
    """
    return (pair[0] + 0.5) / pair[1]


def learned(counts: Counts, rates: Rates) -> Rates:
    """``rates`` with what the counts say; of what was not seen in any scene the old rate stays."""
    from dataclasses import replace

    return replace(
        rates,
        hit=rates.hit | {name: share(pair) for name, pair in counts.hit.items() if pair[1]},
        clutter=rates.clutter | {name: mean(pair) for name, pair in counts.clutter.items() if pair[1]},
        prior=rates.prior | {name: share(pair) for name, pair in counts.prior.items() if pair[1]},
        counts=counts,
    )


ROUNDS = 200
"""Most rounds of EM."""
GAIN = 1e-6
"""EM stops where a round raises the log-likelihood by less."""


def expected_counts(slots: Sequence[Slot], observed: Counts, start: Rates) -> Counts:
    """``observed`` with the expected counts of the open ``slots`` at the likelihood's maximum by EM from ``start``."""
    if not slots:
        return observed
    hit, prior = _fitted(slots, observed, start)
    return added(observed, *(_of_slot(slot, presence(slot, hit, prior), hit) for slot in slots))


def presence(slot: Slot, hit: dict[str, float], prior: dict[str, float]) -> float:
    """P(the object is there | its sightings), by Bayes' rule."""
    p = prior[slot.object_type]
    there, absent = math.log(max(p, 1e-300)), math.log(max(1.0 - p, 1e-300))
    for s in slot.sightings:
        near = hit[s.feature_type] + (1.0 - hit[s.feature_type]) * s.chance
        there += math.log(max(near if s.near else 1.0 - near, 1e-300))
        absent += math.log(max(s.chance if s.near else 1.0 - s.chance, 1e-300))
    return 1.0 / (1.0 + math.exp(min(absent - there, 700.0)))


def _of_slot(slot: Slot, p: float, hit: dict[str, float]) -> Counts:
    """The expected counts of one slot: a near feature of a present object is a hit, or chance beside a miss."""
    table: dict[str, tuple[float, float]] = {}
    for s in slot.sightings:
        h = hit[s.feature_type]
        hits, of = table.get(s.feature_type, (0.0, 0.0))
        caused = h / (h + (1.0 - h) * s.chance) if s.near and h > 0.0 else 0.0
        table[s.feature_type] = (hits + p * caused, of + p)
    return Counts(hit=table, prior={slot.object_type: (p, 1.0)})


def _fitted(slots: Sequence[Slot], observed: Counts, start: Rates) -> tuple[dict[str, float], dict[str, float]]:
    """The maximum-likelihood hit rates and priors, by name."""
    kinds = sorted({s.object_type for s in slots})
    features = sorted({s.feature_type for slot in slots for s in slot.sightings})
    text = "\n".join(_program(slots, kinds, features, start))
    weights = _learn(text, [*_open_examples(slots), *_observed_examples(kinds, features, observed)])
    return (
        {name: weights["hit", j] for j, name in enumerate(features)},
        {name: weights["present", k] for k, name in enumerate(kinds)},
    )


def _program(slots: Sequence[Slot], kinds: list[str], features: list[str], start: Rates) -> Iterator[str]:
    yield from (f"t({_inside(start.prior[name])})::present({k}, I) :- slot(I, {k})." for k, name in enumerate(kinds))
    yield from (f"t({_inside(start.hit[name])})::hit({j}, I, F) :- seen(I, F, {j})." for j, name in enumerate(features))
    yield "near(I, F) :- slot(I, K), present(K, I), seen(I, F, J), hit(J, I, F)."
    yield "near(I, F) :- chance(I, F)."
    yield from (f"slot(observed, {k})." for k in range(len(kinds)))
    yield from (f"seen(observed, observed, {j})." for j in range(len(features)))
    for i, slot in enumerate(slots):
        yield f"slot({i}, {kinds.index(slot.object_type)})."
        for f, s in enumerate(slot.sightings):
            yield f"seen({i}, {f}, {features.index(s.feature_type)}). {_inside(s.chance)!r}::chance({i}, {f})."
    yield "chance(observed, observed) :- fail."


def _inside(p: float) -> float:
    """A start or a chance strictly between 0 and 1: EM never leaves 0 or 1."""
    return min(max(p, 1e-6), 1.0 - 1e-6)


def _open_examples(slots: Sequence[Slot]) -> Iterator[list[tuple[str, bool]]]:
    for i, slot in enumerate(slots):
        if slot.sightings:
            yield [(f"near({i}, {f})", s.near) for f, s in enumerate(slot.sightings)]


def _observed_examples(kinds: list[str], features: list[str], observed: Counts) -> Iterator[list[tuple[str, bool]]]:
    """[n, of] as n examples in which the atom is true and of − n in which it is false; LFI compiles each kind once."""
    atoms = [(f"present({k}, observed)", observed.prior.get(name, (0.0, 0.0))) for k, name in enumerate(kinds)]
    atoms += [(f"hit({j}, observed, observed)", observed.hit.get(name, (0.0, 0.0))) for j, name in enumerate(features)]
    for atom, (n, of) in atoms:
        yield from ([(atom, True)] for _ in range(round(n)))
        yield from ([(atom, False)] for _ in range(round(of - n)))


def _learn(text: str, examples: list[list[tuple[str, bool]]]) -> dict[tuple[str, int], float]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # ProbLog's copy of pyparsing
        from problog.ddnnf_formula import DDNNF
        from problog.learning.lfi import run_lfi
        from problog.logic import Term
        from problog.program import PrologString

    terms: list[Any] = [[(Term.from_string(atom), value) for atom, value in example] for example in examples]
    _, weights, names, _, _ = run_lfi(PrologString(text), terms, max_iter=ROUNDS, min_improv=GAIN, knowledge=DDNNF)
    return {(str(name.functor), int(name.args[0])): float(w) for name, w in zip(names, weights, strict=True)}
