"""What several views say together.

One Situation over all their data, whose worlds are those of the place, not of an image (§8).

The hypotheses stand in the world, the same in every view. A view adds the features that it expects of them and the data
that it has; given the world, views are independent. Priors count once, and so does what a pose owes to its freedom
(``plogic.match.judged.evidence``), of all views' matches together.

Hypotheses of several views that are one stand at the pose at which all views are explained best (§8, near-duplicates).
One view leaves the distance open by more than another view's tolerance. So what each view matched by itself is laid
together before anything is matched anew: a pose through all of these matches is tried beside each view's own.

* ``merged``, ``laid_together``: the distinct hypotheses of all views
* ``Joint``: what comes of it
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.poses.refine import turned_step
from geometry.poses.reprojection import information
from plogic.base.bounds import LEAST
from plogic.cycle.delta import Options, delta_of, instances
from plogic.cycle.placing import gravity_of_view
from plogic.cycle.state import Cycle, Trace
from plogic.match.judged.evidence import as_counted, evidence, judged, known, pose_information, share_of
from plogic.match.judged.rivals import excludes, moved_apart
from plogic.scene.worlds.ranked_worlds import Ranking, ranked_worlds
from plogic.sequence.views.standing import Seen, Standing, refined, seen_alone, seen_beside, standing_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from geometry.arrays import Floats, Mask
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import FeatureFact, Hypothesis
    from plogic.facts.situation import Situation
    from plogic.facts.spatial import Gravity
    from plogic.match.gamma.data import Data
    from plogic.match.judged.type_models import TypeModel
    from plogic.run.perceive import Perceiver
    from plogic.sequence.constancy.sight_lines import View


class Found(NamedTuple):
    """A view, and the hypotheses that it led to by itself."""

    seen: Seen
    beliefs: Sequence[Hypothesis]


class Member(NamedTuple):
    """A hypothesis where it stands, the number of a view, and how that view shows it."""

    standing: Standing
    view: int
    posed: Hypothesis


def merged(found: Sequence[Found], models: Mapping[str, TypeModel], kb: KnowledgeBase) -> list[Standing]:
    """The distinct hypotheses of all views, told from where the first view stands."""
    members = [
        Member(standing_of(belief, one.seen.view, models), v, belief)
        for v, one in enumerate(found)
        for belief in one.beliefs
    ]
    return laid_together(members, [one.seen for one in found], found[0].seen.view, kb) if found else []


def laid_together(members: Iterable[Member], seen: Sequence[Seen], view: View, kb: KnowledgeBase) -> list[Standing]:
    """Near-duplicates, told from where a ``view`` stands, as one, each at the place that explains all views' data best.

    Tried are the poses of its members, one through all their matches, and those of what else may stand there: what
    looks alike fits alike.
    """
    heaps: list[list[Member]] = []
    for member in members:
        heap = next((some for some in heaps if some[0].standing.same(member.standing, view)), None)
        if heap is None:
            heaps.append([member])
        else:
            heap.append(member)
    places = [member.standing for heap in heaps for member in heap]
    return [_best(heap, places, seen, view, kb) for heap in heaps]


def _best(
    heap: Sequence[Member], places: Sequence[Standing], seen: Sequence[Seen], view: View, kb: KnowledgeBase
) -> Standing:
    """The pose of greatest evidence over all views; of equals the first."""
    first = heap[0].standing
    if len(seen) == 1:
        return first
    there = (Standing(first.index, some.world_from_object) for some in places)
    starts = [*(m.standing for m in heap), *(some for some in there if some.same(first, view))]
    own = {member.view: member.posed for member in reversed(heap)}  # what each view matched by itself
    starts += [refined(s, list(own.values()), [seen[v] for v in own], kb) for s in (first, heap[-1].standing)]
    distinct = {some.world_from_object.tobytes(): some for some in starts}.values()
    return max(distinct, key=lambda some: sum(evidence(seen_alone(some, one, kb), one.data, kb).ratio for one in seen))


ROUNDS = 2
"""Times that poses are refined in all views together, and matched again."""
AGAIN = 3
"""Times that all are judged, each time beside the Δi that the last came to."""


@dataclass(frozen=True, eq=False)
class Joint:
    """``standing``: Δh in the order h1, h2, ..., the ``first`` of them Δi.

    ``posed[v][i]``: how view v shows hypothesis i; ``situation`` of all.
    """

    standing: tuple[Standing, ...]
    first: int
    posed: tuple[tuple[Hypothesis, ...], ...]
    situation: Situation


class _Known(NamedTuple):
    """``information`` (6, 6) of one hypothesis in one view, world axes, about its middle; ``depth`` of that, metres."""

    information: Floats
    depth: float


def joint(
    seen: Sequence[Seen], standing: Sequence[Standing], perceiver: Perceiver, options: Options
) -> tuple[Joint, Ranking]:
    """Judge hypotheses in all views, each refined on what all views show of it.

    Δi is what is present in the most probable world.

    What is matched depends on what Δi is: so they are judged again where the worlds say that it is another, ``AGAIN``
    times at most. Raises ValueError without a view.
    """
    if not seen:
        raise ValueError("there is no view to judge hypotheses in")
    ordered, first = _ordered(standing, seen, perceiver.kb)
    for _ in range(AGAIN):
        found = _judged(ordered, first, seen, perceiver, options)
        ranking = ranked_worlds(found.situation)
        present = {int(name[1:]) - 1 for name in ranking.worlds[0].present} if ranking.worlds else set()
        if present == set(range(first)):
            break
        inside = sorted(present)
        ordered = [found.standing[i] for i in [*inside, *(i for i in range(len(ordered)) if i not in present)]]
        first = len(inside)
    return found, ranking


def _judged(
    ordered: Sequence[Standing], first: int, seen: Sequence[Seen], perceiver: Perceiver, options: Options
) -> Joint:
    """Hypotheses of which the ``first`` are in Δi, in all views."""
    kb = perceiver.kb
    posed = _posed(ordered, first, seen, kb)
    for _ in range(ROUNDS if len(seen) > 1 else 0):
        ordered = [refined(some, mine, seen, kb) for some, mine in zip(ordered, zip(*posed, strict=True), strict=True)]
        posed = _posed(ordered, first, seen, kb)
    ordered, posed = _apart(ordered, first, posed, seen, kb)
    told = [_told(mine, first, some, perceiver, options) for mine, some in zip(posed, seen, strict=True)]
    situation = _merged(told, seen, ordered)
    situation = replace(situation, gravity=_gravity(situation, posed, seen, kb))
    return Joint(tuple(ordered), first, tuple(tuple(mine) for mine in posed), situation)


def _apart(
    ordered: Sequence[Standing], first: int, posed: list[list[Hypothesis]], seen: Sequence[Seen], kb: KnowledgeBase
) -> tuple[Sequence[Standing], list[list[Hypothesis]]]:
    """Hypotheses, and how views show them, moved out of each other (A4).

    Δi all together, each rival out of those that it does not exclude.
    """
    last, world_from_camera = posed[-1], seen[-1].view.world_from_camera
    columns, there = list(zip(*posed, strict=True)), list(last)
    told = cache(lambda i: _together(columns[i], seen, kb))

    def apart(of: Sequence[int], still: int = 0) -> list[Floats]:
        return moved_apart([there[i] for i in of], lambda k: told(of[k]), still)[0]

    poses = apart(range(first))
    there[:first] = [replace(some, camera_from_object=pose) for some, pose in zip(last, poses, strict=False)]
    for i in range(first, len(last)):
        others = [j for j in range(first) if not _excludes(columns[i], columns[j])]
        poses.append(apart([*others, i], still=len(others))[-1])
    stay = [pose is some.camera_from_object for pose, some in zip(poses, last, strict=True)]
    if all(stay):
        return ordered, posed
    ordered = [
        some if stays else Standing(some.index, np.asarray(world_from_camera @ pose))
        for some, pose, stays in zip(ordered, poses, stay, strict=True)
    ]
    return ordered, _posed(ordered, first, seen, kb)


def _gravity(
    situation: Situation, posed: Sequence[Sequence[Hypothesis]], seen: Sequence[Seen], kb: KnowledgeBase
) -> Gravity | None:
    """Who holds whom in the world, with what all views tell of the poses, in the axes of the last."""
    ids = [h.id for h in situation.hypotheses]
    there = replace(seen[-1].data.camera, world_from_camera=seen[-1].view.world_from_camera)
    known = {name: _together([mine[i] for mine in posed], seen, kb) for i, name in enumerate(ids)} if kb.gravity else {}
    return gravity_of_view(dict(zip(ids, posed[-1], strict=True)), situation.overlaps, there, kb, known)


def _together(posed: Sequence[Hypothesis], seen: Sequence[Seen], kb: KnowledgeBase) -> Floats:
    """What all views together tell of one pose (6, 6), in the axes of the last view's camera."""
    last = seen[-1].view.world_from_camera[:3, :3]
    turns = [turned_step(last.T @ one.view.world_from_camera[:3, :3]) for one in seen]
    told = [
        turn @ pose_information(mine, one.data.camera, kb) @ turn.T
        for turn, mine, one in zip(turns, posed, seen, strict=True)
    ]
    return np.asarray(np.sum(told, axis=0))


