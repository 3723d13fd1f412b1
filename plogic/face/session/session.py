"""A session: ask, observe and take back, predict, rank the worlds, ask why.

The verbs of the shell (and of Poole's AILog2) as functions.

::

    session = Session.open("interpretation.json")
    session.observe("present(h1)")          # refuses what is impossible, and then leaves everything as it was
    session.predict("present(H)")           # P(goal | everything observed) beside P(goal)
    session.ask("present(H)")               # P(goal) without what was observed; the program's own evidence stays
    print(session.worlds(5))                # every result prints as in the shell, and is a table in a notebook

The order of observations changes nothing, and taking one back restores every byte (tested).
"""

from pathlib import Path
from typing import Self, TypeVar

from geometry.files.plain_files import fault_of
from plogic.base.errors import InconsistentError, InputError, ProgramError
from plogic.face.session import results
from plogic.face.session.blocks import Result
from plogic.face.session.minds import mind_of
from plogic.face.session.verbs import replayed
from plogic.facts.situation import Stopped
from plogic.logic.safety.atoms import is_ground, one_line, tokens
from plogic.logic.served.engine import Answer, Limits
from plogic.logic.served.outline import Predicate
from plogic.run.sources import program_text_of
from plogic.scene.asking.query import Subject, stopped_of
from plogic.scene.readings.unfinished import REASONS, opened, proved
from sensing.files.whole_files import write_whole

_R = TypeVar("_R", bound=Result)

EXPLANATIONS = 5
"""Explanations of each kind, where no number is asked for."""
REMEMBERED = 256
"""Answered questions that a session remembers."""
SCRIPT = "% A session of plogic shell"
"""How a saved session begins."""


