"""``plogic program``, ``report`` and ``measures``: an interpretation as program text, as a page and as tables."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path

from plogic.base.errors import InputError
from plogic.face.shown.printed import written
from plogic.facts.interpretation import read_interpretation, situation_of
from plogic.facts.situation import Reading, Situation, names_of
from plogic.scene.readings.unfinished import marks, with_notice


def program_command(
    interpretation: str | None,
    kb: str | None,
    *,
    reading: Reading | None = None,
    withhold: Sequence[str] = (),
    rules: str | None = None,
    as_json: bool = False,
) -> str:
    """The ProbLog text of an interpretation with its queries, or of a knowledge base: Σ alone.

    As somebody would write it who does not know the poses that are withheld; with ``rules``, a file of a user's own,
    which are checked as those of a knowledge base are. Raises InputError where both are given, or none, ProgramError.
    """
    from plogic.scene.text.program_text import program_text, query_lines

    if (interpretation is None) == (kb is None):
        raise InputError("give an interpretation, or --kb KB: the program is of one of them")
    if kb is not None:
        from plogic.run.carried import sigma
        from plogic.run.sources import kb_of

        situation = sigma(kb_of(kb), "score", "to_B")
    else:
        document = read_interpretation(str(interpretation))
        if withhold:
            from plogic.sequence.unposed.elsewhere import without_poses

            document = without_poses(document, withhold)
        situation = situation_of(document)
    situation = situation if reading is None else replace(situation, reading=reading)
    if rules is not None:
        situation = replace(situation, rules=_with_rules(situation, rules))
    text = program_text(situation) + "\n" + query_lines(situation)
    told = {"format": "program/1", "reading": situation.reading, "program": text, **marks(situation.stopped)}
    return json.dumps(told) if as_json else text


def _with_rules(situation: Situation, file: str) -> str:
    """The author's rules and those of a file, which may add to neither them nor the program."""
    from plogic.logic.safety.author import FILE, author_rules, load_problog
    from plogic.run.sources import program_text_of
    from plogic.scene.text.rules import defined

    own, known = program_text_of(file), defined()
    load_problog()
    from plogic.logic.safety.added import LAWFUL, check_added, lawful
    from plogic.logic.safety.check import parse

    theirs = parse(situation.rules, FILE)
    known |= check_added(theirs, known) | (LAWFUL if lawful(theirs, known) != theirs.text else frozenset())
    author_rules(own, names_of(situation), known, file)  # its mistakes are told at their place in it
    return f"{situation.rules}\n{own}"


def report_command(interpretation: str, out: str, *, say: Callable[[str], None], write: Callable[[str], None]) -> None:
    """Write the page; `-` is stdout."""
    from plogic.face.pages.one_file import page
    from sensing.files.whole_files import check_places

    if out != "-":
        check_places([Path(out)], [interpretation])
    written(page(read_interpretation(interpretation)), out, say=say, write=write)


def measures_command(source: str, *, as_json: bool) -> str:
    """The document ``measures/1``, or both tables. Raises InterpretationError, SituationError."""
    from plogic.face.python.interpretation import Interpretation

    read = Interpretation.load(source)
    found, stopped = read.measures(), read.subject.stopped
    if as_json:
        return json.dumps({"format": "measures/1", **asdict(found), **marks(stopped)})
    return with_notice(str(found), stopped)
