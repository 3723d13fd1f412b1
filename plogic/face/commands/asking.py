"""``plogic worlds``, ``query``, ``explain`` and ``shell``.

The verbs are those of Python (``plogic.face.python``); here their results become text and JSON.
"""

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from shlex import quote
from typing import TYPE_CHECKING

from plogic.base.clock import Clock
from plogic.base.errors import InputError, LimitError
from plogic.face.python.asking import EXPLANATIONS, Asked, Program, opened
from plogic.face.session.minds import ranked
from plogic.face.session.results import Answers, World, Worlds
from plogic.face.shown.figures import chance, interval
from plogic.face.shown.options import Asking
from plogic.face.shown.printed import say
from plogic.facts.caveats import caveats
from plogic.facts.document import WorldRow
from plogic.facts.situation import Reading
from plogic.facts.spatial import exclusion_lines, exclusions
from plogic.logic.safety.allowlist import TRUSTED
from plogic.logic.safety.atoms import quoted
from plogic.logic.safety.notes import notes, notes_on_goals
from plogic.logic.served.engine import TOO_DEEP
from plogic.logic.served.program_worlds import ProgramRanking
from plogic.run.sources import program_text_of
from plogic.scene import document as rows
from plogic.scene.asking.query import unknown_names
from plogic.scene.readings.unfinished import flagged, marks, with_notice

if TYPE_CHECKING:
    from plogic.face.python.interpretation import Interpretation
    from plogic.scene.worlds.ranked_worlds import Ranking

LATE = 3
"""Exit status where a deadline was reached."""
MOST_CHOICES = 6
"""Choices of a world that its line in the table shows; ``--json`` has them all."""
NOTHING = "The deadline was reached before any answer was known."
WITHIN = "The deadline was reached: each interval contains the exact probability; further answers may not be known yet."
MIDDLES = "The deadline was reached: probabilities are the middles of their intervals."
MORE = "The deadline was reached: more worlds could be listed with more time."


def worlds_command(
    source: str, number: int, given: Sequence[str], options: Asking, *, as_json: bool
) -> tuple[str, int]:
    """The ranked worlds, taken anew, so that any number of them can be had; exit 3 where the deadline was reached.

    Raises InputError where ``poses`` are asked of a program, or as JSON.
    """
    asked = _opened(source, options, given)
    if options.poses and (as_json or isinstance(asked, Program)):
        has = "is CSV; as JSON they are in the interpretation" if as_json else "a program has none; give INTERPRETATION"
        raise InputError(f"--poses: {has}")
    found, ranking = ranked(asked.beside(options.rules), number, given, asked.limits, options.deadline)
    if isinstance(asked, Program):
        return _of_text(found, ranking, None, as_json=as_json)
    from plogic.face.python.interpretation import Interpretation

    assert isinstance(asked, Interpretation)  # noqa: S101 - what is no program is one
    if options.poses:
        from plogic.face.commands.pose_table import pose_table

        if not found.complete:
            say(MORE)
        return pose_table(asked.document, found.worlds), 0 if found.complete else LATE
    if isinstance(ranking, ProgramRanking):
        return _of_text(found, ranking, asked.reading, as_json=as_json)
    return _of_graph(asked, found, ranking, number, as_json=as_json)


def _opened(source: str, options: Asking, given: Sequence[str], asked: Sequence[str | None] = ()) -> Asked:
    """What the file holds; of a plain program, rules and goals it is said what they surely do not mean (``notes``)."""
    found = opened(source, options.reading, trust=options.trust, withhold=options.withhold)
    called = [f"goal {i}" if len(asked) > 1 else "goal" for i in range(1, len(asked) + 1)]
    named = {name: goal for name, goal in zip(called, asked, strict=True) if goal is not None}
    named |= {f"given {i}" if len(given) > 1 else "given": goal for i, goal in enumerate(given, 1)}
    goals = list(named.values())
    if options.trust and isinstance(found, Program):
        say(TRUSTED)
    lines = notes(found.text, found.file, goals) if isinstance(found, Program) else []
    if options.rules is not None and options.rules != "-":
        lines += notes(program_text_of(options.rules), options.rules, goals, added=True)
    for line in (*lines, *notes_on_goals(named)):
        say(line)
    return found


