"""What each verb answers: plain data that prints as in the shell and shows itself as a table in a notebook.

``str(result)`` is the text, the same bytes each time; ``result.text(width=80, styled=True)`` is the text for a
terminal. Vocabulary:

* ``Answers`` of ``ask``, with rows such as ``AnswerRow("present(h1)", {"H": "h1"}, 0.97, (0.97, 0.97))``;
  ``Predictions`` of ``predict``
* ``Observed`` of ``observe``, ``Released`` of ``unobserve``
* ``Worlds`` of ``worlds``, with rows such as ``World(0.96, ("h1", "h2"), {"a1": "h1/roof/apex"}, (0.96, 0.96))``
* ``Explained`` of ``why`` and ``whynot``, ``Listing`` of ``listing``, ``Saved`` of ``save``, ``Replayed`` of ``load``
"""

import math
from dataclasses import dataclass, replace

from plogic.face.session.account_text import account_text
from plogic.face.session.blocks import Block, Column, Lines, Note, Result, Rows, Table
from plogic.face.shown.figures import NONE, chance, interval
from plogic.facts.situation import Stopped
from plogic.facts.stances import words_of_standing
from plogic.logic.safety.author import bindings
from plogic.logic.safety.notes import notes_on_goals
from plogic.logic.served.engine import Answer
from plogic.scene.asking.explanations import Account
from plogic.scene.readings.unfinished import notice, proved

PROBABILITY = Column("probability", right=True)


@dataclass(frozen=True)
class AnswerRow:
    """One answer: the ``goal`` with the values of its variables, which ``bindings`` gives by name.

    Its probability, and bounds of it.
    """

    goal: str
    bindings: dict[str, str | int | float]
    probability: float
    interval: tuple[float, float]


@dataclass(frozen=True, repr=False)
class Answers(Rows[AnswerRow]):
    """P(goal): every answer, most probable first. ``complete``: whether no deadline came before all was known."""

    goal: str | None
    answers: tuple[Answer, ...]
    stopped: Stopped = ""
    complete: bool = True

    @property
    def rows(self) -> tuple[AnswerRow, ...]:
        """The answers with the bindings of the goal's variables."""
        return tuple(
            AnswerRow(a.goal, bindings(self.goal, a.goal) if self.goal else {}, a.probability, a.interval)
            for a in self.answers
        )

    def blocks(self) -> tuple[Block, ...]:
        """The table of ``plogic query``."""
        rows = tuple((*_chances(a, self.stopped), a.goal) for a in self.answers)
        return (
            Table("answers", (PROBABILITY, *_between(self.stopped), Column("goal")), rows),
            *_unfinished(self.stopped),
            *_too_early("goal", self.goal),
        )


@dataclass(frozen=True)
class Prediction:
    """One answer: P(goal) ``before`` anything was observed, and ``now``."""

    goal: str
    before: Answer
    now: Answer


@dataclass(frozen=True)
class PredictionRow(AnswerRow):
    """One answer: its ``probability`` given what was observed, with bounds, and what it was ``before``."""

    before: float


@dataclass(frozen=True, repr=False)
class Predictions(Rows[PredictionRow]):
    """P(goal | everything observed) beside P(goal), most probable now first."""

    goal: str | None
    predictions: tuple[Prediction, ...]
    observed: tuple[str, ...]
    stopped: Stopped = ""

    @property
    def rows(self) -> tuple[PredictionRow, ...]:
        """The answers with the bindings of the goal's variables."""
        return tuple(
            PredictionRow(
                p.goal,
                bindings(self.goal, p.goal) if self.goal else {},
                p.now.probability,
                p.now.interval,
                p.before.probability,
            )
            for p in self.predictions
        )

    def blocks(self) -> tuple[Block, ...]:
        """The table of the answers, two columns of probabilities."""
        columns = (PROBABILITY, *_between(self.stopped), Column("before", right=True), Column("goal"))
        rows = tuple(
            (*_chances(row.now, self.stopped), _chances(row.before, self.stopped)[0], row.goal)
            for row in self.predictions
        )
        answers = Table(f"answers {_given(self.observed)}", columns, rows)
        return (answers, *_unfinished(self.stopped), *_too_early("goal", self.goal))


