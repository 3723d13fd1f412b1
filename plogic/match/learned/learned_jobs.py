"""Many learned types searched for by this process and copies of it.

What a copy finds comes back without the type, which is large, and here already. What all types ask of Γ is found before
copies are made.
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import fields
from typing import TYPE_CHECKING, Any, TypeVar

from plogic.base.jobs import each
from plogic.facts.hypothesis import Hypothesis

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Sequence

    from plogic.match.gamma.data import Data
    from plogic.match.judged.type_models import Found
    from plogic.match.learned.learned_models import LearnedIndex


def ask(indices: Iterable[LearnedIndex], data: Data) -> None:
    """Find what all types ask of Γ, before copies of this process are made."""
    for lexicon in {id(index.lexicon): index.lexicon for index in indices}.values():
        lexicon.ask(data)


More = TypeVar("More")
_SAID = tuple(field.name for field in fields(Hypothesis) if field.name != "known_type")


def searched(
    search: Callable[[LearnedIndex], tuple[Found, More]], indices: Sequence[LearnedIndex], data: Data, processes: int
) -> Generator[tuple[Found, More]]:
    """The hypotheses that a search finds of each index in ``data``, in their order; and what else it comes to."""
    if processes > 1:
        ask(indices, data)

    def said(index: LearnedIndex) -> tuple[list[tuple[float, list[Any]]], More]:
        found, more = search(index)
        return [(ratio, [getattr(posed, name) for name in _SAID]) for ratio, posed in found], more

    with closing(each(said, indices, processes)) as answers:
        for index, (answer, more) in zip(indices, answers, strict=True):
            found = [
                (ratio, Hypothesis(known_type=index.object_type, **dict(zip(_SAID, arrays, strict=True))))
                for ratio, arrays in answer
            ]
            yield found, more
