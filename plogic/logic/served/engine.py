"""Runs a program through ProbLog in a process of its own, with limits, to answers or one clear error.

Making the text and running it are two functions; this one runs it. Vocabulary:

* ``Text``, one piece of program with the file that it came from, ``Text("present(h1).", "scene.pl")``
* ``Limits``, ``Limits(seconds=60, megabytes=2048, trust=False)``
* ``Answer``, ``Answer("present(h1)", 0.97, (0.97, 0.97))``
* ``Process``, one that stays: questions go to it one after another, each with its own limit of time. What runs out of
  time or is interrupted ends with its process; the next question starts another
"""

import contextlib
import contextvars
import json
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import monotonic
from typing import Any

from plogic.base import errors
from plogic.base.children import Child, ending_well, heard, python
from plogic.base.errors import LimitError
from plogic.logic.safety.atoms import Names


@dataclass(frozen=True)
class Text:
    """A piece of program text; ``file`` is what errors name.

    ``own``: rules of a user's own that come with it, and may not add to its predicates (``plogic.logic.safety.added``).
    """

    text: str
    file: str = "program"
    own: "Text | None" = None

    def pieces(self) -> "Iterator[Text]":
        """The text, its own, and theirs."""
        piece: Text | None = self
        while piece is not None:
            yield piece
            piece = piece.own


@dataclass(frozen=True)
class Limits:
    """Wall time and address space that one run may take.

    ``trust`` lets a program do whatever ProbLog lets it (read files, run Python).
    """

    seconds: float = 60.0
    megabytes: int = 2048
    trust: bool = False


@dataclass(frozen=True)
class Answer:
    """One answer substitution; ``interval`` bounds its probability (exact inference: both ends the same)."""

    goal: str
    probability: float
    interval: tuple[float, float]


def run(
    texts: Sequence[Text],
    goals: Sequence[str] = (),
    given: Sequence[str] = (),
    *,
    names: Names | None = None,
    limits: Limits | None = None,
) -> list[list[Answer]]:
    """P(goal | evidence) for each goal: a list of answers per goal, most probable first, ties by text.

    The first text is the program; its ``own`` and further texts are rules that may not add to its predicates. Without
    goals the program's own query/1 are asked, in one list. With ``names``, goals, evidence and rules are mapped from
    labels to atoms, and answers back. Raises ProgramError (with file, line, column as far as ProbLog knows them),
    InconsistentError, LimitError.
    """
    reply = ask(request_of(texts, goals, given, names), limits or Limits())
    return [in_order(answers) for answers in reply["answers"]]


def run_until(
    texts: Sequence[Text],
    goals: Sequence[str] = (),
    given: Sequence[str] = (),
    *,
    seconds: float,
    names: Names | None = None,
    limits: Limits | None = None,
) -> tuple[list[list[Answer]], bool]:
    """As ``run``, by a deadline: the answers that are known after ``seconds``, and whether they are exact.

    If not, an answer's interval contains its exact probability, which is given as the interval's middle; a goal with
    variables may have answers that are not known yet. A ground goal of which nothing is known is answered [0, 1].
    """
    limits = limits or Limits()
    reply = ask_until({**request_of(texts, goals, given, names), "anytime": True}, limits, seconds)
    if reply is None:
        return [unknown(goal, names) for goal in goals] or [[]], False
    return [in_order(answers) for answers in reply["answers"]], not reply.get("partial", False)


def ask_until(request: dict[str, Any], limits: Limits, seconds: float) -> dict[str, Any] | None:
    """The last reply of a fresh process after some seconds, maybe a partial one; None if there is none yet.

    Raises what went wrong in it.
    """
    reply = _last(_told(_trusted(request, limits), replace(limits, seconds=min(seconds, limits.seconds))))
    if reply is not None and "error" in reply:
        _raise(reply["error"], limits)
    return reply


def _last(text: str) -> dict[str, Any] | None:
    """The last reply that was written whole."""
    lines = text.rpartition("\n")[0].splitlines()
    return read_reply(lines[-1]) if lines else None


def read_reply(line: str | bytes) -> dict[str, Any]:
    """A reply; raises LimitError where its trees are too deep for this process."""
    try:
        reply: dict[str, Any] = json.loads(line)
    except RecursionError:
        raise errors.LimitError(TOO_DEEP) from None
    return reply


