"""Where commands take their input from: knowledge bases, interpretations, programs."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from geometry.files.plain_files import is_there
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.situation import Reading, Situation
    from plogic.logic.served.engine import Text
    from plogic.scene.asking.query import Subject

LARGEST_PROGRAM = 8 * 2**20
"""Bytes of a program or rules file that is read."""


def kb_of(folder: str) -> KnowledgeBase:
    """Read a knowledge base; the name of a shipped one (`towers`) stands for its folder where no such folder exists.

    Its rules are held to the allow-list here, before any work is done with it. Raises KBError, ProgramError.
    """
    from kb.files.folder import shipped
    from kb.files.read import read_kb
    from plogic.logic.safety.atoms import Names
    from plogic.logic.safety.author import author_rules
    from plogic.scene.text.rules import defined

    path = Path(folder)
    kb = read_kb(path if is_there(path) or "/" in folder else shipped(folder))
    author_rules(kb.rules, Names({}, {}), defined())
    return kb


def is_program(source: str) -> bool:
    """Whether a source names ProbLog text."""
    return source.lower().endswith((".pl", ".problog", ".pro"))


def program_text_of(path: str) -> str:
    """The text of a program or rules file; `-` is stdin. Raises InputError."""
    try:
        data = sys.stdin.buffer.read(LARGEST_PROGRAM + 1) if path == "-" else Path(path).read_bytes()
        if len(data) > LARGEST_PROGRAM:
            raise InputError(f"{path}: is larger than the {LARGEST_PROGRAM} bytes that a program may have")
        return data.decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text (byte {error.start})") from None


def situation_from(source: str, reading: Reading | None = None) -> Situation:
    """The situation of an interpretation's file, in the other reading where one is named: Δh and its facts are the same."""
    from plogic.facts.interpretation import read_interpretation, situation_of

    situation = situation_of(read_interpretation(source))
    return situation if reading is None else replace(situation, reading=reading)


def subject_of(source: str, reading: Reading | None) -> Subject:
    """A situation, or program text, as ``answers`` and ``explain`` take them."""
    from plogic.logic.served.engine import Text

    return Text(program_text_of(source), source) if is_program(source) else situation_from(source, reading)


def rules_from(path: str | None) -> Text | None:
    """A file of a user's own rules."""
    from plogic.logic.served.engine import Text

    return None if path is None else Text(program_text_of(path), path)
