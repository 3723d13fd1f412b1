"""Which way a program is counted: the cheapest by estimates that cost little and depend on nothing but the program.

1. Diagrams, of few choices and up to few nodes: the quickest way of small programs, which need no numpy then. Of gates
   with many children up to more nodes, for tables take seconds to plan there: as ``findall`` makes them, of 14 choices
   more than five minutes, where diagrams take ten seconds.
2. No cycle: tables, where they are small.
3. Diagrams, up to a number of nodes; of a program with cycles up to a larger one, since it need not be unrolled.
4. Larger tables.
5. A circuit.

``plogic bench programs`` shows what this comes to beside stock ProbLog.
"""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from plogic.base.errors import InconsistentError
from plogic.logic.answers.by_diagrams import WIDE, Diagrams, GiveUpError
from plogic.logic.dnnf.cnf import IMPOSSIBLE, propagated
from plogic.logic.grounding.load import ground

if TYPE_CHECKING:
    from plogic.logic.dnnf.cnf import Propagated
    from plogic.logic.grounding.ground_program import Ground
    from plogic.logic.grounding.load import Request

SMALL, LARGE = 20.0, 26.0
"""Bits: cells of all tables together, some tens of milliseconds, and some seconds."""
CHOICES, FIRST, FEW, MANY = 100, 5_000, 100_000, 2_000_000
"""Alternatives up to which diagrams are tried first; nodes of diagrams: milliseconds, tenths of a second, and some
seconds."""


def counted(request: Request) -> tuple[Ground, list[float]]:
    """The ground program of a request, and P(query | evidence) of each of its queries.

    Raises ProgramError, InconsistentError, LimitError.
    """
    found = ground(request, cyclic=True)
    if found.cyclic:
        with suppress(GiveUpError):
            return found, _by_diagrams(found, _known(found), MANY)
        found = ground(request)
    return found, probabilities(found)


def probabilities(found: Ground) -> list[float]:
    """P(query | evidence) of each query of a program without cycles; raises InconsistentError, LimitError."""
    known = _known(found)
    wide = max((len(gate.children) for gate in found.gates.values()), default=0) > WIDE
    few = len(found.alternatives) <= CHOICES
    if wide or few:
        with suppress(GiveUpError):
            return _by_diagrams(found, known, FIRST if not wide else MANY if few else FEW)
    from plogic.logic.answers.by_tables import tables_of

    asked = [literal for _, literal in found.asked]
    tables = tables_of(found, known, LARGE)
    if tables is not None and tables.bits <= SMALL:
        return tables.probabilities(asked)
    with suppress(GiveUpError):
        return _by_diagrams(found, known, FEW)
    if tables is not None:
        return tables.probabilities(asked)
    from plogic.logic.dnnf.compiled import compiled

    return compiled(found, known).probabilities(asked)


def _known(found: Ground) -> Propagated:
    known = propagated(found)
    if known is None:
        raise InconsistentError(IMPOSSIBLE)
    return known


def _by_diagrams(found: Ground, known: Propagated, most: int) -> list[float]:
    return Diagrams(found, known, most).probabilities([literal for _, literal in found.asked])
