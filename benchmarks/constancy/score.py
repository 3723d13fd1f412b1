"""Scoring of ``plogic bench constancy``, pure: what was called physical, noise or neither, against whose each datum is.

* ``Called``: what one side made of a sequence's first views
* ``Score``: counts that add up over sequences
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

    from benchmarks.constancy.scenes import Cause, Sequence
    from plogic.sequence.constancy.result import Constancy


class Called(NamedTuple):
    """``physical``: features, each its data by view; ``objects``: clusters of their numbers.

    ``noise`` and ``undecided`` ids by view.
    """

    physical: tuple[Mapping[str, str], ...]
    objects: tuple[tuple[int, ...], ...]
    noise: Mapping[str, frozenset[str]]
    undecided: Mapping[str, frozenset[str]]


@dataclass(frozen=True)
class Score:
    """Counts, which add up.

    Of unknown features: ``visible`` in a view or more, detected ``twice`` or more, and those of them that were
        ``found``: a physical
    feature holds two of its data. Of what was called physical: ``called``, and ``right``: most of its data are of one
    true feature, unknown or
    left over of a known object. Of clutter: ``clutter``, called ``noise``, called ``undecided``. ``called_noise``: all
        that was called noise.
    Of unknown bodies: ``bodies`` with four features found, and those that are ``whole``: one cluster has at least 80 %
        of them and holds at
    most 10 % of others.
    """

    visible: int = 0
    twice: int = 0
    found: int = 0
    called: int = 0
    right: int = 0
    clutter: int = 0
    noise: int = 0
    undecided: int = 0
    called_noise: int = 0
    bodies: int = 0
    whole: int = 0

    def __add__(self, other: Score) -> Score:
        return Score(*(getattr(self, field.name) + getattr(other, field.name) for field in fields(self)))


FEWEST, MOST_OF, AT_MOST_OTHERS = 4, 0.8, 0.1
"""Found features of a body that is counted; what makes a cluster the whole of it."""


def called_of(constancy: Constancy) -> Called:
    """As the scores take it."""
    features = [feature for one in constancy.unknown for feature in one.features]
    number = {feature.id: i for i, feature in enumerate(features)}
    objects = tuple(tuple(number[feature.id] for feature in one.features) for one in constancy.unknown)
    noise, undecided = (
        {view: frozenset(ids) for view, ids in some.items()} for some in (constancy.noise, constancy.undecided)
    )
    return Called(tuple(feature.data for feature in features), objects, noise, undecided)


def score(sequence: Sequence, count: int, called: Called) -> Score:
    """Of a sequence's first ``count`` views."""
    views = [view.id for view in sequence.views[:count]]
    unknown = {c for view in views for c in sequence.visible[view] if not sequence.known[c.object]}
    times = Counter(c for view in views for c in sequence.causes[view].values() if not sequence.known[c.object])
    causes = [whose(sequence, data) for data in called.physical]
    found = {
        cause
        for row in causes
        for cause, n in row.items()
        if cause is not None and n >= 2 and not sequence.known[cause.object]
    }
    clutter = {
        (view.id, a.id)
        for view in sequence.views[:count]
        for a in view.gamma.appearances
        if a.id not in sequence.causes[view.id]
    }
    noise, undecided = (
        {(view, datum) for view, ids in some.items() for datum in ids} for some in (called.noise, called.undecided)
    )
    return Score(
        visible=len(unknown),
        twice=sum(n >= 2 for n in times.values()),
        found=len(found),
        called=len(causes),
        right=sum(is_one(row) for row in causes),
        clutter=len(clutter),
        noise=len(clutter & noise),
        undecided=len(clutter & undecided),
        called_noise=len(noise),
    ) + _bodies(called, causes, found)


def whose(sequence: Sequence, data: Mapping[str, str]) -> Counter[Cause | None]:
    """How many of a physical feature's data, by view, are of each true feature; None is clutter."""
    return Counter(sequence.causes[view].get(datum) for view, datum in data.items())


def is_one(row: Counter[Cause | None]) -> bool:
    """Whether most of a physical feature's data are of one true feature."""
    return any(cause is not None and 2 * n > row.total() for cause, n in row.items())


def _bodies(called: Called, causes: list[Counter[Cause | None]], found: set[Cause]) -> Score:
    body = [row.most_common(1)[0][0] for row in causes]
    of = Counter(c.object for c in found)
    whole = 0
    for which, count in of.items():
        shares = [
            (sum(body[i] is not None and _object(body[i]) == which for i in cluster), len(cluster))
            for cluster in called.objects
        ]
        whole += count >= FEWEST and any(
            own >= MOST_OF * count and own >= (1 - AT_MOST_OTHERS) * size for own, size in shares
        )
    return Score(bodies=sum(count >= FEWEST for count in of.values()), whole=whole)


def _object(cause: Cause | None) -> int:
    return -1 if cause is None else cause.object
