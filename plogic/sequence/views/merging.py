"""Hypotheses of several views that are one: at which pose it stands, so that all views are explained best (§8, near-duplicates).

One view leaves the distance open by more than another view's tolerance. So what each view matched by itself is laid
together before anything is matched anew: a pose through all of these matches is tried beside each view's own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from plogic.match.judged.evidence import evidence
from plogic.sequence.views.standing import Seen, Standing, refined, seen_alone, standing_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.judged.type_models import TypeModel


class Found(NamedTuple):
    """A view, and the hypotheses that it led to by itself."""

    seen: Seen
    beliefs: Sequence[Hypothesis]


class _Member(NamedTuple):
    standing: Standing
    view: int
    posed: Hypothesis


def merged(found: Sequence[Found], models: Mapping[str, TypeModel], kb: KnowledgeBase) -> list[Standing]:
    """The distinct hypotheses of all views, each where it explains all views' data best, of the places at which any view has something like it.

    Tried are the poses of its own views, one through all their matches, and those of what else may stand there: what
    looks alike fits alike.
    """
    heaps = _heaps(found, models)
    everybody = [member for heap in heaps for member in heap]
    return [_best(heap, everybody, [one.seen for one in found], kb) for heap in heaps]


def _heaps(found: Sequence[Found], models: Mapping[str, TypeModel]) -> list[list[_Member]]:
    """Near-duplicates together, told from where the first view stands."""
    heaps: list[list[_Member]] = []
    for v, (seen, beliefs) in enumerate(found):
        for belief in beliefs:
            member = _Member(standing_of(belief, seen.view, models), v, belief)
            heap = next((some for some in heaps if some[0].standing.same(member.standing, found[0].seen.view)), None)
            if heap is None:
                heaps.append([member])
            else:
                heap.append(member)
    return heaps


def _best(heap: Sequence[_Member], everybody: Sequence[_Member], seen: Sequence[Seen], kb: KnowledgeBase) -> Standing:
    """The pose of greatest evidence over all views; of equals the first."""
    first = heap[0].standing
    if len(seen) == 1:
        return first
    there = [Standing(first.index, m.standing.world_from_object) for m in everybody]
    starts = [m.standing for m in heap] + [some for some in there if some.same(first, seen[0].view)]
    starts += [_through(heap, start, seen, kb) for start in (first, heap[-1].standing)]
    return max(starts, key=lambda some: sum(evidence(seen_alone(some, one, kb), one.data, kb).ratio for one in seen))


def _through(heap: Sequence[_Member], start: Standing, seen: Sequence[Seen], kb: KnowledgeBase) -> Standing:
    """The pose through what each view matched by itself."""
    own = {member.view: member.posed for member in reversed(heap)}
    return refined(start, list(own.values()), [seen[v] for v in own], kb)