class Session:
    """What is believed of one subject, and what was observed of it."""

    def __init__(self, subject: Subject, *, limits: Limits | None = None) -> None:
        self._mind, self._stopped = mind_of(subject, limits), stopped_of(subject)
        self._observed: tuple[str, ...] = ()
        self._lines: tuple[str, ...] = ()
        self._known: dict[tuple[str | None, tuple[str, ...]], tuple[Answer, ...]] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End what runs in the background; the next question would start it anew."""
        self._mind.close()

    @property
    def observed(self) -> tuple[str, ...]:
        """The literals that are observed, in the order in which they were."""
        return self._observed

    @property
    def lines(self) -> tuple[str, ...]:
        """What was asked and observed, one line each: what ``save`` writes."""
        return self._lines

    def ask(self, goal: str | None = None) -> results.Answers:
        """P(goal) with every answer substitution, without what was observed. Without a goal as ``plogic query``.

        Raises ProgramError, InconsistentError, LimitError, as every verb that takes a goal.
        """
        return self._done("ask", goal, results.Answers(goal, self._answers(goal, ()), self._stopped))

    def observe(self, literal: str) -> results.Observed:
        """Add evidence. Raises InconsistentError where it is impossible given what was observed.

        Nothing is changed then.
        """
        literal = one_line(literal)
        before = self._observed
        same = self._place(literal)
        if same is not None:
            return results.Observed(before[same], 1.0, before, self._stopped)
        result = results.Observed(literal, self._probability(literal), before, self._stopped)
        self._observed = (*before, literal)
        return self._done("observe", literal, result)

    def unobserve(self, literal: str | None = None) -> results.Released:
        """Take back one observation, or all of them; raises InputError where it was not observed."""
        place = None if literal is None else self._place(literal)
        if literal is not None and place is None:
            known = "; ".join(self._observed) or "nothing"
            raise InputError(f"unobserve: {one_line(literal)} is not observed (observed: {known})")
        gone = self._observed if place is None else (self._observed[place],)
        self._observed = tuple(known for known in self._observed if known not in gone)
        return self._done("unobserve", literal, results.Released(gone, self._observed))

    def predict(self, goal: str | None = None) -> results.Predictions:
        """P(goal | everything observed) beside the P(goal) of ``ask``, most probable now first."""
        now, before = self._answers(goal, self._evidence), self._answers(goal, ())
        return self._done(
            "predict",
            goal,
            results.Predictions(goal, _beside(now, before, self._stopped), self._evidence, self._stopped),
        )

    def worlds(self, n: int = 10) -> results.Worlds:
        """The ``n`` most probable worlds given what was observed, and the mass that is not listed."""
        rows, unlisted = self._mind.worlds(n, self._evidence)
        return self._done(
            "worlds",
            str(n),
            results.Worlds(rows, proved(self._stopped, unlisted), self._evidence, self._mind.types, self._stopped),
        )

    def why(self, goal: str, most: int | None = None) -> results.Explained:
        """The ``most`` probable explanations of the goal given what was observed, as trees down to the data.

        Without a number there are up to five, and where a summary of the features says it all, only that is shown.
        """
        return self._explained("why", goal, most, against=False)

    def whynot(self, goal: str, most: int | None = None) -> results.Explained:
        """Why the goal does not hold.

        The explanations of its negation, or the condition that fails, nearest misses first.
        """
        return self._explained("whynot", goal, most, against=True)

    def listing(self, name: str | None = None) -> results.Listing:
        """The clauses of a predicate (``wet``, ``wet/1``) or of a scene's layer (``3``).

        Without a name what was observed, and what there is.

        Raises InputError where there is no such thing.
        """
        if name is None:
            return self._done("listing", None, results.Listing("clauses", (), self._observed, self._mind.contents()))
        name = one_line(name)
        title, clauses = self._mind.clauses(name)
        return self._done("listing", name, results.Listing(title, clauses, self._observed))

    def predicates(self) -> tuple[Predicate, ...]:
        """The predicates that can be asked for, with what they mean as far as that is known."""
        return self._mind.predicates()

    def names(self) -> tuple[tuple[str, str], ...]:
        """(constant as a goal writes it, what it names): hypotheses, features, appearances, types.

        A program's own constants.
        """
        return self._mind.names()

    def contents(self) -> tuple[tuple[str, str], ...]:
        """(name, meaning) of what can be listed."""
        return self._mind.contents()

    def greeting(self) -> str:
        """One sentence: what the session is about. Raises ProgramError where that cannot be read."""
        reason = REASONS.get(self._stopped)
        return self._mind.greeting() + (f"; {reason}" if reason else "")

    def save(self, path: str | Path) -> results.Saved:
        """Write the lines of the session, so that ``plogic shell SUBJECT < FILE`` does them again.

        Raises InputError for a file that is there and no saved session, and for a line that cannot be written as one.
        """
        path = _place(path)
        broken = next((line for line in self._lines if not line.isprintable()), None)
        if broken is not None:
            raise InputError(
                f"{path}: {broken!r} holds a line break or the like and cannot be a line of a saved session"
            )
        if fault_of(path) is None and not path.read_bytes().startswith(SCRIPT.encode()):
            raise InputError(f"{path}: is there already and is no saved session; choose another name")
        write_whole(path, "\n".join([SCRIPT, *self._lines, ""]).encode())
        return results.Saved(str(path), self._lines)

    def load(self, path: str | Path) -> results.Replayed:
        """Do the lines of a saved session.

        The first that fails is told with its number (InputError), and those before it stay done.
        """
        path = _place(path)
        return replayed(self, str(path), program_text_of(str(path)))

    @property
    def _evidence(self) -> tuple[str, ...]:
        """What is observed, in an order that does not depend on when it was."""
        return tuple(sorted(self._observed, key=lambda literal: (tokens(literal), literal)))

    def _place(self, literal: str) -> int | None:
        return next((i for i, known in enumerate(self._observed) if tokens(known) == tokens(literal)), None)

    def _answers(self, goal: str | None, given: tuple[str, ...]) -> tuple[Answer, ...]:
        """What was found before is not looked for again: P(goal) beside each prediction, above all."""
        key = (goal, given)
        if key not in self._known:
            self._known[key] = tuple(opened(self._stopped, self._mind.answers(goal, given)))
        while len(self._known) > REMEMBERED:
            del self._known[next(iter(self._known))]
        return self._known[key]

    def _probability(self, literal: str) -> float:
        """P(some answer of the literal | observed), above 0."""
        p = self._holding(literal).probability
        if p > 0 and (p > 1e-9 or self._can_be_given(literal)):
            return p
        beside = f" given {'; '.join(self._observed)}" if self._observed else ""
        raise InconsistentError(f"{literal} is impossible{beside}: its probability is 0; nothing was changed")

    def _holding(self, literal: str) -> Answer:
        """That the literal has an answer: the double negation has no variables of its own."""
        if is_ground(literal):
            return self._answers(literal, self._evidence)[0]
        try:
            return self._answers(f"\\+ \\+ ({literal})", self._evidence)[0]
        except ProgramError:
            self._answers(literal, self._evidence)  # raises with the place in what was typed
            raise

    def _can_be_given(self, literal: str) -> bool:
        """Whether a probability near 0 is more than the noise of a difference from 1."""
        try:
            self._answers(literal, (*self._evidence, literal))
        except InconsistentError:
            return False
        return True

    def _explained(self, verb: str, goal: str, most: int | None, *, against: bool) -> results.Explained:
        account = self._mind.account(goal, self._evidence, EXPLANATIONS if most is None else most)
        result = results.Explained(account, against, self._evidence, brief=most is None, stopped=self._stopped)
        return self._done(verb, goal if most is None else f"{most} {goal}", result)

    def _done(self, verb: str, argument: str | None, result: _R) -> _R:
        self._lines = (*self._lines, verb if argument is None else f"{verb} {one_line(argument)}")
        return result


def _place(path: str | Path) -> Path:
    """The path, with ``~`` as a shell reads it. Raises InputError where nobody knows that home."""
    try:
        return Path(path).expanduser()
    except RuntimeError:
        raise InputError(f"{path}: nobody knows that home folder; name the whole path") from None


def _beside(now: tuple[Answer, ...], before: tuple[Answer, ...], stopped: Stopped) -> tuple[results.Prediction, ...]:
    """Each answer of either, with a probability of 0 where it is none."""
    none = proved(stopped, (0.0, 0.0))
    current = {answer.goal: answer for answer in now}
    earlier = {answer.goal: answer for answer in before}
    goals = [*current, *(goal for goal in earlier if goal not in current)]
    return tuple(
        results.Prediction(
            goal, earlier.get(goal) or Answer(goal, 0.0, none), current.get(goal) or Answer(goal, 0.0, none)
        )
        for goal in goals
    )
