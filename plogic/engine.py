"""Runs a program through ProbLog in a process of its own, with limits, and turns whatever happens into answers or one clear error.

Making the text and running it are two functions; this one runs it. Vocabulary:

* ``Text``, one piece of program with the file that it came from, ``Text("present(h1).", "scene.pl")``
* ``Limits``, ``Limits(seconds=60, megabytes=2048)``
* ``Answer``, ``Answer("present(h1)", 0.97, (0.97, 0.97))``
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plogic import errors

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.names import Names


@dataclass(frozen=True)
class Text:
    """A piece of program text; ``file`` is what errors name."""

    text: str
    file: str = "program"


@dataclass(frozen=True)
class Limits:
    """Wall time and address space that one run may take."""

    seconds: float = 60.0
    megabytes: int = 2048


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

    The first text is the program, further ones are rules that may not add to its predicates. Without goals the program's own query/1 are
    asked, in one list. With ``names``, goals, evidence and rules are mapped from labels to atoms, and answers back.
    Raises ProgramError (with file, line, column as far as ProbLog knows them), InconsistentError, LimitError.
    """
    reply = ask(request_of(texts, goals, given, names), limits or Limits())
    return [sorted((_answer(goal, p) for goal, p in answers), key=_order) for answers in reply["answers"]]


def request_of(texts: Sequence[Text], goals: Sequence[str], given: Sequence[str], names: Names | None) -> dict[str, Any]:
    """The request that the child process reads."""
    return {
        "texts": [{"text": item.text, "file": item.file} for item in texts],
        "goals": list(goals),
        "given": list(given),
        "names": None if names is None else names.atoms,
    }


def _answer(goal: str, p: float) -> Answer:
    p = min(max(p, 0.0), 1.0)
    return Answer(goal, p, (p, p))


def _order(answer: Answer) -> tuple[float, str]:
    return -float(f"{answer.probability:.11e}"), answer.goal


def ask(request: dict[str, Any], limits: Limits) -> dict[str, Any]:
    """The reply of a fresh process; raises what went wrong in it, and LimitError when it runs out of time or memory."""
    reply = _ask(request, limits)
    if "error" in reply:
        _raise(reply["error"], limits)
    return reply


def _ask(request: dict[str, Any], limits: Limits) -> dict[str, Any]:
    command = [sys.executable, "-P", "-W", "ignore", "-m", "plogic.safety.child", str(limits.megabytes * 2**20)]
    with tempfile.TemporaryDirectory(prefix="plogic-") as scratch:
        stdout = _communicate(command, json.dumps(request), scratch, limits.seconds)
    try:
        reply: dict[str, Any] = json.loads(stdout)
    except json.JSONDecodeError:
        raise errors.LimitError(f"the inference stopped without an answer (memory limit {limits.megabytes} MB)") from None
    return reply


def _communicate(command: list[str], request: str, scratch: str, seconds: float) -> str:
    """What the child wrote; on a timeout the child goes, and the compiler that it may have started with it."""
    pipe = subprocess.PIPE
    options: dict[str, Any] = {"env": _environment(scratch), "cwd": scratch, "start_new_session": True, "text": True, "encoding": "utf-8"}
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, **options) as child:  # noqa: S603 - our own module, no shell
        try:
            return str(child.communicate(request, timeout=seconds)[0])
        except BaseException as error:  # an interruption, too, must leave no process behind
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)
            if isinstance(error, subprocess.TimeoutExpired):
                raise errors.LimitError(f"the inference took longer than {seconds:g} s") from None
            raise


def _environment(scratch: str) -> dict[str, str]:
    """The child finds the same packages as we do, and writes its scratch files where we remove them."""
    root = str(Path(__file__).resolve().parent.parent)
    path = os.pathsep.join([root, *(entry for entry in sys.path if entry)])
    return {**os.environ, "PYTHONPATH": path, "TMPDIR": scratch, "PYTHONHASHSEED": "0", "PYTHONIOENCODING": "utf-8"}


def _raise(error: dict[str, Any], limits: Limits) -> None:
    kind = getattr(errors, error["kind"])
    if kind is errors.LimitError:
        raise errors.LimitError(f"the inference needs more than {limits.megabytes} MB of memory")
    if issubclass(kind, errors.ProgramError):
        places = {key: error[key] for key in ("file", "line", "column") if error.get(key) is not None}
        raise kind(error["reason"], **places)
    raise kind(error["reason"])
