"""Beliefs of a graph that changes: only the connected pieces whose content is new are solved.

A piece is known by its content (cards and tables, in its own numbering), not by its place: a piece that comes back, or
another one just like it, is not solved again. What is remembered is what would be found, so the answers are the bytes
that ``marginals.beliefs`` gives.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

from plogic.base.clock import Clock
from plogic.inference.bounded import bounded
from plogic.inference.exact import small
from plogic.inference.marginals import WIDTH, Beliefs, assembled
from plogic.inference.parts import split

if TYPE_CHECKING:
    from plogic.inference.conditioning import Interval
    from plogic.inference.graph import FactorGraph
    from plogic.inference.parts import Part

    Key = tuple[tuple[int, ...], tuple[tuple[int, ...], ...], tuple[bytes, ...], float]

PIECES = 4096  # remembered at most; the one not asked for the longest goes first


class Remembered:
    """``beliefs`` like the function of that name; ``solved`` counts the pieces that it had to solve, ``asked`` all."""

    def __init__(self, pieces: int = PIECES) -> None:
        self.solved = 0
        self.asked = 0
        self._pieces = pieces
        self._known: OrderedDict[Key, Interval] = OrderedDict()

    def beliefs(self, graph: FactorGraph, *, width: float = WIDTH, seconds: float | None = None) -> Beliefs:
        """See ``plogic.inference.marginals.beliefs``; an interval that a deadline left is not remembered."""
        log_z, parts = split(graph)
        clock = Clock(seconds)
        keys = [_key(part, width) for part in parts]
        new = [i for i, key in enumerate(keys) if key not in self._known]
        fresh: dict[Key, Interval] = {}
        for done, i in enumerate(sorted(new, key=lambda i: not small(parts[i], width))):
            if keys[i] not in fresh:
                easy = small(parts[i], width)
                fresh[keys[i]] = bounded(parts[i], width, clock if easy else clock.share(len(new) - done))
        self.asked += len(parts)
        self.solved += len(fresh)
        result = assembled(
            graph.cards, log_z, parts, [fresh[key] if key in fresh else self._known[key] for key in keys]
        )
        self._remember(keys, fresh)
        return result

    def _remember(self, keys: list[Key], fresh: dict[Key, Interval]) -> None:
        for key in keys:
            if key in self._known:
                self._known.move_to_end(key)
            elif fresh[key].low is fresh[key].high:
                self._known[key] = fresh[key]
        while len(self._known) > self._pieces:
            self._known.popitem(last=False)


def _key(part: Part, width: float) -> Key:
    return (
        part.cards,
        tuple([scope for scope, _ in part.tables]),
        tuple([table.tobytes() for _, table in part.tables]),
        width,
    )
