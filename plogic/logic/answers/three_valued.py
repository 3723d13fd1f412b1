"""Three-valued evaluation: what is certain of a ground program when only some alternatives are decided, for many partial decisions at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Iterable

    from plogic.logic.grounding.ground_program import Ground

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]
OPEN = -1
"""An alternative that is not decided yet."""


@dataclass(frozen=True)
class _Level:
    """Gates of one kind: ``gates`` are their variables, the children of the i-th start at ``first[i]`` in ``children``."""

    conjunction: bool
    gates: Ints
    children: Ints
    first: Ints


@dataclass(frozen=True)
class Truth:
    """``owner[v]``, ``outcome[v]``: the alternative whose outcome the variable is, −1 where it is none."""

    size: int
    owner: Ints
    outcome: Ints
    constants: tuple[int, ...]
    levels: tuple[_Level, ...]

    def certain(self, decided: Ints) -> Bools:
        """``certain[literal, column]``: the literal holds whatever the open alternatives come to; ``(2 size + 1, columns)``.

        ``decided``: outcome of each alternative, or OPEN, ``(alternatives, columns)``. Negative literals count from the
        end.
        """
        certain = np.zeros((2 * self.size + 1, decided.shape[1]), dtype=bool)
        certain[0] = True
        choices = np.flatnonzero(self.owner >= 0)
        came = decided[self.owner[choices]]
        certain[choices] = came == self.outcome[choices, np.newaxis]
        certain[-choices] = (came != OPEN) & (came != self.outcome[choices, np.newaxis])
        certain[list(self.constants)] = True
        for level in self.levels:
            every, some = (level.gates, -level.gates) if level.conjunction else (-level.gates, level.gates)
            sign = 1 if level.conjunction else -1
            certain[every] = np.logical_and.reduceat(certain[sign * level.children], level.first, axis=0)
            certain[some] = np.logical_or.reduceat(certain[-sign * level.children], level.first, axis=0)
        return certain


def truth_of(ground: Ground) -> Truth:
    """The ground program, its gates in levels above their children."""
    owner = np.full(ground.size + 1, -1, dtype=np.int64)
    outcome = np.full(ground.size + 1, -1, dtype=np.int64)
    for i, alternative in enumerate(ground.alternatives):
        owner[list(alternative.variables)] = i
        outcome[list(alternative.variables)] = range(len(alternative.variables))
    depth = [0] * (ground.size + 1)
    groups: dict[tuple[int, bool], list[tuple[int, tuple[int, ...]]]] = {}
    constants = []
    for variable, gate in ground.gates.items():
        children = gate.folded()
        if not isinstance(children, tuple):
            constants.append(-variable if children is None else variable)
            continue
        depth[variable] = 1 + max(depth[abs(child)] for child in children)
        groups.setdefault((depth[variable], gate.kind == "and"), []).append((variable, children))
    levels = tuple(_level(conjunction, groups[level, conjunction]) for level, conjunction in sorted(groups))
    return Truth(ground.size, owner, outcome, tuple(constants), levels)


def _level(conjunction: bool, gates: list[tuple[int, tuple[int, ...]]]) -> _Level:  # noqa: FBT001 - a kind of gate
    counts = [len(children) for _, children in gates]
    flat = np.fromiter((child for _, children in gates for child in children), dtype=np.int64)
    first = np.concatenate(([0], np.cumsum(counts)[:-1])).astype(np.int64)
    return _Level(conjunction, np.array([variable for variable, _ in gates], dtype=np.int64), flat, first)


def columns(vectors: Iterable[tuple[int, ...]], alternatives: int) -> Ints:
    """Partial decisions, prefixes of the alternatives, as columns."""
    prefixes = list(vectors)
    decided = np.full((alternatives, len(prefixes)), OPEN, dtype=np.int64)
    for column, prefix in enumerate(prefixes):
        decided[: len(prefix), column] = prefix
    return decided