def _ordered(standing: Sequence[Standing], seen: Sequence[Seen], kb: KnowledgeBase) -> tuple[list[Standing], int]:
    """The hypotheses, those of Δi first, and how many these are.

    The heaviest over all views, and each next that none of them excludes.
    """
    alone = [[seen_alone(some, one, kb) for one in seen] for some in standing]
    worth = [sum(evidence(posed, one.data, kb).ratio for posed, one in zip(mine, seen, strict=True)) for mine in alone]
    order = sorted(range(len(standing)), key=lambda i: -worth[i])
    kept: list[int] = []
    for i in order:
        if worth[i] > 0.0 and not any(_excludes(alone[i], alone[j]) for j in kept):
            kept.append(i)
    return [standing[i] for i in [*kept, *(i for i in order if i not in kept)]], len(kept)


def _excludes(one: Sequence[Hypothesis], other: Sequence[Hypothesis]) -> bool:
    """A4, or claims on the same data in some view."""
    return any(excludes(a, b) for a, b in zip(one, other, strict=True))


def _posed(standing: Sequence[Standing], first: int, seen: Sequence[Seen], kb: KnowledgeBase) -> list[list[Hypothesis]]:
    """All hypotheses in each view."""
    return [seen_beside(standing, [seen_alone(some, one, kb) for some in standing], first, one, kb) for one in seen]


