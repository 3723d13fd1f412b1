"""What a deadline left undone of an interpretation: the search, or the weighing of worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, get_args

from plogic.base.errors import InterpretationError

if TYPE_CHECKING:
    from collections.abc import Mapping

Stopped = Literal["", "search", "worlds"]
"""What a deadline came in, '' where it came in nothing (``plogic.scene.readings.unfinished``)."""
SEARCH: Stopped = "search"
WORLDS: Stopped = "worlds"


def stopped_in(document: Mapping[str, Any]) -> Stopped:
    """What was stopped, '' in a finished interpretation; one that does not say it may lack anything. Raises InterpretationError."""
    if not document.get("unfinished"):
        return ""
    stopped: Stopped = document.get("stopped", SEARCH)
    if stopped not in get_args(Stopped):
        raise InterpretationError(f"stopped: {stopped!r:.60} should be one of {SEARCH}, {WORLDS}")
    return stopped or SEARCH