DEAD = "the process of the inference ended without an answer: {}"
CRASHES = [
    f"signal {number:d}" for number in (signal.SIGILL, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGSEGV)
]
"""How a process ends in which a compiled library crashed."""
TOO_DEEP = "the proofs are nested too deeply to be told"


def unknown(goal: str, names: Names | None) -> list[Answer]:
    """What can be said of a goal without any work: [0, 1] of a ground one, nothing of one with variables.

    Raises ProgramError.
    """
    from plogic.logic.safety.author import load_problog

    load_problog()
    from plogic.logic.grounding.load import goal_shown

    text = goal_shown(goal, names)
    return [] if text is None else [Answer(text, 0.5, (0.0, 1.0))]


def request_of(
    texts: Sequence[Text], goals: Sequence[str], given: Sequence[str], names: Names | None
) -> dict[str, Any]:
    """The request that the child process reads."""
    return {
        "texts": [{"text": piece.text, "file": piece.file} for text in texts for piece in text.pieces()],
        "goals": list(goals),
        "given": list(given),
        "names": None if names is None else names.atoms,
    }


def in_order(rows: Iterable[Sequence[Any]]) -> list[Answer]:
    """Answers from rows ``(goal, p)`` or ``(goal, low, high)``, most probable first, ties by text."""
    return sorted((_answer(*row) for row in rows), key=lambda found: (-float(f"{found.probability:.11e}"), found.goal))


def _answer(goal: str, low: float, high: float | None = None) -> Answer:
    low = min(max(low, 0.0), 1.0)
    high = low if high is None else min(max(high, 0.0), 1.0)
    return Answer(goal, low if high == low else (low + high) / 2, (low, high))


_ASKED: contextvars.ContextVar[Callable[[dict[str, Any]], dict[str, Any]] | None] = contextvars.ContextVar(
    "asked", default=None
)


@contextlib.contextmanager
def through(process: Callable[[dict[str, Any]], dict[str, Any]]) -> Iterator[None]:
    """Send every request within it to ``process``, which stays (``plogic.logic.served.engine``), with its limits."""
    token = _ASKED.set(process)
    try:
        yield
    finally:
        _ASKED.reset(token)


_END: contextvars.ContextVar[float | None] = contextvars.ContextVar("end", default=None)


@contextlib.contextmanager
def within(seconds: float) -> Iterator[None]:
    """Let all requests within it that go to fresh processes take no more than so many seconds together."""
    token = _END.set(monotonic() + seconds)
    try:
        yield
    finally:
        _END.reset(token)


def ask(request: dict[str, Any], limits: Limits) -> dict[str, Any]:
    """The reply of a fresh process; raises what went wrong in it, and LimitError when it runs out of time or memory."""
    process, end = _ASKED.get(), _END.get()
    if end is not None:
        limits = replace(limits, seconds=max(0.0, min(limits.seconds, end - monotonic())))
    request = _trusted(request, limits)
    try:
        reply = _ask(request, limits) if process is None else process(request)
        if "error" in reply:
            _raise(reply["error"], limits)
    except errors.NonGroundError as error:
        more = _kept(request["goals"])
        if not more:
            raise
        raise errors.NonGroundError(
            f"{error.reason}{more}", file=error.file, line=error.line, column=error.column
        ) from None
    except LimitError as error:
        from plogic.logic.safety.author import load_problog

        load_problog()
        from plogic.logic.safety.closest import counting
        from plogic.logic.safety.recursion import endless

        hints = endless(request["texts"], request["goals"]), counting(request["texts"], request["goals"])
        if not any(hints):
            raise
        raise LimitError("; ".join([str(error), *filter(None, hints)])) from None
    return reply


def _kept(goals: Sequence[str]) -> str:
    """What else can be said where one of these goals keeps a variable open."""
    if any("findall(" in goal for goal in goals):
        return ": write it as a rule, n(N) :- findall(...), ..., in the program or --rules FILE, and ask n(N)"
    from plogic.logic.safety.author import load_problog

    load_problog()
    from plogic.logic.safety.open_negations import half_bound

    return next(filter(None, map(half_bound, goals)), "")