@dataclass(frozen=True, repr=False)
class Observed(Result):
    """``literal`` is observed from now on; it had the ``probability`` given what was ``observed`` up to then."""

    literal: str
    probability: float
    observed: tuple[str, ...]
    stopped: Stopped = ""

    @property
    def surprise(self) -> float:
        """The surprise in bits, −log2 of the probability: 0 of what was certain."""
        return -math.log2(self.probability) + 0.0

    def blocks(self) -> tuple[Block, ...]:
        """One sentence."""
        if self.literal in self.observed:
            return (Note(f"{self.literal} is observed already"),)
        beside = (
            "it was certain, so that nothing changes"
            if self.probability == 1
            else f"{self.surprise:.3g} bits of surprise"
        )
        return (
            Note(f"observed {self.literal}: its probability was {chance(self.probability)} ({beside})"),
            *_unfinished(self.stopped),
            *_too_early("literal", self.literal),
        )


@dataclass(frozen=True, repr=False)
class Released(Result):
    """The ``literals`` are no longer observed; these still are."""

    literals: tuple[str, ...]
    observed: tuple[str, ...]

    def blocks(self) -> tuple[Block, ...]:
        """One sentence."""
        if not self.literals:
            return (Note("nothing was observed"),)
        rest = f"; still observed: {'; '.join(self.observed)}" if self.observed else "; nothing is observed now"
        return (Note(f"no longer observed: {'; '.join(self.literals)}{rest}"),)


@dataclass(frozen=True)
class World:
    """One possible world, with its ``probability`` and bounds of it.

    Of a scene: the hypotheses that are ``present``, and the cause of each appearance (None where evidence speaks of
    what causes leave open); where things are said to rest, ``support``, the most probable plane (``none``: nothing says
    where, ``other``: one without a name), and each one's most probable stance (``{"h1": "s1/2", "h2": "free"}``). Of a
    program: the queries that are ``present``, true, in it; worlds in which these are the same are one, with the most
    probable total choice among them.
    """

    probability: float
    present: tuple[str, ...]
    causes: dict[str, str] | None
    interval: tuple[float, float]
    choices: tuple[str, ...] = ()
    support: str | None = None
    stances: dict[str, str] | None = None


@dataclass(frozen=True, repr=False)
class Worlds(Rows[World]):
    """The most probable worlds given what was ``observed``, and the interval of the mass that is not listed.

    ``types`` of a scene's hypotheses by id; None of a program. ``complete``: whether no deadline came before all was
    known.
    """

    worlds: tuple[World, ...]
    unlisted: tuple[float, float]
    observed: tuple[str, ...]
    types: dict[str, str] | None
    stopped: Stopped = ""
    complete: bool = True

    @property
    def rows(self) -> tuple[World, ...]:
        """The listed worlds, most probable first."""
        return self.worlds

    def blocks(self) -> tuple[Block, ...]:
        """The table of ``plogic worlds``."""
        scene = self.types is not None
        more = (
            (Column("explained", right=True), Column("noise", right=True))
            if scene
            else (Column("most probable choices"),)
        )
        between = _between(self.stopped)
        stands = any(row.support is not None for row in self.worlds)
        columns = (
            Column("rank", right=True),
            PROBABILITY,
            *between,
            Column("present" if scene else "holds"),
            *more,
            *[Column("stands on")] * stands,
        )
        rows = [_world(i, row, self.stopped, self.types) for i, row in enumerate(self.worlds, 1)]
        if stands:
            rows = [
                (*row, words_of_standing(w.support, w.stances or {})) for row, w in zip(rows, self.worlds, strict=True)
            ]
        if self.unlisted[1] > 0:
            rest = len(columns) - len(between) - 3
            rows.append(("", *("" for _ in between), interval(*self.unlisted), "not listed", *[""] * rest))
        title = "possible worlds" + (f" {_given(self.observed)}" if self.observed else "")
        return (Table(title, columns, tuple(rows)), *_unfinished(self.stopped))


@dataclass(frozen=True, repr=False)
class Explained(Result):
    """The account of a goal given what was ``observed``: why it holds, or (``against``) why it does not.

    ``brief``: where the account has a summary, that is shown, and the explanations one by one are only in the data.
    """

    account: Account
    against: bool
    observed: tuple[str, ...]
    brief: bool = False
    stopped: Stopped = ""

    def blocks(self) -> tuple[Block, ...]:
        """The probability, then a tree for every explanation, or the condition that fails."""
        account = _against(self.account) if self.against else _for(self.account)
        hidden = self.brief and bool(account.summary) and bool(account.why or account.why_not)
        if hidden:
            account = replace(account, why=(), why_not=())
        whole = f"`{'whynot' if self.against else 'why'} 5 {self.account.goal}`"
        text = account_text(account, whole=whole if self.brief else None)
        (head, *beside), *sections = (section.splitlines() for section in text.split("\n\n"))
        given = f" {_given(self.observed)}" if self.observed else ""
        first: list[Block] = [Note(head + given), *([Lines("", tuple(beside))] if beside else [])]
        if hidden:
            sections.append([f"(its explanations, choice by choice: {whole})"])
        if not sections:
            sections = [
                ["there is no explanation: it holds in every world" if self.against else "there is no explanation"]
            ]
        return (
            *first,
            *(block for section in sections if section for block in _section(section)),
            *_unfinished(self.stopped),
        )


