"""P(goal): every answer substitution, most probable first (contract, ``plogic query``)."""

import re
import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import replace

from plogic.base.errors import LimitError, ProgramError, SituationError
from plogic.facts.situation import Situation, Stopped, names_of
from plogic.logic.safety.atoms import Names
from plogic.logic.served.engine import Answer, Limits, Text, ask, request_of, run, run_until, unknown
from plogic.scene.readings.unfinished import opened
from plogic.scene.text.values_asked import told_in_words

Subject = Situation | Text
"""What is asked: an interpretation's situation, or a program of a user's own."""


def stopped_of(subject: Subject) -> Stopped:
    """Of what questions are put to; a program was not searched for."""
    return subject.stopped if isinstance(subject, Situation) else ""


def answers(
    subject: Subject,
    goal: str | None = None,
    *,
    given: Sequence[str] = (),
    limits: Limits | None = None,
) -> list[Answer]:
    r"""Each answer to ``goal`` given the evidence, sorted by probability, then text.

    ``goal`` may be a conjunction or a negation, with labels quoted: ``cause(A, h1, 'roof/apex'), \+ noise(a3)``.
    Without a goal a program's own query/1 are answered; of a situation, present/1. A ground goal has one answer, maybe
    with probability 0; a goal with variables has one per substitution of positive probability, and none is an answer
    too. An interval is [0, 1] where the search was stopped (``plogic.scene.readings.unfinished``). Raises ProgramError,
    InconsistentError, LimitError.
    """
    if goal is None and isinstance(subject, Situation):
        goal = "present(H)"
    return answers_to_all(subject, [] if goal is None else [goal], given=given, limits=limits)[0]


def answers_until(
    subject: Subject,
    goal: str | None = None,
    *,
    seconds: float,
    given: Sequence[str] = (),
    limits: Limits | None = None,
) -> tuple[list[Answer], bool]:
    """As ``answers``, by a deadline: what is known after ``seconds``, and whether it is exact.

    Each answer's interval contains its exact probability; of a goal with variables some answers may not be known yet.
    """
    if goal is None and isinstance(subject, Situation):
        goal = "present(H)"
    found, exact = answers_to_all_until(
        subject, [] if goal is None else [goal], seconds=seconds, given=given, limits=limits
    )
    return found[0], exact


def answers_to_all_until(
    subject: Subject,
    goals: Sequence[str],
    *,
    seconds: float,
    given: Sequence[str] = (),
    limits: Limits | None = None,
) -> tuple[list[list[Answer]], bool]:
    """As ``answers_to_all``, by a deadline for all goals together; see ``answers_until``."""
    if isinstance(subject, Situation) and goals:
        limits, end = limits or Limits(), time.monotonic() + seconds
        try:
            on_graph = _on_graph(subject, goals, given, replace(limits, seconds=min(limits.seconds, seconds)), seconds)
        except LimitError:
            return [unknown(goal, names_of(subject)) for goal in goals], False
        if on_graph is not None:
            exact = all(answer.interval[0] == answer.interval[1] for some in on_graph for answer in some)
            return [opened(subject.stopped, some) for some in on_graph], exact
        seconds = max(end - time.monotonic(), 0.0)
    text, names = subject_text(subject)
    with told_in_words(text):
        found, exact = run_until([text], goals, given, seconds=seconds, names=names, limits=limits)
    return [opened(stopped_of(subject), some) for some in found], exact


def answers_to_all(
    subject: Subject,
    goals: Sequence[str],
    *,
    given: Sequence[str] = (),
    limits: Limits | None = None,
) -> list[list[Answer]]:
    """As ``answers``, for many goals in one run. Of a situation, from its factor graph wherever that can say it."""
    with _blaming(subject):
        found = _on_graph(subject, goals, given, limits) if isinstance(subject, Situation) and goals else None
        if found is None:
            found = _by_text(subject, goals, given, limits)
    return [opened(stopped_of(subject), some) for some in found]


def _by_text(subject: Subject, goals: Sequence[str], given: Sequence[str], limits: Limits | None) -> list[list[Answer]]:
    """All goals in one run of the program text; of several about a situation, those that its graph cannot say alone."""
    known: dict[int, list[Answer]] = {}
    if isinstance(subject, Situation) and len(goals) > 1:
        each = [_on_graph(subject, [goal], given, limits) for goal in goals]
        known = {i: found[0] for i, found in enumerate(each) if found is not None}
    rest = [i for i in range(len(goals)) if i not in known]
    if known and not rest:
        return [known[i] for i in range(len(goals))]
    text, names = subject_text(subject)
    with told_in_words(text), _numbered([i + 1 for i in rest], len(goals)):
        found = run([text], [goals[i] for i in rest], given, names=names, limits=limits)
    return found if not known else [known[i] if i in known else found[rest.index(i)] for i in range(len(goals))]


_GOAL = re.compile(r"goal(?: (\d+))?")
"""What a mistake calls the place of a goal: of several in one run with its number, from 0."""


@contextmanager
def _numbered(numbers: Sequence[int], among: int) -> Iterator[None]:
    """Within it a mistake in one of several goals says in which of them: the first is goal 1."""
    try:
        yield
    except ProgramError as error:
        place = _GOAL.fullmatch(error.file or "")
        if among < 2 or place is None:
            raise
        file = f"goal {numbers[int(place[1] or 0)]}"
        raise type(error)(error.reason, file=file, line=error.line, column=error.column) from None


def unknown_names(subject: Subject, goal: str, *, limits: Limits | None = None) -> tuple[str, ...]:
    """A sentence for each constant of a goal that occurs nowhere at its place, with what is close."""
    text, names = subject_text(subject)
    try:
        return tuple(ask({**request_of([text], [goal], (), names), "task": "names"}, limits or Limits())["notes"])
    except LimitError:
        return ()


def _on_graph(
    situation: Situation,
    goals: Sequence[str],
    given: Sequence[str],
    limits: Limits | None,
    seconds: float | None = None,
) -> list[list[Answer]] | None:
    """None for what only the program text can say, or can say what is wrong with it.

    With ``seconds``, intervals by then.
    """
    from plogic.scene.asking.live import scene_answers

    try:
        return scene_answers(situation, goals, given, limits=limits, seconds=seconds)
    except (ProgramError, SituationError):
        return None


def _blaming(subject: Subject) -> AbstractContextManager[None]:
    if isinstance(subject, Text):
        return nullcontext()
    from plogic.scene.worlds.blame import blaming

    return blaming(subject)


def subject_text(subject: Subject) -> tuple[Text, Names | None]:
    """The program of what is asked, and its names (a program of a user's own has none)."""
    if isinstance(subject, Text):
        return subject, None
    from plogic.scene.text.program_text import program_of  # what is of scenes is not read for a program

    return program_of(subject), names_of(subject)
