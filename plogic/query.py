"""P(goal): every answer substitution, most probable first (contract, ``plogic query``)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.engine import Answer, Limits, Text, run
from plogic.names import names_of
from plogic.program.text import program_text
from plogic.situation import Situation

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.names import Names

Subject = Situation | Text
"""What is asked: an interpretation's situation, or a program of a user's own."""


def answers(
    subject: Subject,
    goal: str | None = None,
    *,
    given: Sequence[str] = (),
    rules: Text | None = None,
    limits: Limits | None = None,
) -> list[Answer]:
    r"""Each answer to ``goal`` given the evidence, sorted by probability, then text.

    ``goal`` may be a conjunction or a negation, with labels quoted: ``cause(A, h1, 'roof/apex'), \+ noise(a3)``.
    Without a goal a program's own query/1 are answered; of a situation, present/1. A ground goal has one answer,
    maybe with probability 0; a goal with variables has one per substitution of positive probability, and none is an answer too. Raises
    ProgramError, InconsistentError, LimitError.
    """
    if goal is None and isinstance(subject, Situation):
        goal = "present(H)"
    return answers_to_all(subject, [] if goal is None else [goal], given=given, rules=rules, limits=limits)[0]


def answers_to_all(
    subject: Subject,
    goals: Sequence[str],
    *,
    given: Sequence[str] = (),
    rules: Text | None = None,
    limits: Limits | None = None,
) -> list[list[Answer]]:
    """As ``answers``, for many goals in one run."""
    text, names = subject_text(subject)
    return run([text, *([] if rules is None else [rules])], goals, given, names=names, limits=limits)


def subject_text(subject: Subject) -> tuple[Text, Names | None]:
    """The program of what is asked, and its names (a program of a user's own has none)."""
    if isinstance(subject, Text):
        return subject, None
    return Text(program_text(subject)), names_of(subject)