def _of_graph(
    asked: "Interpretation", found: Worlds, ranking: "Ranking", number: int, *, as_json: bool
) -> tuple[str, int]:
    from plogic.scene.worlds.predictions import doubts, said, weighed

    exact = ranking.log_evidence_interval[0] == ranking.log_evidence_interval[1]
    listed = [_row(world, bounded=not exact or bool(found.stopped)) for world in found.worlds]
    answer: rows.SceneWorlds = {
        "format": "worlds/1",
        "reading": asked.reading,
        "worlds": listed,
        "unlisted_mass": list(found.unlisted),
        "exclusions": exclusions(asked.document),
    }

    def text() -> str:
        from plogic.face.shown import tables

        table = tables.worlds({**asked.document, "worlds": listed, "unlisted_mass": list(found.unlisted)}, number)
        lines = "".join(
            [
                tables.text_of_table(table),
                *(f"{line}\n" for line in (*exclusion_lines(asked.document), *caveats(asked.document))),
            ]
        )
        doubtful = [said(doubt) for doubt in weighed(doubts(asked.subject), asked.document)]
        return "\n".join([lines.rstrip(), "", *doubtful, ""]) if doubtful else lines

    return _told(answer, found, text, MORE if exact else MIDDLES, as_json=as_json)


def _row(world: World, *, bounded: bool) -> WorldRow:
    row: WorldRow = {
        "probability": world.probability,
        "present": list(world.present),
        "causes": dict(world.causes or {}),
    }
    if world.support is not None:
        row = {**row, "support": world.support, "stances": world.stances or {}}
    return {**row, "interval": list(world.interval)} if bounded else row


def _of_text(
    found: Worlds, ranking: "Ranking | ProgramRanking", reading: Reading | None, *, as_json: bool
) -> tuple[str, int]:
    """The worlds by a program text: of a scene where causes are not told."""
    answer: rows.ProgramWorlds = {"format": "worlds/1", "worlds": []}
    if reading is not None:
        answer = {"format": "worlds/1", "reading": reading, "worlds": []}
    answer["worlds"] = [_row_of_text(world, found) for world in found.worlds]
    flagged(answer, found.stopped)
    answer["unlisted_mass"], answer["log_evidence"] = list(found.unlisted), ranking.log_evidence
    return _told(answer, found, lambda: _table_of_text(found), MORE, as_json=as_json)


def _row_of_text(world: World, found: Worlds) -> rows.ProgramWorldRow:
    holds, choices = list(world.present), list(world.choices)
    row: rows.ProgramWorldRow = {"probability": world.probability, "true": holds, "choices": choices}
    if found.types is not None:
        row = {"probability": world.probability, "present": holds, "choices": choices}
    return {**row, "interval": list(world.interval)} if found.stopped else row


def _table_of_text(found: Worlds) -> str:
    from rich.text import Text

    from plogic.face.shown.tables import light_table, text_of_table

    bounded = bool(found.stopped) and bool(found.worlds)
    right = ["rank", "probability", *["interval"] * bounded]
    table = light_table("possible worlds", right, ["true", "most probable choices"])
    for i, world in enumerate(found.worlds, 1):
        holds = world.present if found.types is None else [f"present({quoted(name)})" for name in world.present]
        shown = ", ".join(world.choices[:MOST_CHOICES]) + (", ..." if len(world.choices) > MOST_CHOICES else "")
        table.add_row(
            str(i),
            chance(world.probability),
            *[interval(*world.interval)] * bounded,
            ", ".join(holds) or "nothing that is asked",
            shown,
        )
    if found.unlisted[1] > 0:
        table.add_row("", *[""] * bounded, interval(*found.unlisted), Text("not listed", style="dim"), "")
    return text_of_table(table)


