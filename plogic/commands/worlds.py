"""``plogic worlds``: the ranked possible worlds of an interpretation or of any program."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence


def worlds_command(
    source: str, number: int, given: Sequence[str], options: dict[str, Any], *, as_json: bool
) -> tuple[str, int]:
    """The ranked worlds, taken anew from the situation, so that any number of them can be had; exit 3 where the deadline was reached.

    ``options``: reading, deadline, trust.
    """
    from plogic import tables
    from plogic.commands.printing import text_of_table
    from plogic.interpretation import read_interpretation, situation_of
    from plogic.worlds import ranked_worlds

    document = read_interpretation(source)
    document = document if options["reading"] is None else {**document, "reading": options["reading"]}
    ranking = ranked_worlds(situation_of(document), number)
    rows = [{"probability": w.probability, "present": list(w.present), "causes": w.causes} for w in ranking.worlds]
    answer = {
        "format": "worlds/1",
        "reading": document["reading"],
        "worlds": rows,
        "unlisted_mass": list(ranking.unlisted),
    }
    if as_json:
        return json.dumps(answer), 0
    return text_of_table(tables.worlds({**document, "worlds": rows, "unlisted_mass": list(ranking.unlisted)}, number)), 0
