"""``plogic program`` and ``plogic report``: an interpretation as program text and as a page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from plogic.run.sources import situation_from

if TYPE_CHECKING:
    from collections.abc import Callable

    from plogic.facts.situation import Reading


def program_command(interpretation: str, reading: Reading | None, *, as_json: bool = False) -> str:
    """The ProbLog text with its queries."""
    from plogic.scene.readings.unfinished import marks
    from plogic.scene.text.program_text import program_text, query_lines

    situation = situation_from(interpretation, reading)
    text = program_text(situation) + "\n" + query_lines(situation)
    told = {"format": "program/1", "reading": situation.reading, "program": text, **marks(situation.stopped)}
    return json.dumps(told) if as_json else text


def report_command(interpretation: str, out: str, *, say: Callable[[str], None], write: Callable[[str], None]) -> None:
    """Write the page; `-` is stdout."""
    from plogic.face.pages.report import page
    from plogic.facts.interpretation import read_interpretation
    from sensing.files.whole_files import write_whole

    text = page(read_interpretation(interpretation))
    if out == "-":
        write(text)
        return
    write_whole(Path(out), text.encode())
    say(f"wrote {out}")
