"""A type looked for on planes and tops, once; and again those of its poses there that new bodies may hide.

What its views suggest on a plane does not change with what is accepted. What its pixels tell there does, where an
accepted body stands before it: those poses alone are moved anew, with the pixels of that body masked.

* ``Place``: what is looked for, and beside what; ``on_supports``: the hypotheses, and what is kept for the next time
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.match.judged.rivals import distinct
from plogic.match.learned.learned_pixels import Seen, hiding
from plogic.match.learned.learned_poses import resting
from plogic.match.learned.learned_views import seen_on

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from geometry.arrays import Floats, Mask
    from geometry.bodies.standing import Known
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.judged.type_models import Found, Request
    from plogic.match.learned.learned_models import LearnedIndex
    from sensing.views.maps import PhotoMaps


STILL = 0.1
"""Share of what planes are alike by, beyond which what has little print is looked for anew: in a trace of two photos of
``lmo`` 6 of 16 objects were found with 0.5, 7 with 0.2, 8 with 0.05. Keypoints tell poses on any that is alike."""


class Stood(NamedTuple):
    """The poses that views suggested on what is ``known``, told ``beside`` bodies at these poses (4, 4)."""

    known: Known
    seen: Seen
    beside: tuple[Floats, ...]


class Place(NamedTuple):
    """All that is asked for, the data that are ``left`` of it, what is accepted, and a photo's ``maps``.

    ``taken`` (N, 4): as of ``learned_poses.resting``.
    """

    request: Request
    left: Data
    accepted: tuple[Hypothesis, ...]
    taken: Floats
    maps: PhotoMaps | None


def on_supports(
    index: LearnedIndex, supports: Sequence[Known], earlier: Sequence[Stood], place: Place
) -> tuple[Found, list[Stood]]:
    """The hypotheses of a type on planes or tops, best first; and all that it was looked for on, for the next time."""
    request, before, share = place.request, hiding(place.accepted), STILL if index.plain else 1.0
    old = [next((one for one in earlier if one.known.same(known, share)), None) for known in supports]
    new = [known for known, one in zip(supports, old, strict=True) if one is None]
    unknown = iter(seen_on(index, place.maps, request.data, new))
    beside = tuple(posed.camera_from_object for posed in place.accepted)
    found: Found = []
    stood = [one for one in earlier if not any(one is other for other in old)]
    for known, one in zip(supports, old, strict=True):
        seen = next(unknown) if one is None else one.seen
        stood.append(Stood(known if one is None else one.known, seen, beside))
        if one is not None:
            since = (h for h in place.accepted if not any(h.camera_from_object is pose for pose in one.beside))
            seen = seen.some(maybe_hidden(index, seen.poses, since))
        found += resting(index, known, place.left, request.kb, place.taken, before=before, seen=seen, anew=one is None)
    return distinct(found, index.object_type), stood


def maybe_hidden(index: LearnedIndex, poses: Floats, some: Iterable[Hypothesis]) -> Mask:
    """(N,) which of a type's poses (N, 4, 4) some bodies may hide, or take the place of, by the balls around them."""
    here = poses[:, :3, :3] @ index.centre + poses[:, :3, 3]
    hidden = np.zeros(len(poses), bool)
    for other in some:
        there, surface = other.middle, other.object_type.surface
        radii = 0.5 * index.diameter, 0.5 * (0.0 if surface is None else surface.diameter)
        apart = np.linalg.norm(here[:, :2] / here[:, 2:] - there[:2] / there[2], axis=1)
        hidden |= (apart < radii[0] / here[:, 2] + radii[1] / there[2]) & (here[:, 2] > there[2] - sum(radii))
    return hidden
