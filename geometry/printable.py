r"""Texts of strangers made fit to be printed: names, ids, keys and file names may hold anything.

What no terminal prints (escape sequences, changes of direction, separators, halves of pairs) is shown as its escape:
those of ASCII as ``\x1b`` and ``\r``, all others as JSON writes them, ``\u202e``. What ``json.dumps`` wrote holds none
of ASCII's, so that it means the same afterwards.

* ``visible("a\x1b[0m\n")``, on one line, is ``a\x1b[0m\n``
* ``shown("a\x1b[0m\n")`` leaves our own layout, ends of lines and tabs
* ``fit("a\x1b[0m\n")``, a message: its lines are cut, too
"""

import re
from collections.abc import Iterable

LONGEST = 1000
"""Characters of a message's line; of a longer one the middle is left out."""
HEAD, TAIL = 700, 240
"""Of them, those of its beginning and of its end that stay."""
_STRANGE = re.compile(r"[^ -~]+")
"""What may not be printable: a long text has little of it."""
_LEFT_OUT = re.compile(r"\.\.\. \(([0-9]{1,15}) characters left out\) \.\.\.")
LINES = 120
"""Lines of a message."""


def visible(text: str) -> str:
    """The text on one line, with an escape for every character that cannot be printed."""
    return text if text.isprintable() else _STRANGE.sub(lambda some: _escaped(some[0]), text)


def _escaped(text: str) -> str:
    return text if text.isprintable() else "".join(c if c.isprintable() else escape(c) for c in text)


def shown(text: str) -> str:
    """The text with its ends of lines and tabs, and an escape for everything else that cannot be printed."""
    return "\n".join("\t".join(map(visible, line.split("\t"))) for line in text.split("\n"))


def on_one_line(text: str, names: Iterable[str]) -> str:
    r"""A message as ``fit`` leaves it, in which names that hold an end of line stand with its escape, as ``\n``."""
    for name in names:
        if "\n" in name:
            text = text.replace(shown(name), visible(name))
    return text


def escape(sign: str) -> str:
    r"""``\x1b``, ``\u202e``, and beyond 16 bits a pair."""
    code = ord(sign)
    if code < 0x7F:
        return sign.encode("unicode_escape").decode()
    if code <= 0xFFFF:
        return f"\\u{code:04x}"
    high, low = divmod(code - 0x10000, 0x400)
    return f"\\u{0xD800 + high:04x}\\u{0xDC00 + low:04x}"


def cut(line: str) -> str:
    """Of a line that is too long its head and its end, and how many characters are left out between them.

    What was cut before, and has got a longer beginning since, is cut again, and counted rightly.

    >>> len(cut("n" * 40_000)) <= LONGEST, cut("file:1: " + cut("n" * 40_000))[:10]
    (True, 'file:1: nn')
    """
    if len(line) <= LONGEST:
        return line
    before = _LEFT_OUT.search(line)
    head, tail = (line[:-TAIL], line[-TAIL:]) if before is None else (line[: before.start()], line[before.end() :])
    left_out = (0 if before is None else int(before[1])) + len(head[HEAD:]) + len(tail[:-TAIL])
    return f"{head[:HEAD]}... ({left_out} characters left out) ...{tail[-TAIL:]}"


def fit(text: str) -> str:
    """A message as it is told: what cannot be printed as its escape, lines cut, at most ``LINES`` of them."""
    lines = text.split("\n")
    more = len(lines) - LINES
    told = [cut(shown(line)) for line in lines[:LINES]]
    return "\n".join(told if more <= 0 else [*told, f"and {more} more lines"])
