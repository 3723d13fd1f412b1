"""Answers by a deadline: exact if the compiler is ready in time, else the intervals that are known by then.

The compiler works in a thread (its own process does the work); meanwhile the bounds are refined, and told more and more
rarely.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plogic.logic.answers.answer import grouped
from plogic.logic.answers.intervals import Bounds
from plogic.logic.dnnf.compiled import compiled
from plogic.logic.grounding.load import ground, request_from

if TYPE_CHECKING:
    from collections.abc import Callable

    from plogic.logic.dnnf.compiled import Compiled
    from plogic.logic.grounding.ground_program import Ground

FIRST_WAIT = 0.02
"""Seconds until intervals are told for the first time after those that follow from the ground program alone."""


@dataclass
class _Compiling:
    """A compilation in a thread: what it came to, or what it raised."""

    result: Compiled | None = None
    error: BaseException | None = None

    def start(self, found: Ground) -> threading.Thread:
        """Start it."""
        thread = threading.Thread(target=self._run, args=(found,), daemon=True)
        thread.start()
        return thread

    def _run(self, found: Ground) -> None:
        try:
            self.result = compiled(found)
        except BaseException as error:  # noqa: BLE001 - raised again where it is waited for
            self.error = error


def answers_by(document: dict[str, Any], tell: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """The exact reply to a request; ``tell`` gets replies with intervals on the way: ``{"answers": [[[goal, low, high], ...]], "partial"}``.

    A goal whose substitutions are not known yet is not told.
    """
    request = request_from(document)
    found = ground(request)

    def partly(intervals: list[tuple[float, float]]) -> None:
        tell(
            {
                "answers": [[[goal, *pair] for goal, pair in goals] for goals in grouped(request, found, intervals)],
                "partial": True,
            }
        )

    partly([(0.0, 1.0)] * len(found.asked))
    program = _meanwhile(found, partly)
    values = program.probabilities([literal for _, literal in found.asked])
    return {"answers": [[[goal, p] for goal, p in goals] for goals in grouped(request, found, values)]}


def _meanwhile(found: Ground, partly: Callable[[list[tuple[float, float]]], None]) -> Compiled:
    compiling = _Compiling()
    thread = compiling.start(found)
    bounds, wait, last = Bounds(found), FIRST_WAIT, time.monotonic()
    while thread.is_alive() and not bounds.done:
        bounds.refine()
        if time.monotonic() - last > wait:
            partly(bounds.intervals())
            wait, last = wait * 1.3, time.monotonic()
    if thread.is_alive():
        partly(bounds.intervals())
    thread.join()
    if compiling.result is None:
        raise compiling.error or RuntimeError
    return compiling.result
