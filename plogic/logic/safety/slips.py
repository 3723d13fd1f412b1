r"""Slips of the pen in program text, told by what would be right instead of by what the parser expected.

They are looked for where the parser stopped, or where it read something else than a clause; elsewhere a text is never
judged by its looks. ``slip("heads (c1).", 6)``: ``Slip(0, "no space between a name and its bracket: heads(c1)")``.
"""

import re
from typing import NamedTuple


class Slip(NamedTuple):
    """Where it begins in the text, and what is wrong and would be right."""

    place: int
    said: str


DECLARED = ("table", "dynamic", "discontiguous", "multifile", "initialization")
"""Directives of other Prologs."""
NAME, END = r"[a-z]\w*+", r"""[\w)\]"}]"""
COMMA = re.compile(r"(?P<here>\b(?P<a>\d+)\s*,\s*(?P<b>\d+))\s*::"), "a decimal has a point: {a}.{b}"
"""A decimal comma, which is one wherever it stands."""
SLIPS = (
    COMMA,
    *(
        (re.compile(pattern), said)
        for pattern, said in (
            (
                rf":-\s*(?P<here>{'|'.join(DECLARED)})\b[^.]*",
                "{here} declares nothing in ProbLog, which tables every predicate by itself: leave the line out",
            ),
            (r"(?P<here>(?<![\w.])(?P<a>\d*\.\d+)\s*:)(?![:-])", "a probability is followed by two colons: {a}::"),
            (r"(?P<here>(?<![\w.])(?P<a>\d*\.\d+))\s+(?=[a-z])", "a probability is followed by two colons: {a}::"),
            (rf"(?P<here>\b(?P<a>{NAME}))\s+\((?!\s*\))", "no space between a name and its bracket: {a}("),
            (
                r"(?P<here>\b[A-Z_]\w*+)\(",
                "{here} is a variable, for it begins with a capital letter or _: a name does not",
            ),
            (
                rf"(?P<here>,)[ \t]*\n\s*{NAME}(?:\([^()]*\))?\s*:-",
                "a full stop ends a clause, not a comma",
            ),
            (r"(?P<here>!=)\s*", "it is written \\="),
            (r"(?P<here><=)\s*", "it is written =<"),
            (r"(?P<here>:=|=>)\s*", "it is written :-"),
            (r"(?P<here>\b(?:and|AND)\b|&&)", "and is written as a comma"),
            (r"(?P<here>\b(?:or|OR)\b|\|\|)", "or is written as a semicolon, ;"),
            (r"(?P<here>\bif\b)\s*", "if is written :-, as in wet :- rain."),
            (
                rf"(?P<here>{END})[ \t]*\n\s*(?=[\w:'\"\[\\(])",
                "after this something is missing at the end of the line: a full stop between clauses, a comma between goals",
            ),
            (
                rf"{END}[ \t]+(?P<here>\w++|['\"(\[\\])",
                "before this something is missing: a comma between goals, a full stop between clauses",
            ),
            (r"(?:,|:-)\s*+(?P<here>[.,])", "a goal is missing before this"),
            (rf"(?P<here>{END})\s*\Z", "after this the last full stop is missing"),
        )
    ),
)
"""What is looked for, first things first, with what is said of the part that is called ``here``."""
_HIDDEN = re.compile(r"%[^\n]*+|/\*.*?(?:\*/|\Z)|'(?:[^'\\]|\\.|'')*+(?:'|\Z)|\"(?:[^\"\\]|\\.)*+(?:\"|\Z)", re.DOTALL)
REACH = 1_000
"""Characters of a clause that are looked at on either side of a place."""


def slip(text: str, place: int | None) -> Slip | None:
    """The first slip at a place of a text, from 0; without a place, of a number's comma anywhere."""
    plain = _HIDDEN.sub(_blank, text)
    begin, end = (0, len(plain)) if place is None else (max(0, place - REACH), min(len(plain), place + REACH))
    if place is not None:
        stop = max((found.end() for found in re.finditer(r"\.\s", plain[begin:place])), default=0)
        begin += stop
    for pattern, said in (COMMA,) if place is None else SLIPS:
        for found in pattern.finditer(plain, begin, end):
            if place is None or found.start() <= place <= found.end():
                return Slip(found.start("here"), said.format(**found.groupdict()))
    return None


def _blank(found: re.Match[str]) -> str:
    """A comment as blanks, a quoted text as one name, each in as many characters and lines."""
    fill = " " if found[0][0] in "%/" else "q"
    return re.sub(r"[^\n]", fill, found[0])
