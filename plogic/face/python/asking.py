"""Questions that an interpretation and a program answer alike, and a program of one's own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from json import JSONDecodeError
from pathlib import Path
from typing import Self

from geometry.files.plain_files import name_of
from plogic.base.errors import InputError, InterpretationError, LimitError
from plogic.face.python.arguments import count, seconds, text, texts
from plogic.face.session.account_text import WHOLE, account_text
from plogic.face.session.blocks import Block, Lines, Result
from plogic.face.session.minds import ranked
from plogic.face.session.results import Answers, Worlds
from plogic.facts.situation import Reading, Stopped
from plogic.logic.served.engine import TOO_DEEP, Limits, Text
from plogic.run.sources import is_program, program_text_of, stdin_text
from plogic.scene.asking.explanations import Account, Reason, explain, present
from plogic.scene.asking.query import Subject, answers, answers_to_all, answers_to_all_until, answers_until, stopped_of
from plogic.scene.readings.unfinished import with_notice

EXPLANATIONS = 5
"""Explanations of each kind, where no number is asked for."""


class Asked:
    """Anything that can be asked: the verbs ``query``, ``explain`` and ``worlds``."""

    trust: bool = False
    """Whether programs and rules may read files and run Python."""

    @property
    def subject(self) -> Subject:
        """The situation, or the program's text, that questions are put to."""
        raise NotImplementedError

    def about(self, goal: str | None) -> "Asked":  # noqa: ARG002 - not everything can be asked about more
        """Return the same with what the goal asks for and takes time to find out."""
        return self

    @property
    def limits(self) -> Limits:
        """The wall time and memory that one question may take."""
        return Limits(trust=self.trust)

    def beside(self, rules: str | Path | None) -> Subject:
        """Return the subject with a file of rules of one's own. Raises Error where it cannot be read."""
        return (
            self.subject if rules is None else replace(self.subject, own=Text(program_text_of(str(rules)), str(rules)))
        )

    def query(
        self,
        goal: str | None = None,
        *,
        given: str | Sequence[str] = (),
        rules: str | Path | None = None,
        deadline: float | None = None,
    ) -> Answers:
        """Return P(goal) with every answer substitution, most probable first.

        Args:
            goal: a conjunction, maybe with variables; without one a program's own ``query/1``, of an interpretation
                ``present(H)``.
            given: literals that are observed.
            rules: a file of rules of one's own.
            deadline: seconds, after which each answer is an interval that contains the exact one.

        Raises:
            Error: naming file, line and column where the goal or the program cannot be used.
        """
        if goal is not None:
            text("goal", goal)
        evidence, deadline = texts("given", given), seconds("deadline", deadline)
        subject = self.about(goal).beside(rules)
        goal = goal if goal is not None or isinstance(subject, Text) else "present(H)"
        if deadline is None:
            found, exact = answers(subject, goal, given=evidence, limits=self.limits), True
        else:
            found, exact = answers_until(subject, goal, seconds=deadline, given=evidence, limits=self.limits)
        return Answers(goal, tuple(found), stopped_of(subject), exact)

    def query_all(
        self,
        goals: Sequence[str],
        *,
        given: str | Sequence[str] = (),
        rules: str | Path | None = None,
        deadline: float | None = None,
    ) -> tuple[Answers, ...]:
        """Return the answers to each of several goals, in their order, as ``query`` gives them; ground in one run.

        Args:
            goals: what ``query`` takes, one by one.
            given: literals that are observed.
            rules: a file of rules of one's own.
            deadline: seconds for all of them together; an Answers is complete where all are.

        Raises:
            Error: as ``query``; a mistake in a goal says in which: ``goal 2``.
        """
        goals, evidence, end = texts("goals", goals), texts("given", given), seconds("deadline", deadline)
        asked: Asked = self
        for goal in goals:
            asked = asked.about(goal)
        subject, exact = asked.beside(rules), True
        if not goals:
            return ()
        if end is None:
            found = answers_to_all(subject, goals, given=evidence, limits=self.limits)
        else:
            found, exact = answers_to_all_until(subject, goals, seconds=end, given=evidence, limits=self.limits)
        stopped = stopped_of(subject)
        return tuple(Answers(goal, tuple(some), stopped, exact) for goal, some in zip(goals, found, strict=True))

    def worlds(
        self,
        n: int = 10,
        *,
        given: str | Sequence[str] = (),
        rules: str | Path | None = None,
        deadline: float | None = None,
    ) -> Worlds:
        """Return the ``n`` most probable possible worlds, and the interval of the mass of all others.

        Args:
            n: how many.
            given: literals that are observed.
            rules: a file of rules of one's own, which ``given`` may speak of.
            deadline: seconds, after which probabilities are intervals that contain the exact ones.

        Raises:
            Error: where evidence cannot be used or leaves no world.
        """
        evidence, end = texts("given", given), seconds("deadline", deadline)
        return ranked(self.beside(rules), count("n", n), evidence, self.limits, end)[0]

    def explain(
        self,
        goal: str,
        *,
        given: str | Sequence[str] = (),
        rules: str | Path | None = None,
        n: int | None = None,
    ) -> "Explanation":
        """Say why the goal holds, and why not; printed, it is the text of ``plogic explain``.

        Args:
            goal: what is to be explained.
            given: literals that are observed.
            rules: a file of rules of one's own.
            n: explanations of each kind; without a number five, and of ``present(h)`` a summary.

        Raises:
            Error: as ``query``.
        """
        evidence, n = texts("given", given), None if n is None else count("n", n)
        subject = self.about(text("goal", goal)).beside(rules)
        summary = present(subject, goal, given=evidence) if n is None else None

        def whole() -> Account:
            try:
                return explain(subject, goal, given=evidence, most=EXPLANATIONS if n is None else n, limits=self.limits)
            except RecursionError:
                raise LimitError(TOO_DEEP) from None

        brief = summary is not None and bool(summary.summary)
        account = summary if summary is not None and brief else whole()
        return Explanation(account, brief, stopped_of(subject), whole, short=n is None)


