"""Hand-modelled types whose data have angles: all are searched for at once (``plogic.match.oriented.oriented_search``)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np

from plogic.base.clock import unhurried
from plogic.match.hand.hand_models import HandModels, TypeIndex
from plogic.match.judged.type_models import Found, Given, Request, Search, Setup
from plogic.match.oriented.angle_refinement import Noise
from plogic.match.oriented.asked import Asked, chances_of
from plogic.match.oriented.oriented_match import verified
from plogic.match.oriented.oriented_search import Search as TogetherSearch
from plogic.match.oriented.ready import ready

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Mapping, Sequence

    from geometry.arrays import Floats, Mask
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.oriented.pair_index import PairIndex

FEW_LEFT = 100
"""Matches of a feature and a datum that looks like it: where no more are left, single data are asked beside what is
accepted, too."""


@dataclass(frozen=True, eq=False)
class OrientedModels(HandModels):
    """``shared``: the index over all types."""

    shared: PairIndex

    @classmethod
    def of(cls, setup: Setup) -> Self:
        """Make some types ready; the index over many is kept in a folder."""
        shared = ready(setup.types, setup.dv, setup.folder)
        return cls({index.object_type.name: index for index in shared.indices}, shared)

    def search(self, request: Request) -> Search:
        """The search for all types at once; for one after another where no datum has an angle."""
        together = search_of(self.shared, request.data, request.kb, request.check)
        if together is None:
            return HandModels.search(self, request)
        return OrientedSearch(together, self.models, request.kb)


@dataclass(eq=False)
class OrientedSearch(Search):
    """The search for all types at once: pairs of data vote once, single data where pairs leave something open."""

    together: TogetherSearch
    models: Mapping[str, TypeIndex]
    kb: KnowledgeBase
    keeps: ClassVar[bool] = True

    def propose(self, names: Sequence[str], left: Data, given: Given) -> Generator[Found]:
        """The hypotheses of each type: all are found before this returns."""
        known = self.together.unasked
        found = generate_together(self.together, left, self.kb, given.hidden_of, given.seen)
        if self.together.unasked > known:
            given.tell(
                f"{self.together.unasked} types were left out, those that pairs vote for least: too many data look alike"
            )
        return (found[name] for name in names)

    def deepen(self, left: Data, *, accepted: bool) -> str | None:
        """Ask single data the next time, once, where nothing at all was accepted, or little is left to ask."""
        if self.together.deepened or (accepted and not self._little(left)):
            return None
        self.together.deepen()
        why = "so little is left that it can be asked" if accepted else "nothing is acceptable"
        return f"{why}: every datum votes by itself"

    def _little(self, left: Data) -> bool:
        """Whether all types together have at most ``FEW_LEFT`` matches of a feature and a free datum that looks like it."""
        matches = 0
        for index in self.models.values():
            matches += int(index.allowed(left).sum())
            if matches > FEW_LEFT:
                return False
        return True

    def tilted(self, posed: Hypothesis, left: Data) -> list[Floats]:
        """The best poses at other tilts: in one place a hypothesis may fit in several ways."""
        return self.together.tilted(posed.object_type.name, posed.camera_from_object, left)


def search_of(
    shared: PairIndex, data: Data, kb: KnowledgeBase, check: Callable[[], None] = unhurried
) -> TogetherSearch | None:
    """The search for all types of an index in one Γ.

    None where the KB does not know how angles err, or no datum has one.
    """
    if kb.rates.sigma_angle is None or not np.isfinite(data.angle).any():
        return None
    return TogetherSearch(
        Asked(shared, data, Noise(kb.rates.sigma, kb.rates.sigma_angle), chances_of(shared, kb.rates), check=check)
    )


def generate_together(
    search: TogetherSearch,
    data: Data,
    kb: KnowledgeBase,
    hidden_of: Callable[[Hypothesis], Mask] | None = None,
    seen: Callable[[Found], None] | None = None,
) -> dict[str, Found]:
    """The hypotheses of all types, by type, that some data of Γ suggest, with their log-likelihood ratios, best first.

    ``hidden_of`` tells (F,) which features of a hypothesis accepted objects hide; ``seen`` is told each type's as soon
    as they are there, that of the best proposal first.
    """
    indices = search.index.indices
    poses: dict[int, list[Floats]] = {}
    for proposal in search.proposals(data):
        poses.setdefault(proposal.kind, []).append(proposal.pose)
    result: dict[str, Found] = {index.object_type.name: [] for index in indices}
    for kind, some in poses.items():
        found = verified(indices[kind], some, data, kb, hidden_of, search.asked.check)
        result[indices[kind].object_type.name] = found
        if seen is not None:
            seen(found)
    return result
