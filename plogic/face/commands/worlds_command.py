"""``plogic worlds``: the ranked possible worlds of an interpretation or of any program."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from typing import TYPE_CHECKING

from plogic.base.errors import OutsideError
from plogic.face.commands.asked import LATE
from plogic.run.sources import is_program, program_text_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.face.commands.asked import Asked
    from plogic.facts.document import Interpretation, WorldRow
    from plogic.facts.fact_rows import Interval
    from plogic.facts.situation import Situation, Stopped
    from plogic.logic.served.engine import ProgramRanking
    from plogic.scene.document import ProgramWorldRow, ProgramWorlds, SceneWorlds
    from plogic.scene.worlds.ranked_worlds import Ranking, World

MOST_CHOICES = 6
"""Choices of a world that its line in the table shows; ``--json`` has them all."""


def worlds_command(source: str, number: int, given: Sequence[str], options: Asked, *, as_json: bool) -> tuple[str, int]:
    """The ranked worlds, taken anew, so that any number of them can be had; exit 3 where the deadline was reached."""
    if is_program(source):
        return _of_program(source, number, given, options, as_json=as_json)
    from plogic.facts.interpretation import read_interpretation, situation_of

    document = read_interpretation(source)
    if options.reading is not None:
        document = {**document, "reading": options.reading}
    situation = situation_of(document)
    try:
        return _of_scene(document, situation, number, given, options.deadline, as_json=as_json)
    except OutsideError:
        return _of_scene_text(document, situation, number, given, options.deadline, as_json=as_json)


def _of_program(source: str, number: int, given: Sequence[str], options: Asked, *, as_json: bool) -> tuple[str, int]:
    from plogic.logic.served.engine import Limits, Text, program_worlds

    limits = Limits(trust=bool(options.trust))
    text = Text(program_text_of(source), source)
    ranking = program_worlds(text, number, given=given, limits=limits, seconds=options.deadline)
    rows: list[ProgramWorldRow] = [
        {"probability": w.probability, "true": list(w.holds), "choices": list(w.choices)} for w in ranking.worlds
    ]
    return _told(ranking, {"format": "worlds/1", "worlds": rows}, as_json=as_json)


def _told(ranking: ProgramRanking, answer: ProgramWorlds, stopped: Stopped = "", *, as_json: bool) -> tuple[str, int]:
    from plogic.scene.readings.unfinished import with_notice

    answer = {**answer, "unlisted_mass": list(ranking.unlisted), "log_evidence": ranking.log_evidence}
    status = 0 if ranking.complete else LATE
    if as_json:
        return json.dumps(answer if ranking.complete else {**answer, "deadline": "reached"}), status
    text_out = with_notice(_table_of_program(ranking, [world.get("interval") for world in answer["worlds"]]), stopped)
    return (
        text_out
        if ranking.complete
        else f"{text_out.rstrip()}\nThe deadline was reached: more worlds could be listed with more time.",
        status,
    )


def _table_of_program(ranking: ProgramRanking, within: Sequence[Interval | None]) -> str:
    from rich import box
    from rich.table import Table
    from rich.text import Text as Cell

    from plogic.face.shown import tables
    from plogic.face.shown.tables import text_of_table

    table = Table(title="possible worlds", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("rank", justify="right")
    table.add_column("probability", justify="right")
    bounded = any(within)
    if bounded:
        table.add_column("interval", justify="right")
    table.add_column("true")
    table.add_column("most probable choices")
    for i, (world, bounds) in enumerate(zip(ranking.worlds, within, strict=True), 1):
        between = [tables.interval(*bounds)] if bounds else []
        shown = ", ".join(world.choices[:MOST_CHOICES]) + (", ..." if len(world.choices) > MOST_CHOICES else "")
        table.add_row(
            str(i),
            tables.chance(world.probability),
            *between,
            Cell(", ".join(world.holds) or "nothing that is asked"),
            Cell(shown),
        )
    if ranking.unlisted[1] > 0:
        table.add_row("", *[""] * bounded, tables.interval(*ranking.unlisted), Cell("not listed", style="dim"), "")
    return text_of_table(table)


def _of_scene_text(
    document: Interpretation,
    situation: Situation,
    number: int,
    given: Sequence[str],
    seconds: float | None,
    *,
    as_json: bool,
) -> tuple[str, int]:
    """By the program text, where the evidence speaks of choices that the graph has summed out: then those are told, and no causes."""
    from plogic.logic.safety.atoms import quoted
    from plogic.logic.served.engine import program_worlds
    from plogic.scene.asking.query import subject_text
    from plogic.scene.readings.unfinished import flagged, proved

    text, names = subject_text(situation)
    ranking = program_worlds(text, number, given=given, goals=("present(H)",), seconds=seconds, names=names)
    ids = {f"present({quoted(h.id)})": h.id for h in situation.hypotheses}
    stopped = situation.stopped
    rows: list[ProgramWorldRow] = [
        {"probability": w.probability, "present": [ids[goal] for goal in w.holds], "choices": list(w.choices)}
        for w in ranking.worlds
    ]
    if stopped:
        rows = [{**row, "interval": list(proved(stopped, (row["probability"],) * 2))} for row in rows]
    ranking = replace(ranking, unlisted=proved(stopped, ranking.unlisted))
    answer: ProgramWorlds = {"format": "worlds/1", "reading": document["reading"], "worlds": rows}
    return _told(ranking, flagged(answer, stopped), stopped, as_json=as_json)


def _of_scene(
    document: Interpretation,
    situation: Situation,
    number: int,
    given: Sequence[str],
    seconds: float | None,
    *,
    as_json: bool,
) -> tuple[str, int]:
    from plogic.face.shown import tables
    from plogic.face.shown.tables import text_of_table
    from plogic.facts.spatial import exclusion_lines, exclusions
    from plogic.scene.readings.unfinished import flagged, proved, with_notice
    from plogic.scene.worlds.predictions import doubts, said

    ranking, stopped = _scene_ranking(situation, number, given, seconds), situation.stopped
    rows = [_row(world, ranking, stopped) for world in ranking.worlds]
    unlisted = list(proved(stopped, ranking.unlisted))
    answer: SceneWorlds = {
        "format": "worlds/1",
        "reading": document["reading"],
        "worlds": rows,
        "unlisted_mass": unlisted,
        "exclusions": exclusions(document),
    }
    answer = flagged(answer, stopped)
    exact = ranking.exact
    if as_json:
        return json.dumps(answer if exact else {**answer, "deadline": "reached"}), 0 if exact else LATE
    text = text_of_table(tables.worlds({**document, "worlds": rows, "unlisted_mass": unlisted}, number))
    text = "".join([text, *(f"{line}\n" for line in exclusion_lines(document))])
    found = [said(doubt) for doubt in doubts(situation)]
    text = "\n".join([text.rstrip(), "", *found, ""]) if found else text
    text = with_notice(text, stopped)
    middles = ranking.log_evidence_interval[0] != ranking.log_evidence_interval[1]
    more = (
        "probabilities are the middles of their intervals" if middles else "more worlds could be listed with more time"
    )
    late = f"The deadline was reached: {more}."
    return (text, 0) if exact else (f"{text.rstrip()}\n{late}", LATE)


def _row(world: World, ranking: Ranking, stopped: Stopped) -> WorldRow:
    from plogic.scene.readings.unfinished import proved

    row: WorldRow = {"probability": world.probability, "present": list(world.present), "causes": dict(world.causes)}
    exact = ranking.log_evidence_interval[0] == ranking.log_evidence_interval[1]
    return row if exact and not stopped else {**row, "interval": list(proved(stopped, world.interval))}


def _scene_ranking(situation: Situation, number: int, given: Sequence[str], seconds: float | None) -> Ranking:
    """With a deadline, grounding the evidence included; what it takes then is left of the time."""
    from plogic.scene.asking.live import LiveScene
    from plogic.scene.worlds.ranked_worlds import ranked_worlds

    if not given:
        return ranked_worlds(situation, number, seconds=seconds)
    end = None if seconds is None else time.monotonic() + seconds
    scene = LiveScene(situation)
    for goal in given:
        scene.observe(goal, seconds=_left(end))
    return scene.worlds(number, seconds=_left(end))


def _left(end: float | None) -> float | None:
    return None if end is None else max(end - time.monotonic(), 0.0)
