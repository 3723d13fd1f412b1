"""What TAB offers: verbs, then predicates with what they mean, then the names that a goal can hold."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from prompt_toolkit.completion import CompleteEvent, Completer, Completion, PathCompleter
from prompt_toolkit.document import Document

from geometry.errors import PlogicError
from plogic.face.session.blocks import visible
from plogic.face.session.verbs import SYNONYMS, VERBS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from plogic.face.session.session import Session

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
    for text, shown, meaning in offers:
        fits = text.startswith(typed) or (text.startswith("'") and text[1:].startswith(typed))
        if fits and text.isprintable() and (text, shown) not in seen:
            seen.add((text, shown))
            yield Completion(text, start_position=-len(typed), display=visible(shown), display_meta=visible(meaning))


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
