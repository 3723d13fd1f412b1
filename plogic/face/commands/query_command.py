"""``plogic query``: P(goal) of an interpretation or of any program."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from plogic.face.commands.asked import LATE
from plogic.run.sources import rules_from, subject_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.face.commands.asked import Asked
    from plogic.scene.document import AnswerRow, Answers


def query_command(
    source: str, goal: str | None, given: Sequence[str], options: Asked, *, as_json: bool
) -> tuple[str, int]:
    """P(goal) of an interpretation or a program; exit 3 where the deadline was reached, answers then being intervals."""
    from plogic.face.shown import tables
    from plogic.face.shown.tables import text_of_table
    from plogic.logic.served.engine import Limits
    from plogic.scene.asking.query import answers, answers_until
    from plogic.scene.readings.unfinished import flagged, stopped_of, with_notice

    subject, deadline = subject_of(source, options.reading), options.deadline
    rules, limits = rules_from(options.rules), Limits(trust=options.trust)
    if deadline is None:
        found, exact = answers(subject, goal, given=list(given), rules=rules, limits=limits), True
    else:
        found, exact = answers_until(subject, goal, given=list(given), rules=rules, limits=limits, seconds=deadline)
    rows: list[AnswerRow] = [
        {"goal": a.goal, "probability": a.probability, "interval": list(a.interval)} for a in found
    ]
    document: Answers = {"format": "answers/1", "answers": rows}
    flagged(document, stopped_of(subject))
    if not exact:
        document["deadline"] = "reached"
    text = (
        json.dumps(document) if as_json else with_notice(text_of_table(tables.answers(document)), stopped_of(subject))
    )
    return text if exact or as_json else f"{text.rstrip()}\n{_said(rows)}", 0 if exact else LATE


def _said(rows: list[AnswerRow]) -> str:
    if not rows:
        return "The deadline was reached before any answer was known."
    return (
        "The deadline was reached: each interval contains the exact probability; further answers may not be known yet."
    )
