"""Hand-modelled types searched for as the paper does, by sets of four, or by SoftPOSIT.

Slow, and what the fast searches are tested against.

SoftPOSIT takes random starts, for one type: pose and correspondence at once, where a feature may be any datum that
looks like it (§6.2).
"""

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from geometry.arrays import Floats, Mask
from geometry.camera import Camera
from geometry.poses.softposit import Annealing, SoftPositResult, random_starts, softposit
from kb.clouds.cloud import KnowledgeBase
from plogic.base.clock import unhurried
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.hand.hand_models import HandModels, TypeIndex, type_index
from plogic.match.judged.evidence import verified
from plogic.match.judged.expectation import FEWEST
from plogic.match.judged.type_models import Found, Given, Request, Search, Setup
from plogic.match.oriented.oriented_models import oriented_index
from plogic.match.plain import quadruples
from plogic.match.plain.quadruples import Typed, extended, scene_of

MOST = 128
"""Random starts of a type."""
STARTS = 16
"""Starts at a time: annealed together they take less time than alone."""
BETA = 2e-4
"""1/pixel² at the start: what nobody knows is where in the image it stands."""
SMALLEST, LARGEST = 40.0, 2.0
"""Pixels across, and image heights, between which an object is looked for."""
PROPOSED = 24
"""Poses that are proposed."""


def by_softposit(
    index: TypeIndex, data: Data, kb: KnowledgeBase, check: Callable[[], None] = unhurried
) -> list[Floats]:
    """Poses (4, 4) of a type, best first; none where no start converges.

    ``check`` is called between steps, and may raise to end the search.
    """
    scene, camera = scene_of(index, data, kb), data.camera
    if (scene.pairs.numbers > 0).sum() < FEWEST:
        return []
    rng, xy, across = np.random.default_rng(0), camera.normalised(data.uv), index.cells.diameter
    depth = camera.f * across / (LARGEST * camera.height), camera.f * across / SMALLEST
    poses = [np.zeros((0, 4, 4))]
    for _ in range(0, MOST, STARTS):
        found = annealed(scene.pairs, xy, rng, depth, setting_of(kb, camera), check)
        poses.append(found.camera_from_object[found.converged])
    check()
    return extended(scene, np.concatenate(poses), PROPOSED)


def setting_of(kb: KnowledgeBase, camera: Camera) -> Annealing:
    """How the starts are annealed, with the knowledge base's noise, and the camera's pixels."""
    return Annealing(beta=BETA, noise=kb.rates.sigma, pixel=1.0 / camera.f)


def annealed(
    pairs: Typed,
    xy: Floats,
    rng: np.random.Generator,
    depth: tuple[float, float],
    setting: Annealing,
    check: Callable[[], None] = unhurried,
) -> SoftPositResult:
    """What SoftPOSIT makes of the next ``STARTS`` random starts, the object between two depths, m."""
    start = random_starts(pairs.points, xy, STARTS, rng, depth=depth)
    return softposit(pairs.points, xy, start, allowed=pairs.mask(len(xy)), annealing=setting, check=check)


PLAIN = {"quadruples": quadruples.proposals, "softposit": by_softposit}
"""The plain generators of poses of one type, by name."""


@dataclass(frozen=True, eq=False)
class PlainModels(HandModels):
    """The types that a plain ``generator``, a key of ``PLAIN``, proposes poses of."""

    generator: ClassVar[str]

    @classmethod
    def of(cls, setup: Setup) -> Self:
        """Make some types ready; angles count in matching, where the KB knows how they err."""
        made = type_index if setup.kb.rates.sigma_angle is None else oriented_index
        return cls({kind.name: made(kind, setup.dv) for kind in setup.types})

    def search(self, request: Request) -> Search:
        """The search for one type after another in one Γ."""
        return PlainSearch(self.generator, self.models, request.kb, request.check)


class Quadruples(PlainModels):
    """Types searched for by sets of four and POSIT (§6.1, §6.3)."""

    generator = "quadruples"


class SoftPosit(PlainModels):
    """Types searched for by SoftPOSIT from random starts (§6.2)."""

    generator = "softposit"


@dataclass(frozen=True, eq=False)
class PlainSearch(Search):
    """The search by one ``generator`` in what is left of Γ."""

    generator: str
    models: Mapping[str, TypeIndex]
    kb: KnowledgeBase
    check: Callable[[], None]
    at_once: ClassVar[int | None] = 1

    def propose(self, names: Sequence[str], left: Data, given: Given) -> Generator[Found]:
        """The hypotheses of each type, verified by matching."""
        for name in names:
            found = generate_plainly(self.generator, self.models[name], left, self.kb, given.hidden_of, self.check)
            given.seen(found)
            yield found


def generate_plainly(
    generator: str,
    index: TypeIndex,
    data: Data,
    kb: KnowledgeBase,
    hidden_of: Callable[[Hypothesis], Mask],
    check: Callable[[], None] = unhurried,
) -> Found:
    """The poses that a plain ``generator`` (a key of ``PLAIN``) proposes of a type, verified by matching, best first.

    ``hidden_of`` tells (F,) which features of a hypothesis accepted objects hide. ``check`` is called between sets or
    starts, and before each pose is verified, and may raise to end the search.
    """
    return verified(index, PLAIN[generator](index, data, kb, check), data, kb, hidden_of, check, rounds=2)