class _Told(NamedTuple):
    """One view's Situation, whose matches owe nothing yet, and what its matches tell of each hypothesis' pose."""

    situation: Situation
    known: tuple[_Known | None, ...]


def _told(posed: Sequence[Hypothesis], first: int, seen: Seen, perceiver: Perceiver, options: Options) -> _Told:
    kb, known = perceiver.kb, list[_Known | None]()

    def counted(one: Hypothesis, data: Data, kb: KnowledgeBase, hidden: Mask | None) -> tuple[Floats, Floats]:
        known.append(_known(one, hidden, seen, kb))
        return as_counted(one, data, kb, hidden)

    accepted, rivals = (
        tuple(judged(one, seen.data, kb, perceiver.dv).told(status=status) for one in some)
        for some, status in ((posed[:first], "accepted"), (posed[first:], "rival"))
    )
    cycle = Cycle(accepted, rivals, (), (), Trace())
    alone = replace(kb, gravity=False)  # who holds whom is decided by all views together
    situation = delta_of(cycle, seen.data, alone, perceiver.dv, options, counted, related=False).situation
    return _Told(situation, tuple(known))


def _known(posed: Hypothesis, hidden: Mask | None, seen: Seen, kb: KnowledgeBase) -> _Known | None:
    """What a view's matches tell of a pose; None where there are none."""
    found = posed.expected(hidden) & posed.detected
    if not found.any():
        return None
    at, precision, middle, across = known(posed, found, seen.data, kb)
    own = information(at, middle, precision, seen.data.camera, across)
    turn = turned_step(seen.view.camera_from_world[:3, :3])
    return _Known(turn.T @ own @ turn, float(posed.middle[2]))


