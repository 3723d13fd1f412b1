"""``plogic shell``: ask, observe, predict, worlds, why; at a terminal with a prompt, else line by line from stdin."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from plogic.face.commands.asked import Asked


def shell_command(source: str, options: Asked, *, write: Callable[[str], None], say: Callable[[str], None]) -> int:
    """Run a session; the exit code is 1 where a line failed and nobody sat at a terminal."""
    from plogic.base.children import ending_well
    from plogic.face.session.session import Session
    from plogic.logic.safety.allowlist import TRUSTED
    from plogic.run.sources import is_program

    if source == "-":
        raise InputError("-: stdin holds the lines of the session; give the interpretation or the program as a file")
    if options.trust and is_program(source):
        say(TRUSTED)
    with ending_well(), Session.open(source, reading=options.reading, trust=options.trust) as session:
        session.greeting()

        def write_now(text: str) -> None:
            write(text)
            sys.stdout.flush()  # so that results and mistakes stay in order

        if sys.stdin.isatty() and sys.stdout.isatty():
            from plogic.face.session.prompt import run_prompt

            return run_prompt(session, write_now, say)
        from plogic.face.session.lines import run_lines

        return run_lines(session, sys.stdin.buffer, write_now, say)
