"""``plogic explain``: why, and why not."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from plogic.run.sources import subject_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.face.commands.asked import Asked

MOST = 5
"""Explanations of each kind, where no number is asked for."""


def explain_command(
    source: str, goal: str, given: Sequence[str], number: int | None, options: Asked, *, as_json: bool
) -> str:
    """Why the goal holds, and why not, as trees down to the data.

    With a ``number`` of None the presence of an interpretation's hypothesis is summed up over its features instead.
    """
    from dataclasses import asdict

    from plogic.base.errors import LimitError
    from plogic.face.session.account_text import account_text
    from plogic.logic.served.engine import TOO_DEEP, Limits
    from plogic.scene.asking.explanations import explain, present
    from plogic.scene.readings.unfinished import marks, stopped_of, with_notice

    subject = subject_of(source, options.reading)
    stopped = stopped_of(subject)
    if number is None and not as_json:
        summary = present(subject, goal, given=list(given))
        if summary is not None and summary.summary:
            return with_notice(account_text(summary, brief=True), stopped)
    limits = Limits(trust=options.trust)
    try:
        account = explain(subject, goal, given=list(given), most=MOST if number is None else number, limits=limits)
        told = {"format": "explanation/1", **asdict(account), **marks(stopped)}
        return json.dumps(told) if as_json else with_notice(account_text(account), stopped)
    except RecursionError:
        raise LimitError(TOO_DEEP) from None
