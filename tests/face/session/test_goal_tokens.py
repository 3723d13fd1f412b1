"""The tokens of a goal, and the verbs of a line."""

from __future__ import annotations

import pytest

from plogic.base.errors import InputError
from plogic.face.session.verbs import VERBS, is_end, verb_of
from plogic.logic.safety.atoms import one_line, quoted, tokens

SAME = [
    ("present(h1)", " present( h1 ) . "),
    ("present(h1)", "present('h1')"),
    ("cause(A, h1, 'roof/apex')", "cause(A,h1,  'roof/apex'). % a comment"),
    ("\\+ a, b", "\\+a,b /* or\nso */"),
    ("X =< 0.5", "X=<0.5."),
]
OTHER = [
    ("p(a)", "p(b)"),
    ("p('A')", "p(A)"),
    ("p('a b')", "p('a  b')"),
    ("a, b", "b, a"),
    ("p(1.5)", "p(1, 5)"),
    ('p("x y")', "p('x y')"),
]


@pytest.mark.parametrize(("left", "right"), SAME)
def test_the_same_goal(left, right):
    assert tokens(left) == tokens(right)


@pytest.mark.parametrize(("left", "right"), OTHER)
def test_another_goal(left, right):
    assert tokens(left) != tokens(right)


def test_one_line_keeps_what_is_in_quotes():
    assert one_line("  a( 'x  %  y'),\n  b % no\n .\n") == "a( 'x  %  y'), b"
    assert one_line("") == ""


def test_a_quoted_name_is_one_token():
    for label in ["h1", "roof/apex", "it's", "a\\b", "Ä"]:
        assert len(tokens(quoted(label))) == 1


LINES = {
    "ask p(X)": ("ask", "p(X)"),
    "  p(X).": ("ask", "p(X)"),
    "observe\t\\+ p(a).": ("observe", "\\+ p(a)"),
    "worlds": ("worlds", ""),
    "worlds.": ("worlds", ""),
    "worlds 5.": ("worlds", "5"),
    "how p": ("why", "p"),
    "worlds(X)": ("ask", "worlds(X)"),
    "why(X), b": ("ask", "why(X), b"),
    "X is 3": ("ask", "X is 3"),
    "not p(a)": ("ask", "not p(a)"),
    "x mod y": ("ask", "x mod y"),
    "\\+ p(a)": ("ask", "\\+ p(a)"),
    "p(a), q": ("ask", "p(a), q"),
    "save a b.txt": ("save", "a b.txt"),
}


@pytest.mark.parametrize("line", LINES)
def test_the_verb_of_a_line(line):
    assert verb_of(line) == LINES[line]


@pytest.mark.parametrize(
    ("line", "told"),
    [("obsrve p(a)", "did you mean `observe`"), ("zzzz p(a)", "zzzz is no verb; `help`"), ("aks X", "`ask`")],
)
def test_a_bad_verb_is_told(line, told):
    with pytest.raises(InputError, match=told):
        verb_of(line)


def test_quit_has_two_names_and_nothing_else():
    assert all(is_end(line) for line in ["quit", "exit.", " quit "])
    assert not any(is_end(line) for line in ["quit(X)", "quitting", "", "% quit"])


def test_every_verb_of_the_issue_is_there():
    assert {"ask", "observe", "unobserve", "predict", "worlds", "why", "whynot", "listing", "save"} <= {
        verb.name for verb in VERBS
    }
