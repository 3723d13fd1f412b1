"""The search for one type after another, in which copies of this process share where it may have some.

* ``searched(search, indices, 2)``: what ``search`` finds of each index, in their order
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from plogic.base.forked import each
from plogic.facts.hypothesis import Hypothesis
from plogic.match.learned.learned_index import LearnedIndex

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Sequence

    from plogic.match.gamma.data import Data
    from plogic.match.indices import Index

    Found: TypeAlias = list[tuple[float, Hypothesis]]

Kind = TypeVar("Kind", bound="Index")
_SAID = tuple(field.name for field in fields(Hypothesis) if field.name != "object_type")


def searched(search: Callable[[Kind], Found], indices: Sequence[Kind], data: Data, processes: int) -> Generator[Found]:
    """What ``search`` finds of each index in ``data``, in their order.

    What a copy finds comes back without the type, which is large, and here already. What all types ask of Γ is found
    before copies are made. Without learned types there are none: to copy the process takes as long as to find a type
    written by hand.
    """
    lexicons = {id(index.lexicon): index.lexicon for index in indices if isinstance(index, LearnedIndex)}
    processes = processes if lexicons else 1
    if processes > 1:
        for lexicon in lexicons.values():
            lexicon.ask(data)

    def said(index: Kind) -> list[tuple[float, list[Any]]]:
        return [(ratio, [getattr(posed, name) for name in _SAID]) for ratio, posed in search(index)]

    with closing(each(said, indices, processes)) as answers:
        for index, answer in zip(indices, answers, strict=True):
            yield [(ratio, Hypothesis(index.object_type, *arrays)) for ratio, arrays in answer]


def make_ready(indices: Iterable[Index]) -> None:
    """Now, all that indices of learned types make when they are first asked for it: what a copy makes is lost with it."""
    for index in indices:
        for name, made in vars(type(index)).items():
            if isinstance(made, cached_property) and isinstance(index, LearnedIndex):
                getattr(index, name)