@dataclass(frozen=True, repr=False)
class Explanation(Result):
    """Why a goal holds, and why not: ``account`` is all that there is to say, or, where it is ``brief``, a summary.

    ``short``: its text fits a screen, and says what is left out.
    """

    account: Account
    brief: bool
    stopped: Stopped = ""
    whole: Callable[[], Account] | None = field(default=None, compare=False)
    short: bool = False

    @cached_property
    def tree(self) -> Reason:
        """The explanations as one tree down to the data.

        The goal, and below it each explanation's own tree, most probable first.
        """
        account = self.whole() if self.brief and self.whole is not None else self.account
        return Reason(account.goal, "explained", tuple(e.tree for e in account.why), account.probability)

    def text(self, *, width: int = 118, styled: bool = False) -> str:  # noqa: ARG002 - trees have a width of their own
        """The text of ``plogic explain``."""
        return with_notice(
            account_text(self.account, brief=self.brief, whole=WHOLE if self.short else None), self.stopped
        )

    def blocks(self) -> tuple[Block, ...]:
        """The text, preformatted."""
        return (Lines("", tuple(self.text().splitlines())),)

    def __reduce__(self) -> tuple[object, ...]:
        """Take the tree along, and not the question that it would be asked by."""
        return Explanation, (self.account, self.brief, self.stopped, None, self.short)


class Program(Asked):
    """A ProbLog program. It may neither read files nor run Python unless it is one's own and ``trust`` says so."""

    def __init__(self, text: str, file: str = "program", *, trust: bool = False) -> None:
        """Take the text; ``file`` is what errors name."""
        self.text, self.file, self.trust = text, file, trust

    @classmethod
    def load(cls, path: str | Path, *, trust: bool = False) -> Self:
        """Read a program's file. Raises Error where it cannot be read."""
        return cls(program_text_of(str(path)), str(path), trust=trust)

    @property
    def subject(self) -> Text:
        """The text with its file."""
        return Text(self.text, self.file)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<Program {self.file}: {len(self.text.splitlines())} lines>"

    def __eq__(self, other: object) -> bool:
        return self.text == other.text if isinstance(other, Program) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.text)


def opened(
    path: str | Path, reading: Reading | None = None, *, trust: bool = False, withhold: Sequence[str] = ()
) -> Asked:
    """Return what a file, or stdin for ``-``, holds: a program, or an interpretation, in a reading where one is named.

    ``withhold``: the hypotheses of it whose poses nobody knows.

    Raises:
        Error: where it cannot be read.
    """
    text, is_text = stdin_text() if str(path) == "-" else (None, is_program(str(path)))
    if is_text:
        if withhold:
            raise InputError(f"{path}: a program has no poses to withhold")
        return Program.load(path, trust=trust) if text is None else Program(text, name_of(path), trust=trust)
    from plogic.face.python.interpretation import Interpretation  # numpy and what is of scenes
    from plogic.facts.interpretation import interpretation_of_text

    try:
        found = Interpretation.load(path) if text is None else Interpretation(interpretation_of_text(text))
    except InterpretationError as error:
        if not isinstance(error.__context__, JSONDecodeError):
            raise
        raise InterpretationError(f"{error}; a program's name ends in .pl, .problog or .pro") from None
    found = found if reading is None else found.read_as(reading)
    found = found.withhold(*withhold) if withhold else found
    found.trust = trust
    return found
