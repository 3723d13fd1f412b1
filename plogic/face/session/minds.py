"""What answers a session: of a scene and of a program the same questions, each put to what is quickest there.

The observations come with every question, sorted, so that nothing depends on when they were made.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from plogic.logic.served.engine import Limits, Process, Text, ask, through

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from plogic.face.session.results import World
    from plogic.logic.served.engine import Answer
    from plogic.logic.served.outline import Outline, Predicate
    from plogic.scene.asking.explanations import Account
    from plogic.scene.asking.query import Subject

Ranked = tuple[tuple["World", ...], tuple[float, float]]


class Mind(Protocol):
    """What a session asks of its subject; every method raises as ``plogic.scene.asking.query.answers`` does."""

    @property
    def types(self) -> dict[str, str] | None:
        """The type of each of a scene's hypotheses, by id; None of a program."""

    def answers(self, goal: str | None, given: Sequence[str]) -> list[Answer]:
        """P(goal | given), every answer."""

    def worlds(self, n: int, given: Sequence[str]) -> Ranked:
        """The ``n`` best worlds and the interval of the mass that is not among them."""

    def account(self, goal: str, given: Sequence[str], most: int) -> Account:
        """Why, and why not."""

    def contents(self) -> tuple[tuple[str, str], ...]:
        """(name, meaning) of what ``clauses`` can be asked for."""

    def clauses(self, name: str) -> tuple[str, tuple[str, ...]]:
        """A title and the clauses; raises InputError where there is no such thing."""

    def predicates(self) -> tuple[Predicate, ...]:
        """What can be asked for."""

    def names(self) -> tuple[tuple[str, str], ...]:
        """(constant, what it names)."""

    def greeting(self) -> str:
        """One sentence: what the session is about. Raises what is wrong with the subject."""

    def close(self) -> None:
        """End what runs in the background."""


class Asked:
    """What scenes and programs have in common: a process that stays, and how to query and explain."""

    def __init__(self, subject: Subject, limits: Limits | None) -> None:
        self.subject, self.limits = subject, limits or Limits()
        self.process = Process(self.limits)
        self._outline: Outline | None = None

    def answers(self, goal: str | None, given: Sequence[str]) -> list[Answer]:
        """P(goal | given), every answer."""
        from plogic.scene.asking.query import answers

        return self._through(lambda: answers(self.subject, goal, given=given, limits=self.limits))

    def account(self, goal: str, given: Sequence[str], most: int) -> Account:
        """Why, and why not."""
        from plogic.scene.asking.explanations import explain

        return self._through(lambda: explain(self.subject, goal, given=given, most=most, limits=self.limits))

    def outline(self) -> Outline:
        """The program's predicates and constants, read once; raises ProgramError."""
        from plogic.logic.served.outline import outline_of, outline_request
        from plogic.scene.asking.query import subject_text

        if self._outline is None:
            text, names = subject_text(self.subject)
            request = outline_request([{"text": text.text, "file": text.file}], names)
            self._outline = outline_of(self._through(lambda: ask(request, self.limits)))
        return self._outline

    def close(self) -> None:
        """End the process."""
        self.process.close()

    def _through(self, call: Callable[[], Any]) -> Any:  # noqa: ANN401 - whatever the call returns
        with through(self.process.ask):
            return call()


def mind_of(subject: Subject, limits: Limits | None) -> Mind:
    """The mind of a situation or of a program's text."""
    from plogic.face.session.program_mind import ProgramMind
    from plogic.face.session.scene_mind import SceneMind

    return ProgramMind(subject, limits) if isinstance(subject, Text) else SceneMind(subject, limits)
