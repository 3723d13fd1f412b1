"""What a deadline left undone of an interpretation: the search, or the weighing of worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from plogic.facts.document import Marks

Stopped = Literal["", "search", "worlds"]
"""What a deadline came in, '' where it came in nothing (``plogic.scene.readings.unfinished``)."""
SEARCH: Stopped = "search"
WORLDS: Stopped = "worlds"


def stopped_in(document: Marks) -> Stopped:
    """What was stopped, '' in a finished interpretation; one that does not say it may lack anything."""
    return document.get("stopped", SEARCH) or SEARCH if document.get("unfinished") else ""
