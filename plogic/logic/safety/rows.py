"""How long ProbLog's parser would take over rows of operators, told before it begins.

It takes time by the square of the operators that stand in one row, ``a, b, c`` or ``- - a``, whatever is in brackets
between them: 38 seconds for 20,000. Arguments of a term and elements of a list are no row. What is nested deeper than
any run can follow is told, too: 8 MB of ``(`` would cost the parser minutes.
"""

import re
from dataclasses import dataclass

LONG = 200
"""Operators of a row up to which the square does not count: it is read as quickly as any text."""
MOST = 16_000_000
"""Sum of the squares of all longer rows: 4,000 operators in one, over which the parser took 4 seconds here."""
DEEPEST = 20_000
"""Brackets in each other."""
SHORT_TEXT = 50_000
"""Characters of a text that is read quickly."""
QUICK = 1_000_000
"""``Rows.work`` of a text that is read quickly: a row of a thousand operators, a quarter of a second."""
_TOKEN = re.compile(
    r"""'(?:[^'\\]|\\(?:.|\Z)|'')*+(?:'|\Z)|"(?:[^"\\]|\\(?:.|\Z))*+(?:"|\Z)|%[^\n]*+|/\*.*?(?:\*/|\Z)"""
    r"""|(?P<open>[\w'"]?[(\[{])|(?P<close>[)\]}])|(?P<stop>\.(?=\s|\Z))|(?P<comma>,)"""
    r"""|(?P<operator>\\\+|[-+*/\\^<>=~:?@#&$;|]{1,3}|\b(?:is|mod|rem|div|xor|rdiv)\b)""",
    re.DOTALL,
)
"""Whatever is not closed reaches to the end, so that nothing is looked at twice."""


@dataclass
class _Row:
    """Where it begins, whether a comma is one of its operators, and how many it has so far."""

    begin: int
    of_commas: bool = True
    operators: int = 0


@dataclass
class Rows:
    """``work``: the sum of the squares of a text's long rows; ``place``: where the longest begins, 0 where none is.

    ``deep``: the place of a bracket in which too many stand, and None where there is none.
    """

    work: int = 0
    place: int = 0
    longest: int = LONG
    deep: int | None = None

    def add(self, *ended: _Row) -> None:
        """Count rows to which nothing more belongs."""
        for row in ended:
            if row.operators > LONG:
                self.work += row.operators**2
            if row.operators > self.longest:
                self.longest, self.place = row.operators, row.begin


def rows_in(text: str) -> Rows:
    """The rows of a text, read until they are too long, or too many in each other."""
    rows, found = [_Row(0)], Rows()
    for token in _TOKEN.finditer(text):
        kind = token.lastgroup
        if kind == "open":
            rows.append(_Row(token.start(), token[0] in ("(", "{")))
        elif kind == "operator" or (kind == "comma" and rows[-1].of_commas):
            rows[-1].operators += 1
        elif kind == "comma":
            found.add(rows.pop())
            rows.append(_Row(token.end(), of_commas=False))
        elif kind == "close" and len(rows) > 1:
            found.add(rows.pop())
        elif kind == "stop":
            found.add(*rows)
            rows = [_Row(token.end())]
        if len(rows) > DEEPEST:
            found.deep = token.start()
        if found.work > MOST or found.deep is not None or rows[-1].operators ** 2 > MOST:
            break
    found.add(*rows)
    return found


def is_quick(text: str) -> bool:
    """Whether the parser takes no time worth speaking of."""
    return len(text) <= SHORT_TEXT and rows_in(text).work <= QUICK
