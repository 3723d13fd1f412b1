"""A hypothesis where it stands in the world, and as one image of a sequence, or both of a stereo pair, show it.

* ``Standing``: ``Standing(index, world_from_object)``
* ``Seen``: a view with its Γ as arrays

Of a stereo pair (§3.3) the left image, with its depths, decides what is there, both together how it stands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.frames import inverse, transform_points
from geometry.poses.refine import Sight, refine_sights
from plogic.match.gamma.data import Data, data_of
from plogic.match.judged.evidence import judged, sigmas
from plogic.match.judged.expectation import FEWEST
from plogic.match.judged.rivals import claims, excludes, hidden_among, same_place
from plogic.sequence.constancy.sight_lines import View

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from geometry.arrays import Floats
    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.cycle.state import Cycle
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.judged.type_models import TypeModel
    from plogic.run.perceive import Perceiver
    from sensing.appearance import Gamma
    from sensing.files.stereo import Pair


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
    """All hypotheses in one view, where the ``first`` of them are in Δi.

    None of these takes a datum of another, and what one hides is not expected.

    A rival is matched as if those that it excludes were not there. ``alone``: the same, as ``seen_alone`` gives them.
    """
    posed: list[Hypothesis] = []
    for i, (some, lone) in enumerate(zip(standing, alone, strict=True)):
        others = [j for j in range(first) if j != i and (i < first or not excludes(lone, alone[j]))]
        hidden = hidden_among(lone, [alone[j] for j in others])
        free = np.ones(len(seen.data.ids), bool)
        free[[datum for j in others if j < len(posed) for datum in claims(posed[j])]] = False
        posed.append(
            lone
            if free.all() and not hidden.any()
            else some.index.settle(some.before(seen.view), seen.data, kb, free=free, hidden=hidden, rounds=0)
        )
    return posed


def refined(standing: Standing, posed: Sequence[Hypothesis], seen: Sequence[Seen], kb: KnowledgeBase) -> Standing:
    """The hypothesis at the pose that fits its expected, detected features best in all views together.

    As it was where they are too few.
    """
    sights = [_sight(one, some, kb) for one, some in zip(posed, seen, strict=True)]
    if sum(len(sight.uv) for sight in sights) < FEWEST:
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


ROUNDS = 2
"""Times that each pose is refined on what both show, and matched again."""


def sharpened(cycle: Cycle, left: Gamma, data: Data, right: Gamma, pair: Pair, perceiver: Perceiver) -> Cycle:
    """The outcome of a cycle over the left image, what it accepted refined on both.

    Features are matched in the right one where they project.

    ``data``: the left Γ as arrays. What is present, and its rivals, stay.
    """
    kb = perceiver.kb
    near = Seen(View("left", left, np.eye(4)), data)
    aside = Seen(
        View("right", right, inverse(pair.right_from_left)), data_of(right.appearances, right.camera, perceiver.width)
    )
    standing = [Standing(perceiver.models[b.type], b.camera_from_object) for b in cycle.accepted]
    for _ in range(ROUNDS):
        posed = [_posed(standing, seen, perceiver) for seen in (near, aside)]
        standing = [
            refined(some, mine, (near, aside), kb)
            for some, mine in zip(standing, zip(*posed, strict=True), strict=True)
        ]
    final = _posed(standing, near, perceiver)
    accepted = [
        judged(one, data, kb, perceiver.dv, hidden_among(one, final)).told(status=belief.status, why=belief.why)
        for belief, one in zip(cycle.accepted, final, strict=True)
    ]
    return replace(cycle, accepted=tuple(accepted))


def _posed(standing: Sequence[Standing], seen: Seen, perceiver: Perceiver) -> list[Hypothesis]:
    """All of them in one image, beside each other."""
    alone = [seen_alone(some, seen, perceiver.kb) for some in standing]
    return seen_beside(standing, alone, len(standing), seen, perceiver.kb)
