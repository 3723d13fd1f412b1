"""ProbLog's errors as ours: what is wrong, in which file, line and column."""

from __future__ import annotations

from typing import Any, NoReturn

from problog.engine import NonGroundProbabilisticClause, UnknownClause
from problog.errors import InconsistentEvidenceError, NonGroundQuery, ProbLogError
from problog.eval_nodes import NegativeCycle

from plogic.errors import (
    InconsistentError,
    NegativeCycleError,
    NonGroundError,
    ProgramError,
    UnknownPredicateError,
    UnsafeProgramError,
)
from plogic.safety.engine import RefusedError

KINDS: tuple[tuple[type[ProbLogError], type[ProgramError], str], ...] = (
    (RefusedError, UnsafeProgramError, ""),
    (UnknownClause, UnknownPredicateError, ""),
    (NegativeCycle, NegativeCycleError, "a negation depends on itself (negative cycle)"),
    (NonGroundProbabilisticClause, NonGroundError, "a probabilistic clause keeps a variable that its body does not bind"),
    (NonGroundQuery, NonGroundError, "the goal keeps a variable that nothing binds"),
)


def told(error: ProbLogError, files: list[str]) -> NoReturn:
    """ProbLog's error as ours, with the place that it tells."""
    if isinstance(error, InconsistentEvidenceError):
        raise InconsistentError("no world satisfies the evidence: its probability is 0") from None
    place: dict[str, Any] = {"file": files[0]}
    if isinstance(error.location, tuple) and len(error.location) == 3:
        file, line, column = error.location
        place = {"file": file or files[0], "line": line, "column": column}
    for problem, ours, reason in KINDS:
        if isinstance(error, problem):
            raise ours(reason or error.base_message, **place) from None
    raise ProgramError(error.base_message, **place) from None
