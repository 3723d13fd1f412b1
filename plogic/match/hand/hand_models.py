"""Hand-modelled types whose data are places alone: one is searched for after another (``plogic.match.hand.generate``)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

from plogic.match.gamma.ideal_projection import project_ideal
from plogic.match.hand.generate import generate
from plogic.match.hand.type_index import type_index
from plogic.match.judged.type_models import Search, TypeModels

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
    from typing import Self

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.hand.type_index import TypeIndex
    from plogic.match.judged.type_models import Found, Given, Request, Setup


@dataclass(frozen=True, eq=False)
class HandModels(TypeModels):
    """``models``: the types by name."""

    models: Mapping[str, TypeIndex]

    @classmethod
    def of(cls, setup: Setup) -> Self:
        """Make some types ready; nothing is kept in a folder."""
        return cls({kind.name: type_index(kind, setup.dv) for kind in setup.types})

    def search(self, request: Request) -> Search:
        """The search in one Γ, by this process alone: to copy it takes as long as to find a type."""
        return HandSearch(self.models, request.kb, request.check)


@dataclass(frozen=True, eq=False)
class HandSearch(Search):
    """The search for one type after another in what is left of Γ."""

    models: Mapping[str, TypeIndex]
    kb: KnowledgeBase
    check: Callable[[], None]

    def propose(self, names: Sequence[str], left: Data, given: Given) -> Generator[Found]:
        """The hypotheses of each type, settled; what accepted objects cover is not missed."""
        covered = covered_by(given.accepted, left) if names else None
        for name in names:
            found = generate(self.models[name], left, self.kb, covered, check=self.check)
            given.seen(found)
            yield found


def covered_by(posed: Iterable[Hypothesis], data: Data) -> NDArray[np.bool_]:
    """(H, W) where the opaque ones of some objects stand in the ideal image: what is there may well be hidden."""
    mask = np.zeros((data.camera.height, data.camera.width), dtype=np.uint8)
    for some in posed:
        surface = some.object_type.surface
        if surface is not None and some.object_type.opaque:
            corners = project_ideal(some.camera_from_object[None], surface.vertices, data)[0]
            for triangle in np.rint(corners[surface.triangles]).astype(np.int32):
                cv2.fillConvexPoly(mask, triangle, 1)
    return mask.astype(bool)
