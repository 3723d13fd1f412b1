"""``plogic query``: P(goal) of an interpretation or of any program."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from plogic.commands.sources import rules_from, subject_of

if TYPE_CHECKING:
    from collections.abc import Sequence


def query_command(
    source: str, goal: str | None, given: Sequence[str], options: dict[str, Any], *, as_json: bool
) -> tuple[str, int]:
    """P(goal) of an interpretation or a program; exit 3 where the deadline was reached.

    ``options``: rules, reading, deadline, trust.
    """
    from plogic import tables
    from plogic.commands.printing import text_of_table
    from plogic.query import answers

    found = answers(subject_of(source, options["reading"]), goal, given=list(given), rules=rules_from(options["rules"]))
    rows = [{"goal": a.goal, "probability": a.probability, "interval": list(a.interval)} for a in found]
    document: dict[str, Any] = {"format": "answers/1", "answers": rows}
    return (json.dumps(document) if as_json else text_of_table(tables.answers(document))), 0
