"""The search for one learned type after another, which copies of this process share where it may have some.

* ``searched(search, indices, data, 2)``: what ``search`` finds of each index, in their order
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from plogic.base.jobs import each
from plogic.facts.hypothesis import Hypothesis

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from plogic.match.gamma.data import Data
    from plogic.match.judged.type_models import Found
    from plogic.match.learned.learned_index import LearnedIndex

_SAID = tuple(field.name for field in fields(Hypothesis) if field.name != "known_type")


def searched(
    search: Callable[[LearnedIndex], Found], indices: Sequence[LearnedIndex], data: Data, processes: int
) -> Generator[Found]:
    """The hypotheses that a search finds of each index in ``data``, in their order.

    What a copy finds comes back without the type, which is large, and here already. What all types ask of Γ is found
    before copies are made.
    """
    if processes > 1:
        for lexicon in {id(index.lexicon): index.lexicon for index in indices}.values():
            lexicon.ask(data)

    def said(index: LearnedIndex) -> list[tuple[float, list[Any]]]:
        return [(ratio, [getattr(posed, name) for name in _SAID]) for ratio, posed in search(index)]

    with closing(each(said, indices, processes)) as answers:
        for index, answer in zip(indices, answers, strict=True):
            yield [
                (ratio, Hypothesis(known_type=index.object_type, **dict(zip(_SAID, arrays, strict=True))))
                for ratio, arrays in answer
            ]
