"""Slips of the pen in programs are told by what would be right, at their place."""

from __future__ import annotations

import pytest

from plogic.base.errors import ProgramError
from plogic.logic.safety.check import check_source, parse


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("0.5::a\n0.4::b.", "1:6: after this something is missing at the end of the line: a full stop"),
        ("a(1).\na(2) % b.\n\nquery(a(1)).", "2:4: after this something is missing at the end of the line"),
        (
            "a :- b\n  c, d.",
            "1:6: after this something is missing at the end of the line: a full stop between clauses, a",
        ),
        ("a.\nquery(a)", "2:8: after this the last full stop is missing"),
        (":- table p/1.\np(a).", "1:4: table declares nothing in ProbLog"),
        ("a.\n:- dynamic p/1, q/2.", "2:4: dynamic declares nothing in ProbLog"),
        ("a :- 'an odd.name', heads (c1).", "1:21: no space between a name and its bracket: heads("),
        ("c :- a,\nd(X) :- a.", "1:7: a full stop ends a clause, not a comma"),
        ("0,5::a.", "1:2: a decimal has a point: 0.5"),
        ("0,5::a :- b.", "1:1: a decimal has a point: 0.5"),
        ("a. 0.2::b; 0,35::c.", "a decimal has a point: 0.35"),
        ("0.5:a.", "1:4: a probability is followed by two colons: 0.5::"),
        (".5 a.", "1:1: a probability is followed by two colons: .5::"),
        ("0.5::Heads(c1).", "1:6: Heads is a variable, for it begins with a capital letter or _"),
        ("a(X) :- X <= 3.", "1:11: it is written =<"),
        ("a(X) :- b(X), X != 3.", "1:17: it is written \\="),
        ("a := b.", "1:3: it is written :-"),
        ("if a then b.", "1:1: if is written :-"),
        ("a :- b and c.", "1:8: and is written as a comma"),
        ("a :- b || c.", "1:8: or is written as a semicolon"),
        ("a :- b c.", "1:8: before this something is missing: a comma between goals"),
        ("a :- b,.", "1:8: a goal is missing before this"),
        ("X ~ normal(0, 1).", "1:5: X ~ normal(0,1): choices of plogic are discrete"),
        ("w(X) ~ uniform([1, 2]) :- p(X).", "w(X) ~ uniform([1, 2]): choices of plogic are discrete"),
        ("a :- (b, c.\nquery(a).", "1:6: Unmatched character '('"),
        ("Rain.", "1:1: a clause must start with a predicate"),
    ],
)
def test_a_slip_is_told_at_its_place_by_what_would_be_right(text, said):
    with pytest.raises(ProgramError) as caught:
        check_source(parse(text, "u.pl"))
    assert str(caught.value).startswith("u.pl:")
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "a :- 'x (y)', b != 'c (d)'.".replace("!=", "\\="),
        "a :- X is 3 - (2), X > 0. % heads (c1), 0,5::a and b",
        "q(X, 0.5) :- \\+ (a(X), b).\n'0,5::a' :- not (b).",
        "f(0, 5). g([1,5]). 1:a. 0.5 :: b.",
        "P::a(P) :- w(P), X = 1. % a ~ b",
    ],
)
def test_what_can_be_read_is_no_slip(text):
    assert check_source(parse(text, "u.pl"))
