"""The cycle with something remembered: what Δp says should be here is looked at first, and a search is made only for what it leaves (§1, §7).

* ``Seed``: a type and the pose that it is expected at, ``Seed(of, camera_from_object)``
* ``Recall``: one run of the cycle that begins with such
"""

from __future__ import annotations

from collections import Counter
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from plogic.base.clock import OutOfTimeError
from plogic.cycle.beside import name_of
from plogic.cycle.perception import Perception

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.cycle.attention import Attention
    from plogic.cycle.belief import Cycle
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.judged.type_models import TypeModel

RARE = 0.001
"""Data that nobody explains are searched where clutter alone gives so many, of a type or of all, in less than this
share of images."""


class Seed(NamedTuple):
    """A type, by its index, and ``camera_from_object`` (4, 4), where it is expected."""

    of: TypeModel
    camera_from_object: NDArray[np.float64]


class Recall(Perception):
    """A run of the cycle over one Γ that begins with what is remembered."""

    def resume(self, attention: Sequence[Attention], seeds: Sequence[Seed], usual: Mapping[str, int]) -> Cycle:
        """Accept of the seeds, in their order, what holds here; then search for more where what is left is more than clutter, or than ``usual``.

        Without seeds that is the cycle.
        """
        refused = [belief for belief in map(self._recalled, seeds) if belief is not None]
        if not self.accepted:
            return self._with(refused, self.run(attention))
        with suppress(OutOfTimeError):  # what is remembered is accepted only when it is stable here
            self._keep()
        why = unexplained([self.data.types[i] for i in self.free().nonzero()[0]], self.kb, usual)
        if why is not None:
            self.trace.add("search", why)
            return self._with(refused, self.run(attention))
        self.trace.add("no search", "what is left is no more than clutter")
        self.searches = []
        return self._with(refused, replace(self.run(()), attention=tuple(attention)))

    def _recalled(self, seed: Seed) -> Hypothesis | None:
        """Accept a seed that holds here; give it back where it does not."""
        posed = seed.of.settle(seed.camera_from_object, self.data, self.kb, free=self.free(), rounds=0)
        belief = self._judge(posed, self.free(), rounds=2)
        refusal = self._refusal(belief)
        if refusal is not None:
            return belief.told(why=refusal)
        self.trace.add("recall", "stands where it is remembered", of_type=name_of(belief), ev=belief.ev_reconsidered)
        self._accept(belief)
        return None

    def _with(self, refused: Sequence[Hypothesis], cycle: Cycle) -> Cycle:
        """The cycle's outcome, and the seeds that did not hold, as rivals where each would alone."""
        rivals, rejected = len(self.rivals), len(self.rejected)
        for belief in refused:
            if not self._is_accepted(belief):
                self._set_aside(belief, f"remembered here, but: {belief.why}")
        more = tuple(map(self._makes_way, self.rivals[rivals:]))
        return replace(
            cycle, considered=cycle.considered + more, rejected=cycle.rejected + tuple(self.rejected[rejected:])
        )


def unexplained(types: Sequence[str], kb: KnowledgeBase, usual: Mapping[str, int]) -> str | None:
    """Of what data of these ``types`` there are more than clutter gives, in words; None where there are no more.

    ``usual``: how many of each type were left where a search found no more: where that is above the KB's clutter rate,
    this place has so much.
    """
    from scipy.stats import poisson

    rates = {name: kb.rates.clutter.get(name, 1.0) for name in kb.appearance_types}
    most = max(sum(rates.values()), sum(usual.values()))
    if poisson.sf(len(types) - 1, most) < RARE:
        return f"{len(types)} data are left, where clutter gives {most:.0f}"
    for name, number in sorted(Counter(types).items()):
        expected = max(rates.get(name, 1.0), usual.get(name, 0))
        if poisson.sf(number - 1, expected) < RARE / len(rates):
            return f"{number} of {name} are left, where clutter gives {expected:.1f}"
    return None