def _told(
    document: rows.Answers | rows.SceneWorlds | rows.ProgramWorlds,
    found: Answers | Worlds,
    text: Callable[[], str],
    late: str,
    *,
    as_json: bool,
) -> tuple[str, int]:
    """A document, or its text with a line where the search or a deadline left something open; and the exit status."""
    flagged(document, found.stopped)
    if not found.complete:
        document["deadline"] = "reached"
    status = 0 if found.complete else LATE
    if as_json:
        return json.dumps(document), status
    shown = with_notice(text(), found.stopped)
    return shown if found.complete else f"{shown.rstrip()}\n{late}", status


def query_command(
    source: str, goals: Sequence[str], given: Sequence[str], options: Asking, *, as_json: bool
) -> tuple[str, int]:
    """P(goal) of an interpretation or a program; of several goals tables one after another, or JSON Lines.

    Exit 3 where the deadline was reached, answers then being intervals.
    """
    asked, clock = _opened(source, options, given, goals), Clock(options.deadline)

    def told(found: Answers, goal: str | None) -> tuple[str, int]:
        document: rows.Answers = {"format": "answers/1", "answers": []}
        if goal is not None and len(goals) > 1:
            document = {"format": "answers/1", "asked": goal, "answers": []}
        document["answers"] = [
            {"goal": a.goal, "probability": a.probability, "interval": list(a.interval)} for a in found.answers
        ]

        def text() -> str:
            from plogic.face.shown import tables

            table = tables.text_of_table(tables.answers(document))
            if not found.complete or any(a.interval[1] > 0 for a in found.answers):
                return table
            said = [] if found.answers else [_none(source, asked, goal)]
            if goal is not None:
                limits = replace(asked.limits, seconds=max(0.0, min(asked.limits.seconds, clock.left())))
                said += unknown_names(asked.beside(options.rules), goal, limits=limits)
            return "\n".join([table.rstrip(), "", *said, ""]) if said else table

        return _told(document, found, text, WITHIN if found.answers else NOTHING, as_json=as_json)

    if len(goals) < 2:
        goal = next(iter(goals), None)
        return told(asked.query(goal, given=given, rules=options.rules, deadline=options.deadline), goal)
    answered = asked.query_all(goals, given=given, rules=options.rules, deadline=options.deadline)
    each = [told(found, found.goal) for found in answered]
    return ("\n" if as_json else "\n\n").join(text.rstrip() for text, _ in each), max(status for _, status in each)


def _none(source: str, asked: Asked, goal: str | None) -> str:
    """An empty answer in words."""
    if goal is None and isinstance(asked, Program):
        told = f"{asked.file} asks nothing: it has no query/1, or none that holds"
        return f"{told}; give a goal: plogic query {quote(source)} GOAL"
    return "no answer: nothing of this form holds with positive probability"


def explain_command(
    source: str, goal: str, given: Sequence[str], number: int | None, options: Asking, *, as_json: bool
) -> str:
    """Why the goal holds, and why not, as trees down to the data.

    With a ``number`` of None the presence of an interpretation's hypothesis is summed up over its features instead.
    """
    asked = _opened(source, options, given, [goal])
    try:
        found = asked.explain(
            goal, given=given, rules=options.rules, n=EXPLANATIONS if number is None and as_json else number
        )
        if as_json:
            return json.dumps({"format": "explanation/1", **asdict(found.account), **marks(found.stopped)})
        return str(found)
    except RecursionError:
        raise LimitError(TOO_DEEP) from None


def shell_command(source: str, options: Asking, *, write: Callable[[str], None], say: Callable[[str], None]) -> int:
    """Run a session, at a terminal with a prompt, else line by line from stdin.

    The exit code is 1 where a line failed and nobody sat at a terminal.
    """
    from plogic.base.children import ending_well
    from plogic.face.python.sessions import Session

    if source == "-":
        raise InputError("-: stdin holds the lines of the session; give the interpretation or the program as a file")
    with ending_well(), Session(_opened(source, options, ()), rules=options.rules) as session:
        session.greeting()
        if sys.stdin.isatty() and sys.stdout.isatty():
            from plogic.face.session.prompt import run_prompt

            return run_prompt(session, write, say)
        from plogic.face.session.verbs import run_lines

        return run_lines(session, sys.stdin.buffer, write, say)
