"""The shell at a terminal: a prompt with history and completion; Ctrl-C stops a question, Ctrl-D ends the session."""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING

from prompt_toolkit import PromptSession
from prompt_toolkit.shortcuts import CompleteStyle

from plogic.face.session.completion import GoalCompleter
from plogic.face.session.history import History, history_file
from plogic.face.session.line_mistakes import attempted, shown
from plogic.face.session.verbs import is_end

if TYPE_CHECKING:
    from collections.abc import Callable

    from plogic.face.session.session import Session


def run_prompt(session: Session, write: Callable[[str], None], say: Callable[[str], None]) -> int:
    """Read and do lines until the user ends the session; the exit code is 0 whatever went wrong in between."""
    write(f"{session.greeting()}; `help` lists the verbs, Ctrl-D ends the session")
    prompt: PromptSession[str] = PromptSession(
        history=History(history_file(), say),
        completer=GoalCompleter(session),
        complete_while_typing=False,
        complete_style=CompleteStyle.COLUMN,
    )
    while True:
        try:
            line = prompt.prompt(_prompt(session))
        except KeyboardInterrupt:
            continue
        except EOFError:
            return 0
        if is_end(line):
            return 0
        try:
            _do(session, line, write, say)
        except KeyboardInterrupt:
            say("interrupted; what was observed is as it was")


def _prompt(session: Session) -> str:
    """How many observations there are is part of what a question means."""
    return f"plogic ({len(session.observed)} observed)> " if session.observed else "plogic> "


def _do(session: Session, line: str, write: Callable[[str], None], say: Callable[[str], None]) -> None:
    result, mistakes = attempted(session, line)
    if result is not None:
        styled = not os.environ.get("NO_COLOR") and os.environ.get("TERM", "dumb") != "dumb"
        write(shown(result.text(width=shutil.get_terminal_size().columns, styled=styled)))
    for mistake in mistakes:
        say(mistake)