def _trusted(request: dict[str, Any], limits: Limits) -> dict[str, Any]:
    """With trust, the request says so, and from which folder the program's files are looked for."""
    if not limits.trust:
        return request
    return {**request, "trust": True, "folder": str(Path(request["texts"][0]["file"]).resolve().parent)}


def _ask(request: dict[str, Any], limits: Limits) -> dict[str, Any]:
    reply = _last(_told(request, limits, late=False))
    assert reply is not None  # noqa: S101 - else it has raised
    return reply


def _told(request: dict[str, Any], limits: Limits, *, late: bool = True, end: float | None = None) -> str:
    """What the child wrote until it ended or its time was over; unless ``late``, the latter raises LimitError.

    A child in which a compiled library crashed is followed by another that does without PySDD, with the same ``end``.
    """
    end = monotonic() + limits.seconds if end is None else end
    command, memory = python("plogic.logic.served.program_child"), limits.megabytes * 2**20
    with ending_well(), Child(command, told=json.dumps(request).encode(), memory=memory) as child:
        told, over = child.rest(max(0.0, end - monotonic()))
        if not over and (status := child.wait()) > 0 and not told:  # not by a signal, as where memory ran out
            said = (child.last_words().strip().splitlines() or [f"exit status {status}"])[-1]
            if "alloc failed" in said:
                raise errors.LimitError(
                    f"the inference needs more memory than it may have: {limits.megabytes} MB, or what PLOGIC_MEMORY or ulimit say"
                )
            raise errors.LimitError(f"the process of the inference could not work: {said[:300]}")
        ended = child.end()
    if _crashed(ended, request):
        return _told({**request, "plain": True}, limits, late=late, end=end)
    if over and not late:
        raise errors.LimitError(f"the inference took longer than {limits.seconds:.3g} s")
    if not (over or late or b"\n" in told):
        raise errors.LimitError(DEAD.format(ended))
    return told.decode()


def _crashed(ended: str, request: dict[str, Any]) -> bool:
    """Whether a library crashed that another process could do without."""
    return ended in CRASHES and not request.get("plain")


def _raise(error: dict[str, Any], limits: Limits) -> None:
    kind = getattr(errors, error["kind"])
    if kind is errors.LimitError:
        raise errors.LimitError(f"the inference needs more than {limits.megabytes} MB of memory")
    if issubclass(kind, errors.ProgramError):
        places = {key: error[key] for key in ("file", "line", "column") if error.get(key) is not None}
        raise kind(error["reason"], **places)
    raise kind(error["reason"])


class Process:
    """Starts at the first question; ``close`` ends it, as does the end of the program."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.started = 0
        self._running: Child | None = None

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """The reply, which may hold an ``error``; raises LimitError where it takes too long or dies without a word."""
        running = self._alive()
        try:
            reply = read_reply(self._talk(running, json.dumps(request).encode() + b"\n"))
        except BaseException as error:  # an interruption, too, must leave no process behind that is at work
            ended = running.end()
            self.close()
            if isinstance(error, (BrokenPipeError, json.JSONDecodeError)):
                if _crashed(ended, request):
                    return self.ask({**request, "plain": True})
                raise LimitError(DEAD.format(ended)) from None
            raise
        if reply.get("error", {}).get("kind") == "LimitError":
            self.close()
        return reply

    def close(self) -> None:
        """End the process, if there is one."""
        if self._running is not None:
            self._running.end()
        self._running = None

    def _alive(self) -> Child:
        if self._running is None or not self._running.alive():
            self.close()
            self._running = Child(python("plogic.logic.served.program_child"), memory=self.limits.megabytes * 2**20)
            self.started += 1
        return self._running

    def _talk(self, running: Child, request: bytes) -> bytes:
        end = monotonic() + self.limits.seconds
        running.tell(request)
        pieces: list[bytes] = []
        while not pieces or not pieces[-1].endswith(b"\n"):
            if not heard([running], max(0.0, end - monotonic())):
                raise LimitError(f"the inference took longer than {self.limits.seconds:g} s")
            pieces.append(running.read())
            if not pieces[-1]:
                break
        return b"".join(pieces)
