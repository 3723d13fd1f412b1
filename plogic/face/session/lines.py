"""The shell without a terminal: one line after another, results on stdout, mistakes on stderr with their line."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from plogic.face.session.line_mistakes import attempted, shown
from plogic.face.session.verbs import is_end

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from plogic.face.session.session import Session


def run_lines(
    session: Session, lines: Iterable[bytes], write: Callable[[str], None], say: Callable[[str], None]
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