def _merged(told: Sequence[_Told], seen: Sequence[Seen], standing: Sequence[Standing]) -> Situation:
    """One Situation of all views': hypotheses with the features of each, ids behind those of their views.

    Relations are of views, and not told.
    """
    last = told[-1].situation
    exclusive = frozenset(chain.from_iterable(t.situation.exclusive for t in told))
    groups = instances({h.id: h.type for h in last.hypotheses}, exclusive)
    appearances = [
        replace(a, id=f"{one.view.id}:{a.id}")
        for t, one in zip(told, seen, strict=True)
        for a in t.situation.appearances
    ]
    clutter = {a.id: a.clutter for a in appearances}
    hypotheses = [_hypothesis(i, told, seen, groups, clutter) for i in range(len(standing))]
    return replace(
        last,
        hypotheses=tuple(hypotheses),
        appearances=tuple(appearances),
        overlaps=frozenset(chain.from_iterable(t.situation.overlaps for t in told)),
        rivals=frozenset(chain.from_iterable(t.situation.rivals for t in told)),
        exclusive=exclusive,
    )


def _hypothesis(
    i: int, told: Sequence[_Told], seen: Sequence[Seen], groups: Mapping[str, str], clutter: Mapping[str, float]
) -> Hypothesis:
    """Hypothesis ``i`` with its features in every view: those of view v1 as 'v1:roof/apex'."""
    last = told[-1].situation.hypotheses[i]
    features = [
        replace(f, id=f"{view.id}:{f.id}", match=None if f.match is None else f"{view.id}:{f.match}")
        for t, (view, _) in zip(told, seen, strict=True)
        for f in t.situation.hypotheses[i].features
    ]
    pairs = [(k, one) for t, one in zip(told, seen, strict=True) if (k := t.known[i]) is not None]
    owed = 0.0
    if pairs:
        total = np.sum([k.information for k, _ in pairs], axis=0)
        nearest, one = min(pairs, key=lambda pair: pair[0].depth)
        turn = turned_step(one.view.camera_from_world[:3, :3])
        owed = float(share_of(turn @ total @ turn.T, nearest.depth, one.data.camera))
    return replace(last, group=groups[last.id], parts=(), features=tuple(owing(last, features, clutter, owed)))


def owing(
    h: Hypothesis, features: Sequence[FeatureFact], clutter: Mapping[str, float], owed: float
) -> list[FeatureFact]:
    """Return the features; expected ones that are matched give up what the pose owes, in proportion.

    ``owed``: a logarithm, at most 0 (``plogic.match.judged.evidence``); ``clutter``: density of each datum, per pixel².
    """
    paying = [f for f in features if f.match is not None and f.density > 0.0 and h.expects(f)]
    rates = {f.id: (min(max(f.hit_rate, LEAST), 1.0 - LEAST), clutter[str(f.match)]) for f in paying}
    better = {
        f.id: float(np.log1p(rates[f.id][0] * f.density / ((1.0 - rates[f.id][0]) * rates[f.id][1]))) for f in paying
    }
    kept = max(LEAST, 1.0 + owed / max(sum(better.values()), LEAST))
    weaker = {
        name: float(np.expm1(kept * better[name])) * (1.0 - hit) * datum / hit for name, (hit, datum) in rates.items()
    }
    return [replace(f, density=weaker[f.id]) if f.id in weaker else f for f in features]
