"""Hand-modelled types whose data have angles: all are searched for at once (``plogic.match.oriented.oriented_search``).

They are made ready for that together, kept on disk between runs, and mapped from there.

* ``OrientedIndex``: one such type
* ``ready(types, dv, folder)``: the indices of the types, and the index over them
* ``key_of(types)``: what decides the index over types, as 64 hex digits: the types themselves as they enter it, in
  their order, our source, and the libraries. Neither dv nor the rates enter what is kept
* ``OrientedModels``: all types of this kind
"""

import hashlib
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from itertools import accumulate
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Mask
from geometry.files.remembered import ROOT, arrays_of, source_digest, sources_in
from kb.clouds.cloud import KnowledgeBase, ObjectType
from plogic.base.clock import unhurried
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.hand.hand_models import HandModels, TypeIndex, type_index
from plogic.match.hand.view_cells import ViewCells, remade
from plogic.match.judged.evidence import evidence, nothing_hidden, verified
from plogic.match.judged.expectation import AS_GOOD, settled
from plogic.match.judged.type_models import Found, Given, Request, Search, Setup
from plogic.match.oriented.asked import Asked, chances_of
from plogic.match.oriented.oriented_match import Noise, matched_at, polished
from plogic.match.oriented.oriented_search import Search as TogetherSearch
from plogic.match.oriented.pair_index import PairIndex, Sights, looks_of, pair_index

Arrays = Mapping[str, NDArray[Any]]


class OrientedIndex(TypeIndex):
    """A type that is matched by places and angles."""

    def settle(
        self,
        pose: Floats | Hypothesis,
        data: Data,
        kb: KnowledgeBase,
        free: Mask | None = None,
        hidden: Mask | None = None,
        rounds: int = 2,
    ) -> Hypothesis:
        """The type at a pose, or one that is matched there already.

        Matched, refined on places and angles, and matched again.
        """
        allowed = self.allowed(data)
        return settled(
            pose,
            lambda pose: matched_at(self, pose, data, kb, allowed, free, hidden),
            lambda posed: polished(self, posed, data, kb, hidden),
            rounds,
            lambda posed: evidence(posed, data, kb, hidden).surplus,
            AS_GOOD,
        )


def oriented_index(object_type: ObjectType, dv: Mapping[str, float], cells: ViewCells | None = None) -> OrientedIndex:
    """Build the index of one type. ``cells``, where they are known."""
    return type_index(object_type, dv, cells, OrientedIndex)


SOURCES = "geometry", "kb", "plogic/base", "plogic/facts", "plogic/match", "plogic/measures"
"""What makes an index, methods of the types and their surfaces too; whole folders, for no import leads to the class of
what is handed in."""
LIBRARIES = ("numpy", "embreex")
"""They compute, and shoot the rays."""


def key_of(types: Sequence[ObjectType]) -> str:
    """SHA-256 over all of some types that an index may say, the source that makes it, and the libraries' versions."""
    total = hashlib.sha256(_made_by())
    for kind in types:
        total.update(_content(kind))
    return total.hexdigest()


@cache
def _made_by() -> bytes:
    return repr([version(name) for name in LIBRARIES]).encode() + source_digest(ROOT, sources_in(ROOT, SOURCES))


def _content(kind: ObjectType) -> bytes:
    """SHA-256 over a type: its features, their lobes, its surface and symmetries."""
    features, table, surface = kind.seen_features, kind.lobes, kind.surface
    named = [(feature.name, feature.type, feature.parts, len(feature.arms)) for feature in features]
    total = hashlib.sha256(
        repr(
            (kind.name, kind.opaque, surface is None, named, table.types, table.features, kind.whole.tolist())
        ).encode()
    )
    arrays = [
        np.array([feature.at for feature in features]), np.array([feature.rotation for feature in features]),
        np.concatenate([np.zeros((0, 3)), *(feature.arms for feature in features)]), kind.symmetries,
        table.feature, table.at, table.axis, table.cos_half, table.r_min, table.r_max, table.size,
    ]  # fmt: skip
    for array in arrays if surface is None else [*arrays, surface.vertices, surface.triangles]:
        total.update(f"{array.dtype.str}{array.shape}".encode() + np.ascontiguousarray(array).tobytes())
    return total.digest()


MANY = 20
"""Fewer types are made ready within a second, about, and not kept."""
_CELLS, _SIGHTS, _PAIRS = (
    ("xy", "visible", "arms"),
    ("feature", "looks", "xy", "angle", "diameter"),
    ("key", "entry", "turned"),
)
_NAMES = [*(f"cells_{name}" for name in _CELLS), *(f"sights_{name}" for name in _SIGHTS), *_PAIRS]


def ready(types: Sequence[ObjectType], dv: Mapping[str, float], folder: Path | None = None) -> PairIndex:
    """The index over some types; ``folder``: where indices are kept."""
    if folder is None or len(types) < MANY:
        return pair_index([oriented_index(kind, dv) for kind in types])
    arrays = arrays_of(
        folder / key_of(types), _NAMES, lambda: _arrays(pair_index([oriented_index(kind, dv) for kind in types]))
    )
    ends = np.cumsum([0, *(len(kind.seen_features) for kind in types)])
    indices = [
        oriented_index(kind, dv, remade(kind, *(arrays[f"cells_{name}"][:, low:high] for name in _CELLS)))
        for kind, low, high in zip(types, ends[:-1], ends[1:], strict=True)
    ]
    sights = Sights(*(arrays[f"sights_{name}"] for name in _SIGHTS))
    return PairIndex(tuple(indices), looks_of(types), sights, *(arrays[name] for name in _PAIRS))


def _arrays(index: PairIndex) -> Arrays:
    arms = max((cells.arms.shape[2] for cells in index.cells), default=0)
    wide = [
        np.pad(cells.arms, ((0, 0), (0, 0), (0, arms - cells.arms.shape[2])), constant_values=np.nan)
        for cells in index.cells
    ]
    cells = {
        "cells_xy": np.concatenate([cells.xy for cells in index.cells], axis=1),
        "cells_visible": np.concatenate([cells.visible for cells in index.cells], axis=1),
        "cells_arms": np.concatenate(wide, axis=1),
    }
    return (
        cells
        | {f"sights_{name}": getattr(index.sights, name) for name in _SIGHTS}
        | {name: getattr(index, name) for name in _PAIRS}
    )


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
        """Whether all types together have at most ``FEW_LEFT`` matches of a feature and a free, like datum."""
        counts = accumulate(int(index.allowed(left).sum()) for index in self.models.values())
        return all(count <= FEW_LEFT for count in counts)

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
    hidden_of: Callable[[Hypothesis], Mask] = nothing_hidden,
    seen: Callable[[Found], None] = lambda _: None,
) -> dict[str, Found]:
    """The hypotheses of all types, by type, that some data of Γ suggest, with their log-likelihood ratios, best first.

    ``hidden_of`` tells (F,) which features of a hypothesis accepted objects hide; ``seen`` is told each type's as soon
    as they are there, that of the best proposal first.
    """
    poses: dict[int, list[Floats]] = {}
    for proposal in search.proposals(data):
        poses.setdefault(proposal.kind, []).append(proposal.pose)
    result: dict[str, Found] = {index.object_type.name: [] for index in search.index.indices}
    for kind, some in poses.items():
        index = search.index.indices[kind]
        result[index.object_type.name] = verified(index, some, data, kb, hidden_of, search.asked.check)
        seen(result[index.object_type.name])
    return result
