"""``worlds``, ``query``, ``explain``, ``program``, ``report``: what is asked of an interpretation or of any program."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plogic.commands.sources import is_program, program_text_of, situation_from

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from plogic.engine import Text
    from plogic.query import Subject
    from plogic.situation import Reading


def worlds_command(interpretation: str, number: int, *, reading: Reading | None = None, as_json: bool) -> str:
    """The ranked worlds, taken anew from the situation, so that any number of them can be had."""
    from plogic import tables
    from plogic.commands.printing import text_of_table
    from plogic.interpretation import read_interpretation, situation_of
    from plogic.worlds import ranked_worlds

    document = read_interpretation(interpretation)
    document = document if reading is None else {**document, "reading": reading}
    ranking = ranked_worlds(situation_of(document), number)
    rows = [{"probability": w.probability, "present": list(w.present), "causes": w.causes} for w in ranking.worlds]
    answer = {
        "format": "worlds/1",
        "reading": document["reading"],
        "worlds": rows,
        "unlisted_mass": list(ranking.unlisted),
    }
    if as_json:
        return json.dumps(answer)
    return text_of_table(tables.worlds({**document, "worlds": rows, "unlisted_mass": list(ranking.unlisted)}, number))


def query_command(
    source: str, goal: str | None, given: Sequence[str], rules: str | None, *, reading: Reading | None = None, as_json: bool
) -> str:
    """P(goal) of an interpretation or a program."""
    from plogic import tables
    from plogic.commands.printing import text_of_table
    from plogic.query import answers

    found = answers(_source(source, reading), goal, given=list(given), rules=_rules(rules))
    rows = [{"goal": a.goal, "probability": a.probability, "interval": list(a.interval)} for a in found]
    document: dict[str, Any] = {"format": "answers/1", "answers": rows}
    return json.dumps(document) if as_json else text_of_table(tables.answers(document))


def explain_command(
    source: str, goal: str, given: Sequence[str], number: int, *, reading: Reading | None = None, as_json: bool
) -> str:
    """Why the goal holds, and why not, as trees down to the data."""
    from dataclasses import asdict

    from plogic.commands.account import account_text
    from plogic.explain import explain

    account = explain(_source(source, reading), goal, given=list(given), most=number)
    return json.dumps({"format": "explanation/1", **asdict(account)}) if as_json else account_text(account)


def program_command(interpretation: str, reading: Reading | None, *, as_json: bool = False) -> str:
    """The ProbLog text with its queries."""
    from plogic.program.text import program_text, query_lines

    situation = situation_from(interpretation, reading)
    text = program_text(situation) + "\n" + query_lines(situation)
    return json.dumps({"format": "program/1", "reading": situation.reading, "program": text}) if as_json else text


def report_command(interpretation: str, out: str, *, say: Callable[[str], None], write: Callable[[str], None]) -> None:
    """Write the page; `-` is stdout."""
    from plogic.interpretation import read_interpretation
    from plogic.report.page import page
    from sensing.whole_files import write_whole

    text = page(read_interpretation(interpretation))
    if out == "-":
        write(text)
        return
    write_whole(Path(out), text.encode())
    say(f"wrote {out}")


def _source(source: str, reading: Reading | None) -> Subject:
    """A situation, or program text, as ``answers`` and ``explain`` take them."""
    from plogic.engine import Text

    return Text(program_text_of(source), source) if is_program(source) else situation_from(source, reading)


def _rules(path: str | None) -> Text | None:
    from plogic.engine import Text

    return None if path is None else Text(program_text_of(path), path)
