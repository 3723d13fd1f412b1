"""Which evidence of a program is impossible: one piece alone, or two that exclude each other."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from problog.logic import Not, Term

from plogic.base.errors import BeliefError, InconsistentError
from plogic.base.excluding import excluding
from plogic.logic.answers.ways import counted
from plogic.logic.grounding.load import EVIDENCE, Request, line_of, request_from

if TYPE_CHECKING:
    from collections.abc import Sequence

SECONDS = 5.0
"""After so much work no further try begins: the error must come before the limit of time does."""


def blamed(document: dict[str, Any]) -> str:
    """``evidence(b) (u.pl:3) alone is impossible``, or a pair; empty where neither says it, and for scenes.

    Scenes tell it in their own words (``plogic.scene.worlds.blame``).
    """
    if document.get("names") is not None:
        return ""
    request = request_from(document)
    pieces = [i for i, s in enumerate(request.statements) if type(s) is Term and s.signature in EVIDENCE]
    return excluding(
        pieces,
        lambda some: _impossible(request, set(pieces) - set(some)),
        lambda i: _said(request, i, document.get("given", ())),
        SECONDS,
    )


def _impossible(request: Request, without: set[int]) -> bool:
    kept = tuple(s for i, s in enumerate(request.statements) if i not in without)
    try:
        counted(replace(request, statements=kept))
    except InconsistentError:
        return True
    except BeliefError:
        return False
    return False


def _said(request: Request, number: int, given: Sequence[str]) -> str:
    """A piece of evidence as it was written, with its place."""
    statement = request.statements[number]
    goal = str(statement.args[0])
    if goal.startswith("'plogic given "):
        return f"--given {given[int(goal.strip(chr(39)).rpartition(' ')[2])]}"
    line = line_of(request, statement)
    written = ", ".join(f"\\+ {a.args[0]}" if isinstance(a, Not) else str(a) for a in statement.args)
    return f"evidence({written}) ({request.sources[0].file}{'' if line is None else f':{line}'})"
