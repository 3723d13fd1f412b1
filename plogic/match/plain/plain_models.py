"""Hand-modelled types searched for as the paper does, by sets of four, or by SoftPOSIT: slow, and what the fast searches are tested against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Self

from plogic.base.clock import unhurried
from plogic.match.hand.hand_models import HandModels, TypeIndex, type_index
from plogic.match.judged.evidence import evidence
from plogic.match.judged.expectation import FEWEST
from plogic.match.judged.rivals import distinct
from plogic.match.judged.type_models import Found, Given, Request, Search, Setup
from plogic.match.oriented.ready import oriented_index
from plogic.match.plain import quadruples
from plogic.match.plain import softposit_poses as softposit

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Mapping, Sequence

    from geometry.arrays import Mask
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data

PLAIN = {"quadruples": quadruples.proposals, "softposit": softposit.proposals}
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
    found = []
    for pose in PLAIN[generator](index, data, kb, check):
        check()
        posed = index.settle(pose, data, kb, rounds=0)
        hidden = hidden_of(posed)
        posed = index.settle(pose if hidden.any() else posed, data, kb, hidden=hidden)
        if (posed.candidate & posed.detected & ~hidden).sum() >= FEWEST:
            found.append((evidence(posed, data, kb, hidden).ratio, posed))
    return distinct(sorted(found, key=lambda pair: -pair[0]), index.object_type)
