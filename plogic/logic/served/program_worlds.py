"""The ranked possible worlds of any program, in a process of its own (``plogic.logic.answers.state_ranking`` answers).

* ``program_worlds(Text("0.3::a. 0.6::b."), 3)``: a ``ProgramRanking`` of three ``ProgramWorld``s
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from plogic.logic.safety.atoms import Names
from plogic.logic.served.engine import Limits, Text, ask, ask_until, request_of


@dataclass(frozen=True)
class ProgramWorld:
    r"""The worlds in which ``holds`` are the query atoms that are true, taken together.

    ``choices``: the most probable total choice among them, of the choices that matter: ``("a", "\\+b",
    "colour(red)")``.
    """

    probability: float
    holds: tuple[str, ...]
    choices: tuple[str, ...]


@dataclass(frozen=True)
class ProgramRanking:
    """``unlisted``: an interval that contains the probability of all worlds that are not listed.

    ``log_evidence``: ln P(evidence), None if it is not known yet; ``complete``: as many worlds as were asked for are
    listed, or all that there are.
    """

    worlds: tuple[ProgramWorld, ...]
    unlisted: tuple[float, float]
    log_evidence: float | None
    complete: bool


def program_worlds(
    text: Text,
    n: int = 10,
    *,
    given: Sequence[str] = (),
    goals: Sequence[str] = (),
    limits: Limits | None = None,
    seconds: float | None = None,
    names: Names | None = None,
) -> ProgramRanking:
    """The ``n`` most probable worlds given the program's evidence and ``given``, non-increasing.

    Worlds are distinguished by the truth of the ``goals``' instances; without goals, of the program's own query/1; of a
    program that asks nothing, of all atoms that it gives a probability. Ties (to a relative 1e-11) are in the order in
    which atoms are asked: a world in which an earlier one holds comes first (among the first thousand of one tie). With
    ``seconds``, the worlds that are known by then. Raises ProgramError, InconsistentError, LimitError.
    """
    request = {**request_of([text], goals, given, names), "task": "worlds", "number": n}
    if seconds is None:
        return _ranking(ask(request, limits or Limits()))
    reply = ask_until({**request, "anytime": True}, limits or Limits(), seconds)
    return ProgramRanking((), (1.0, 1.0), None, complete=False) if reply is None else _ranking(reply)


def _ranking(reply: dict[str, Any]) -> ProgramRanking:
    worlds = tuple(ProgramWorld(row["p"], tuple(row["holds"]), tuple(row["choices"])) for row in reply["worlds"])
    unlisted = 0.0 if reply.get("all") else max(0.0, 1.0 - math.fsum(world.probability for world in worlds))
    return ProgramRanking(worlds, (unlisted, unlisted), reply["log_evidence"], not reply.get("partial", False))
