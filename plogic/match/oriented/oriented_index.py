"""A hand-modelled type whose data have angles, made ready for search."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.match.hand.type_index import TypeIndex, type_index
from plogic.match.oriented.oriented_match import settle

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.hand.view_cells import ViewCells


class OrientedIndex(TypeIndex):
    """A type that is matched by places and angles."""

    def settle(
        self,
        pose: NDArray[np.float64] | Hypothesis,
        data: Data,
        kb: KnowledgeBase,
        free: NDArray[np.bool_] | None = None,
        hidden: NDArray[np.bool_] | None = None,
        rounds: int = 2,
    ) -> Hypothesis:
        """The type at a pose, matched and refined on places and angles (``plogic.match.oriented.oriented_match``)."""
        return settle(self, pose, data, kb, free, hidden, rounds)


def oriented_index(object_type: ObjectType, dv: Mapping[str, float], cells: ViewCells | None = None) -> OrientedIndex:
    """Build the index of one type. ``cells``, where they are known."""
    return type_index(object_type, dv, cells, OrientedIndex)
