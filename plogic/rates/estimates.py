"""From records to counts, and from counts to rates.

Where every object of a scene is known, its counts are counted. Where a slot's presence is not known, its share comes
from EM (``plogic.rates.em``): expected counts, which need not be whole numbers.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from kb.clouds.cloud import Counts

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from kb.clouds.cloud import Rates
    from plogic.rates.records import Record, Slot

    Pairs = Mapping[str, tuple[float, float]]


def counted(records: Sequence[Record]) -> Counts:
    """What is observed outright: [hits, expected] a feature type, [appearances, images] an appearance type, [present, slots] a type."""
    hits: dict[str, list[bool]] = {}
    slots: dict[str, list[bool]] = {}
    for slot in (slot for record in records for slot in record.slots if slot.present is not None):
        slots.setdefault(slot.object_type, []).append(bool(slot.present))
        for sighting in slot.sightings if slot.present else ():
            hits.setdefault(sighting.feature_type, []).append(sighting.near)
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
    """Counts but those of some features and appearances: of visual words, whose rates are measured in learning and whose names change with it."""
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
    """(n + 1/2)/m appearances an image: the mean of a Poisson rate under Jeffreys' prior, above 0 even where none was seen."""
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