@dataclass(frozen=True, repr=False)
class Listing(Result):
    """Clauses under a title, or what there is to list; and what is ``observed`` where that was asked for."""

    title: str
    clauses: tuple[str, ...]
    observed: tuple[str, ...]
    contents: tuple[tuple[str, str], ...] = ()

    def blocks(self) -> tuple[Block, ...]:
        """The clauses as they can be read again; else what is observed and the contents of the program."""
        if self.clauses:
            return (Lines(f"% {self.title}", self.clauses),)
        rows = tuple((literal,) for literal in self.observed)
        observed = Table("observed", (Column("literal"),), rows) if rows else Note("nothing is observed")
        return (
            (observed, Table(self.title, (Column("name"), Column("meaning")), self.contents))
            if self.contents
            else (observed,)
        )


@dataclass(frozen=True, repr=False)
class Help(Result):
    """What verbs or predicates mean: (usage, meaning)."""

    title: str
    rows: tuple[tuple[str, str], ...]

    def blocks(self) -> tuple[Block, ...]:
        """One table."""
        return (Table(self.title, (Column("usage"), Column("meaning")), self.rows),)


@dataclass(frozen=True, repr=False)
class Saved(Result):
    """The session's ``lines`` are in the ``file``."""

    file: str
    lines: tuple[str, ...]

    def blocks(self) -> tuple[Block, ...]:
        """One sentence."""
        return (Note(f"saved {len(self.lines)} lines to {self.file}"),)


@dataclass(frozen=True, repr=False)
class Replayed(Result):
    """What each line of a saved session came to."""

    results: tuple[Result, ...]

    def blocks(self) -> tuple[Block, ...]:
        """Everything that they show."""
        return tuple(block for result in self.results for block in result.blocks())


def _for(account: Account) -> Account:
    """What speaks for the goal; of one that has no explanation, what lacked."""
    return replace(
        account, why_not=(), covered_not=type(account.covered_not)(), misses=() if account.why else account.misses
    )


def _against(account: Account) -> Account:
    return replace(account, why=(), covered=type(account.covered)())


def _chances(answer: Answer, stopped: Stopped) -> tuple[str, ...]:
    """Its probability, or within what bounds it is known; of what is unfinished both."""
    return (chance(answer.probability), interval(*answer.interval)) if stopped else (interval(*answer.interval),)


def _between(stopped: Stopped) -> tuple[Column, ...]:
    return (Column("interval", right=True),) if stopped else ()


def _unfinished(stopped: Stopped) -> tuple[Block, ...]:
    """One line below what is told of an unfinished interpretation."""
    return (Note(notice(stopped)),) if stopped else ()


def _too_early(name: str, asked: str | None) -> tuple[Block, ...]:
    """What is surely not meant so in a goal or a literal, as ``plogic query`` says it on stderr."""
    return () if asked is None else tuple(Note(line) for line in notes_on_goals({name: asked}))


def _given(observed: tuple[str, ...]) -> str:
    return f"given {'; '.join(observed)}" if observed else "with nothing observed"


def _world(rank: int, row: World, stopped: Stopped, types: dict[str, str] | None) -> tuple[str, ...]:
    within = (interval(*proved(stopped, row.interval)),) if stopped else ()
    names = row.present if types is None else tuple(f"{types[h]} {h}" for h in row.present)
    shown = (
        str(rank),
        interval(*row.interval),
        *within,
        ", ".join(names) or (NONE if types is None else "nothing known"),
    )
    if types is None:
        return (*shown, ", ".join(row.choices) or NONE)
    if row.causes is None:
        return (*shown, NONE, NONE)
    noise = list(row.causes.values()).count("noise")
    return (*shown, str(len(row.causes) - noise), str(noise))


def _section(section: list[str]) -> tuple[Block, ...]:
    """A heading with what is indented below it; lines without a heading stand alone."""
    if section[0].startswith(" "):
        return Note(""), Lines("", tuple(section))
    return Note(""), Lines(section[0], tuple(section[1:])) if section[1:] else Note(section[0])
