"""What a deadline left undone of an interpretation, and what is proved of its probabilities then.

* ``SEARCH``: the search was stopped, so that Δh may lack hypotheses. One more may claim what another explains, share
  its volume, hide it and so explain what it lacks, or be shown to hold in its place; poses still move, and what was
  found may be rejected. So neither a presence nor a world has a bound, in either reading: each interval is ``OPEN``.
* ``WORLDS``: the search was over and Δh is whole, but not all of its worlds were weighed: inference's own intervals
  hold.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from plogic.facts.document import HypothesisRow, Interpretation, Listed, Marks, RejectedRow
from plogic.facts.situation import SEARCH, WORLDS, Stopped
from plogic.logic.served.engine import Answer

if TYPE_CHECKING:
    from plogic.scene.worlds.ranked_worlds import Ranking

Interval = tuple[float, float]
Marked = TypeVar("Marked", bound=Marks)

OPEN = (0.0, 1.0)
"""What is known of a probability of which nothing is proved."""
REASONS = {
    SEARCH: "unfinished: the deadline came before the search was over",
    WORLDS: "unfinished: the deadline came before every world was weighed",
}
FOUND = "probabilities are of what was found by then, and with more time each may be anything in its interval"
ANEW = "the search was over, and what is told here was weighed anew"
LISTED = "the search was over, and each probability in the file is the middle of an interval that contains it"


def marks(stopped: Stopped) -> Marks:
    """The keys of a document that answers from an interpretation; none of a finished one."""
    return {"unfinished": True, "stopped": stopped} if stopped else {}


def flagged(document: Marked, stopped: Stopped) -> Marked:
    """The document itself, with the keys of ``marks``."""
    if stopped:
        document["unfinished"], document["stopped"] = True, stopped
    return document


def notice(stopped: Stopped, *, anew: bool = True) -> str:
    """The line that says so, '' of what is finished.

    ``anew``: of what was taken from Δh, and not from the listed worlds.
    """
    return f"{REASONS[stopped]}; {FOUND if stopped == SEARCH else ANEW if anew else LISTED}" if stopped else ""


def with_notice(text: str, stopped: Stopped, *, anew: bool = True) -> str:
    """A text with that line below."""
    return f"{text.rstrip()}\n{notice(stopped, anew=anew)}" if stopped else text


def proved(stopped: Stopped, interval: Interval) -> Interval:
    """What of an interval that Δh has is proved of the finished interpretation."""
    return OPEN if stopped == SEARCH else interval


def opened(stopped: Stopped, answers: Iterable[Answer]) -> list[Answer]:
    """Answers from Δh with what is proved of them."""
    return [replace(answer, interval=proved(stopped, answer.interval)) for answer in answers]


def marked(document: Interpretation, ranking: "Ranking", stopped: Stopped) -> Interpretation:
    """The interpretation, unfinished: with each probability an ``interval`` that contains what more time would give."""
    if stopped != SEARCH:
        return _bounded({**document, **marks(stopped)}, ranking)
    return {  # the rejected too: what was rejected for want of time, or beside what will not stay, may yet be accepted
        **document,
        **marks(stopped),
        "hypotheses": [_within(h, OPEN) for h in document["hypotheses"]],
        "worlds": [{**world, "interval": list(OPEN)} for world in document["worlds"]],
        "relations": [{**row, "interval": list(OPEN)} for row in document["relations"]],
        "unlisted_mass": list(OPEN),
    }


def _within(h: HypothesisRow | RejectedRow, bounds: Interval) -> HypothesisRow | RejectedRow:
    bounded = h.copy()
    bounded["interval"] = list(bounds)
    return bounded


def _bounded(document: Interpretation, ranking: "Ranking") -> Interpretation:
    """Where no world is known to be possible the program may be smoothed (§8, trap c), and nothing is proved."""
    possible = ranking.log_evidence_interval[0] > float("-inf")
    known = {h: bounds if possible else OPEN for h, bounds in ranking.intervals.items()}
    rows = zip(document["worlds"], ranking.worlds, strict=True)
    return {
        **document,
        "hypotheses": [_within(h, known[h["id"]]) if h["id"] in known else h for h in document["hypotheses"]],
        "worlds": [{**row, "interval": list(world.interval)} for row, world in rows],
    }


def unlisted_beyond(document: Listed, number: int) -> list[float]:
    """The interval of the mass that is not in the first ``number`` of the listed worlds."""
    rest, unlisted = document.get("worlds", [])[number:], document.get("unlisted_mass") or [0.0, 0.0]
    if not any("interval" in world for world in rest):
        mass = sum(world["probability"] for world in rest)
        return [bound + mass for bound in unlisted]
    bounds = [world.get("interval") or [world["probability"]] * 2 for world in rest]
    return [min(unlisted[end] + sum(b[end] for b in bounds), 1.0) for end in (0, 1)]
