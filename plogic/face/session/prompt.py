"""The shell at a terminal: a prompt with history and completion; Ctrl-C stops a question, Ctrl-D ends the session."""

import os
import re
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from prompt_toolkit import PromptSession
from prompt_toolkit.completion import CompleteEvent, Completer, Completion, PathCompleter
from prompt_toolkit.document import Document
from prompt_toolkit.history import FileHistory, InMemoryHistory
from prompt_toolkit.key_binding import KeyBindings
from prompt_toolkit.keys import Keys
from prompt_toolkit.shortcuts import CompleteStyle

from geometry.errors import PlogicError
from geometry.printable import visible
from plogic.face.session.session import Session
from plogic.face.session.verbs import SYNONYMS, VERBS, attempted, is_end, shown


def history_file() -> Path | None:
    """``$XDG_STATE_HOME/plogic/history``, or ``~/.local/state/plogic/history`` where that is no absolute path.

    None where nobody knows the user's home.
    """
    state = os.environ.get("XDG_STATE_HOME", "")
    try:
        return (Path(state) if Path(state).is_absolute() else Path.home() / ".local" / "state") / "plogic" / "history"
    except RuntimeError:
        return None


class History(FileHistory):
    """As prompt_toolkit's, but a file that cannot be read or written costs a sentence and no session."""

    def __init__(self, path: Path, say: Callable[[str], None]) -> None:
        self.say, self.told = say, False
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError as error:
            self.tell(error)
        super().__init__(str(path))

    def load_history_strings(self) -> Iterable[str]:
        """The lines, newest first; none where they cannot be read."""
        try:
            return list(super().load_history_strings())
        except OSError as error:
            self.tell(error)
            return []

    def store_string(self, string: str) -> None:
        """Append a line, if that can be done."""
        try:
            super().store_string(string)
        except OSError as error:
            self.tell(error)

    def tell(self, error: OSError) -> None:
        """Say it, the first time."""
        if not self.told:
            self.told = True
            self.say(f"the history cannot be kept: {error.filename}: {error.strerror}")


_VERB = re.compile(r"\s*([a-z]+)\s+(.*)", re.DOTALL)
_WORD = re.compile(r"'(?:\\.|[^'\\])*\Z|\w*\Z")
"""The name that is being typed, with an open quote if it has one."""

Offer = tuple[str, str, str]
"""What is put in, what is shown, what it means."""


class GoalCompleter(Completer):
    """Completes the lines of one session."""

    def __init__(self, session: Session) -> None:
        self.session = session

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterable[Completion]:
        """The offers for the text before the cursor; none while the subject cannot be read."""
        before = document.text_before_cursor
        match = _VERB.match(before)
        verb = SYNONYMS.get(match[1], match[1]) if match else ""
        takes = next((v.takes for v in VERBS if v.name == verb), None)
        argument = match[2] if match and takes else before
        if takes == "file":
            return PathCompleter().get_completions(Document(argument), complete_event)
        try:
            return list(_completions(self._offers(takes, argument), _typed(takes, argument)))
        except (PlogicError, OSError):
            return []

    def _offers(self, takes: str | None, argument: str) -> Iterator[Offer]:
        if takes is None and not argument.strip("abcdefghijklmnopqrstuvwxyz"):
            yield from ((f"{v.name} " if " " in v.usage else v.name, v.usage, v.meaning) for v in VERBS)
        if takes == "verb":
            yield from ((v.name, v.usage, v.meaning) for v in VERBS)
            yield from ((p.name, p.signature, p.meaning) for p in self.session.predicates())
        if takes == "observed":
            yield from ((literal, literal, "") for literal in self.session.observed)
        if takes == "predicate":
            yield from ((name, name, meaning) for name, meaning in self.session.contents())
        if takes in ("goal", None):
            yield from self._goal(argument)

    def _goal(self, argument: str) -> Iterator[Offer]:
        """Predicates where a goal begins, names inside parentheses."""
        if _inside(argument):
            yield from ((name, name, meaning) for name, meaning in self.session.names())
        else:
            yield from ((f"{p.name}(" if p.arity else p.name, p.usage, p.meaning) for p in self.session.predicates())


def _typed(takes: str | None, argument: str) -> str:
    if takes in ("observed", "predicate"):
        return argument
    match = _WORD.search(argument)
    return match.group() if match else ""


def _completions(offers: Iterable[Offer], typed: str) -> Iterator[Completion]:
    """The offers that begin with what is typed; a quoted one also without its quote."""
    seen: set[tuple[str, str]] = set()
    for text, seen_as, meaning in offers:
        fits = text.startswith(typed) or (text.startswith("'") and text[1:].startswith(typed))
        if fits and text.isprintable() and (text, seen_as) not in seen:
            seen.add((text, seen_as))
            yield Completion(text, start_position=-len(typed), display=visible(seen_as), display_meta=visible(meaning))


def _inside(argument: str) -> bool:
    """Whether the cursor is inside a predicate's parentheses; those of quoted names do not count."""
    plain = re.sub(r"'(?:\\.|[^'\\])*('|\Z)|\"(?:\\.|[^\"\\])*(\"|\Z)", "q", argument)
    depth: list[bool] = []
    for i, mark in enumerate(plain):
        if mark in "([":
            depth.append(mark == "[" or (i > 0 and (plain[i - 1].isalnum() or plain[i - 1] == "_")))
        elif mark in ")]" and depth:
            depth.pop()
    return any(depth)


def run_prompt(session: Session, write: Callable[[str], None], say: Callable[[str], None]) -> int:
    """Read and do lines until the user ends the session; the exit code is 0 whatever went wrong in between."""
    write(f"{session.greeting()}; `help` lists the verbs, Ctrl-D ends the session")
    kept = history_file()
    if kept is None:
        say("the history is not kept: nobody knows your home; set HOME or XDG_STATE_HOME")
    prompt: PromptSession[str] = PromptSession(
        history=InMemoryHistory() if kept is None else History(kept, say),
        key_bindings=_keys(),
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


def _keys() -> KeyBindings:
    """What prompt_toolkit takes for a mouse, and fails over, is passed over: a colour that is pasted, say."""
    keys = KeyBindings()
    keys.add(Keys.Vt100MouseEvent)(lambda _: None)
    return keys


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
