"""A hypothesis where it stands in the world, and as one view of a sequence shows it.

* ``Standing``: ``Standing(index, world_from_object)``
* ``Seen``: a view with its Γ as arrays
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.frames import inverse, transform_points
from geometry.poses.refine_sights import Sight, refine_sights
from plogic.match.judged.evidence import sigmas
from plogic.match.judged.rivals import claims, excludes, hidden_among, same_place

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from geometry.arrays import Floats, Mask
    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.judged.type_models import TypeModel
    from plogic.sequence.views.view import View


LEAST_MATCHES = 4
"""Matches, in all views together, that a pose is refined on."""


class Seen(NamedTuple):
    """A view, and its Γ as arrays."""

    view: View
    data: Data


@dataclass(frozen=True, eq=False)
class Standing:
    """One hypothesis of Δh: a type, by its index, at a place in the world."""

    index: TypeModel
    world_from_object: Floats

    @property
    def object_type(self) -> ObjectType:
        """Whose pose it is."""
        return self.index.object_type

    def before(self, view: View) -> Floats:
        """camera_from_object (4, 4) in a view."""
        return np.asarray(view.camera_from_world @ self.world_from_object)

    def same(self, other: Standing, view: View) -> bool:
        """Whether the two are one hypothesis (§8), told from where a view stands."""
        mine, theirs = self.before(view), other.before(view)
        return self.object_type.name == other.object_type.name and same_place(self.object_type, mine, theirs)


def standing_of(belief: Hypothesis, view: View, models: Mapping[str, TypeModel]) -> Standing:
    """Where a hypothesis of one view stands in the world."""
    return Standing(models[belief.type], np.asarray(view.world_from_camera @ belief.camera_from_object))


def seen_alone(standing: Standing, seen: Seen, kb: KnowledgeBase) -> Hypothesis:
    """The hypothesis at its place, matched on all of a view's Γ as if nothing else were there."""
    return standing.index.settle(standing.before(seen.view), seen.data, kb, rounds=0)


def seen_beside(
    standing: Sequence[Standing], alone: Sequence[Hypothesis], first: int, seen: Seen, kb: KnowledgeBase
) -> list[Hypothesis]:
    """All hypotheses in one view, where the ``first`` of them are in Δi: none of these takes a datum of another, and what one hides is not expected.

    A rival is matched as if those that it excludes were not there. ``alone``: the same, as ``seen_alone`` gives them.
    """
    posed: list[Hypothesis] = []
    for i, (some, lone) in enumerate(zip(standing, alone, strict=True)):
        others = [j for j in range(first) if j != i and (i < first or not excludes(lone, alone[j]))]
        hidden = hidden_among(lone, [alone[j] for j in others])
        free = np.ones(len(seen.data.ids), bool)
        for j in others:
            if j < len(posed):
                free[list(claims(posed[j]))] = False
        posed.append(lone if free.all() and not hidden.any() else _settled(some, seen, kb, free, hidden))
    return posed


def _settled(standing: Standing, seen: Seen, kb: KnowledgeBase, free: Mask, hidden: Mask) -> Hypothesis:
    return standing.index.settle(standing.before(seen.view), seen.data, kb, free=free, hidden=hidden, rounds=0)


def refined(standing: Standing, posed: Sequence[Hypothesis], seen: Sequence[Seen], kb: KnowledgeBase) -> Standing:
    """The hypothesis at the pose that fits its expected, detected features best in all views together.

    As it was where they are too few.
    """
    sights = [_sight(one, some, kb) for one, some in zip(posed, seen, strict=True)]
    if sum(len(sight.uv) for sight in sights) < LEAST_MATCHES:
        return standing
    pose = refine_sights(standing.world_from_object, [s for s in sights if len(s.uv)], huber=2.0 * kb.rates.sigma)
    return Standing(standing.index, pose)


def _sight(posed: Hypothesis, seen: Seen, kb: KnowledgeBase) -> Sight:
    used = posed.candidate & posed.detected
    points = transform_points(inverse(posed.camera_from_object), posed.at[used])
    weights = posed.counted[used] / sigmas(posed, kb)[used] ** 2
    across = None if posed.across is None else posed.across[used]
    return Sight(
        seen.data.camera, seen.view.camera_from_world, points, seen.data.uv[posed.matches[used]], weights, across
    )
