"""A type made ready for search, whichever kind it is: written by hand, or learnt."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from plogic.search.generate import TypeIndex, type_index
from plogic.search.learnt.index import LearntIndex, learnt_index

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kb.cloud import ObjectType

Index: TypeAlias = TypeIndex | LearntIndex


def index_of(object_type: ObjectType, dv: Mapping[str, float]) -> Index:
    """The index of a type with at least one feature."""
    return learnt_index(object_type, dv) if object_type.learnt is not None else type_index(object_type, dv)
