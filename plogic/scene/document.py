"""The shapes of what a scene or a program answers: ``answers/1`` and ``worlds/1``, as ``--json`` prints them."""

from typing import Annotated, Literal, NotRequired, TypedDict

from plogic.facts.document import Marks, WorldRow
from plogic.facts.fact_rows import ExclusionRow, Interval, Name, Slightly
from plogic.facts.situation import Reading


class AnswerRow(TypedDict):
    """P(goal); ``interval`` contains the exact one."""

    goal: Annotated[str, "The goal with its variables filled in."]
    probability: Annotated[Slightly, "P(goal); of an interval its middle."]
    interval: Annotated[Interval, "Bounds of the exact probability."]


class LateKey(TypedDict):
    """Where a deadline came before all was known."""

    deadline: NotRequired[Annotated[Literal["reached"], "That a deadline came before all was known."]]


class Answers(Marks, LateKey):
    """The document ``answers/1``, most probable first; of several goals one a line, in their order."""

    format: Literal["answers/1"]
    asked: NotRequired[Annotated[str, "The goal, where several were asked."]]
    answers: Annotated[list[AnswerRow], "Every answer, most probable first."]


class SceneWorlds(Marks, LateKey):
    """The document ``worlds/1`` of an interpretation."""

    format: Literal["worlds/1"]
    reading: Reading
    worlds: list[WorldRow]
    unlisted_mass: Interval
    exclusions: list[ExclusionRow]


class ProgramWorldRow(TypedDict):
    """One possible world of a program text.

    The goals that are ``true`` in it, of a scene who is ``present``, and its choices.
    """

    probability: Slightly
    choices: list[str]
    true: NotRequired[list[str]]
    present: NotRequired[list[Name]]
    interval: NotRequired[Interval]


class ProgramWorlds(Marks, LateKey):
    """The document ``worlds/1`` of a program text; its last two keys are always written."""

    format: Literal["worlds/1"]
    reading: NotRequired[Reading]
    worlds: list[ProgramWorldRow]
    unlisted_mass: NotRequired[Interval]
    log_evidence: NotRequired[float | None]
