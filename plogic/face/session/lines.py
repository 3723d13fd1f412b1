"""The shell without a terminal: one line after another, results on stdout, mistakes on stderr with their line."""

import contextlib
import os
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from geometry.errors import PlogicError
from plogic.base.errors import InputError
from plogic.face.session.blocks import Result
from plogic.face.session.results import Replayed
from plogic.face.session.verbs import is_end, perform, verb_of

if TYPE_CHECKING:
    from plogic.face.session.session import Session


def attempted(session: "Session", line: str) -> tuple[Result | None, list[str]]:
    """What the line came to, and the mistakes in it, a sentence each: a line that fails never ends the session."""
    try:
        return perform(session, line), []
    except PlogicError as error:
        return None, str(error).splitlines()
    except Exception as error:  # a mistake of ours in one verb is no reason to lose the session
        if os.environ.get("PLOGIC_TRACEBACK"):
            raise
        what = " ".join(f"{type(error).__name__}: {error}".split())
        return None, [f"internal error: {what} (please report it with the traceback that PLOGIC_TRACEBACK=1 shows)"]


def shown(text: str) -> str:
    """A result's text, set off from the next by an empty line where it is more than a sentence."""
    return text.rstrip("\n") + "\n" + "\n" * ("\n" in text)


def replayed(session: "Session", file: str, text: str) -> Replayed:
    """What each line comes to; raises InputError with file and line at the first that fails."""
    results = []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            if verb_of(line)[0] == "load":
                raise InputError("a saved session loads no other")
            result = perform(session, line)
        except PlogicError as error:
            raise InputError(f"{file}:{number}: {error}") from None
        if result is not None:
            results.append(result)
    return Replayed(tuple(results))


def run_lines(
    session: "Session", lines: Iterable[bytes], write: Callable[[str], None], say: Callable[[str], None]
) -> int:
    """Do every line up to ``quit``; a line that fails is told and does not end the session. The exit code: 1 if any failed, else 0."""
    status = 0
    for number, data in enumerate(lines, 1):
        result, mistakes = None, ["is not UTF-8 text"]
        with contextlib.suppress(UnicodeDecodeError):
            line = data.decode("utf-8-sig")
            if is_end(line):
                break
            result, mistakes = attempted(session, line)
        if result is not None:
            write(shown(str(result)))
        for mistake in mistakes:
            status = 1
            say(f"plogic: line {number}: {mistake}")
    return status
