"""``plogic explain``: why, and why not."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from plogic.commands.sources import subject_of

if TYPE_CHECKING:
    from collections.abc import Sequence


def explain_command(
    source: str, goal: str, given: Sequence[str], number: int, options: dict[str, Any], *, as_json: bool
) -> str:
    """Why the goal holds, and why not, as trees down to the data. ``options``: reading, trust."""
    from dataclasses import asdict

    from plogic.commands.account import account_text
    from plogic.explain import explain

    account = explain(subject_of(source, options["reading"]), goal, given=list(given), most=number)
    return json.dumps({"format": "explanation/1", **asdict(account)}) if as_json else account_text(account)
