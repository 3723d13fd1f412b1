"""The tokens of a goal as a user types it: enough to complete it, to compare two of them and to put one on one line; no parser.

``tokens("present( 'h1' ).")`` → ``("present", "(", "h1", ")")``; what a goal means is for ProbLog's parser to say.
"""

from __future__ import annotations

import re

from plogic.logic.safety.atoms import own_atom

_TOKEN = re.compile(
    r"""(?P<gap>\s+|%[^\n]*|/\*.*?\*/)
      | (?P<quoted>'(?:\\.|''|[^'\\])*' | "(?:\\.|""|[^"\\])*")
      | (?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)
      | (?P<word>\w+)
      | (?P<mark>\\\+|=\\=|\\==|\\=|:-|=<|>=|=:=|=\.\.|-->|->|::|.)""",
    re.VERBOSE | re.DOTALL,
)


def tokens(goal: str) -> tuple[str, ...]:
    """The tokens without white space, comments and a last full stop; a quoted name that needs no quotes loses them."""
    found = [_plain(match.group()) for match in _TOKEN.finditer(goal) if match.lastgroup != "gap"]
    return tuple(found[:-1] if found and found[-1] == "." else found)


def one_line(goal: str) -> str:
    """The goal as it was typed, each gap outside quotes a single space, without comments and a last full stop."""
    pieces: list[str] = []
    for match in _TOKEN.finditer(goal):
        piece = " " if match.lastgroup == "gap" else match.group()
        if piece != " " or (pieces and pieces[-1] != " "):
            pieces.append(piece)
    while pieces and pieces[-1] == " ":
        pieces.pop()
    return "".join(pieces[:-1] if pieces and pieces[-1] == "." else pieces).rstrip(" ")


def is_ground(goal: str) -> bool:
    """Whether the goal has no variable, not even ``_``."""
    return not any(token[0].isupper() or token[0] == "_" for token in tokens(goal))


def quoted(label: str) -> str:
    """A name as a goal writes it: ``h1``, ``'roof/apex'``."""
    return label if own_atom(label) else "'" + label.replace("\\", "\\\\").replace("'", "\\'") + "'"


def _plain(token: str) -> str:
    inner = token[1:-1]
    return inner if token[0] in "'\"" and own_atom(inner) else token
