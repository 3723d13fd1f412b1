"""What strangers name anything is escaped before it is printed, and messages are short."""

from __future__ import annotations

import json
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.errors import PlogicError, told
from geometry.printable import HEAD, LINES, LONGEST, TAIL, cut, fit, shown, visible

TEXT = st.text(st.characters())  # halves of pairs as well


@pytest.mark.parametrize(
    ("raw", "escaped"),
    [
        ("\x1b[31m", "\\x1b[31m"),
        ("\r\x08\x00", "\\r\\x08\\x00"),
        ("\x9b1m\x85\x7f", "\\u009b1m\\u0085\\u007f"),
        ("\u202e\u2066\u200f\u061c", "\\u202e\\u2066\\u200f\\u061c"),
        ("\u2028\u2029", "\\u2028\\u2029"),
        ("\udcff", "\\udcff"),
        ("\U000e0041", "\\udb40\\udc41"),
    ],
)
def test_what_no_terminal_prints_is_its_escape(raw, escaped):
    assert visible(f"a{raw}é") == f"a{escaped}é"
    assert shown(f"a{raw}\n\té") == f"a{escaped}\n\té"


@given(TEXT)
def test_only_ends_of_lines_and_tabs_are_left(text):
    assert visible(text).isprintable()
    assert shown(text).replace("\n", "").replace("\t", "").isprintable()
    assert shown(shown(text)) == shown(text)


@given(st.dictionaries(TEXT, TEXT), st.booleans())
def test_json_means_the_same_afterwards(document, plain):
    text = shown(json.dumps(document, ensure_ascii=plain, indent=1))
    assert text.replace("\n", "").isprintable()
    assert json.loads(text) == json.loads(json.dumps(document))


@given(st.integers(0, 5 * LONGEST), st.integers(0, LONGEST))
def test_a_line_that_is_cut_tells_how_much_is_left_out(length, more):
    line = "m" * more + cut("n" * length)
    told = cut(line)
    assert len(told) <= LONGEST
    assert cut(told) == told
    if more + length <= LONGEST:
        assert told == line
        return
    head, note, tail = re.fullmatch(r"([mn]+)\.\.\. \((\d+) characters left out\) \.\.\.([mn]+)", told).groups()
    assert len(head) + int(note) + len(tail) == more + length, "also where it was cut before"
    assert (len(head) <= HEAD + more, len(tail)) == (True, TAIL)


def test_a_message_has_a_few_short_lines_whatever_it_repeats():
    error = PlogicError("\n".join(f"{i}: \x1b[2J{'n' * 4_000}" for i in range(500)))
    lines = str(error).split("\n")
    assert len(lines) == LINES + 1
    assert lines[-1] == f"and {500 - LINES} more lines"
    assert max(map(len, lines)) <= LONGEST
    assert fit(str(error)) != ""
    assert "\x1b" not in str(error)


def test_a_mistake_is_one_line_whatever_it_repeats():
    assert told(["t\nplogic: all is well: wrong", "b\r\u2028: missing"]).split("\n") == [
        "t\\nplogic: all is well: wrong",
        "b\\r\\u2028: missing",
    ]
