"""What is said of a program before it runs, and of what nothing is said."""

from __future__ import annotations

import pytest

from plogic.logic.safety.notes import MOST, notes

WORLD = "0.5::sick(ann). 0.3::sick(bob). person(ann). person(bob). on(ann, bob).\n"


@pytest.mark.parametrize(
    ("rule", "goals", "said"),
    [
        ("well(X) :- \\+ sick(X), person(X).\nquery(well(_)).", (), "2:12: \\+ sick(X) is asked before X has a value"),
        ("well(X) :- \\+ sick(X), person(X).", ("well(W)",), "write it after person(X)"),
        ("some :- not(sick(X)), person(X).", ("some",), "not(sick(X)) is asked before X has a value"),
        ("two :- X \\= Y, person(X), person(Y).", ("two",), "X\\=Y is asked before X and Y have values"),
        ("a(X) :- b(X, ann).\nb(X, Y) :- \\+ on(X, Y), on(X, Z).", ("a(X)",), "3:12: \\+ on(X,Y) is asked before X "),
        ("n(N) :- findall(X, (\\+ sick(X), person(X)), L), length(L, N).", ("n(N)",), "2:21: \\+ sick(X)"),
        ("all :- \\+ (person(X), \\+ on(X, Y), person(Y)).", ("all",), "\\+ on(X,Y) is asked before Y"),
        ("well(X) :- (\\+ sick(X) ; fail), person(X).", ("well(_)",), "\\+ sick(X) is asked before X"),
        ("constraint(bad(X)) :- \\+ sick(X), person(X).", (), "\\+ sick(X) is asked before X"),
        ("evidnce(sick(ann)).", (), "2:1: evidnce(sick(ann)) is a fact that observes nothing; the closest name"),
        ("qeury(\\+ sick(ann)).", (), "is a fact that asks nothing; the closest name that does is query"),
        ("evidence(sick(ann), True).", (), "observes nothing: its second argument is true or false"),
        ("evidence(sick(ann), tru).", (), "observes nothing: its second argument is true or false"),
    ],
)
def test_what_is_surely_not_meant_is_told_with_its_place(rule, goals, said):
    (line,) = notes(WORLD + rule, "u.pl", goals, added=True)
    assert line.startswith("u.pl:")
    assert said in line


@pytest.mark.parametrize(
    ("rule", "goals"),
    [
        ("well(X) :- person(X), \\+ sick(X).", ("well(X)",)),
        ("well(X) :- \\+ sick(X), person(X).", ("well(ann)",)),
        ("well(X) :- \\+ sick(X), person(X).\nquery(well(Y)) :- person(Y).", ()),
        ("bare(X) :- person(X), \\+ on(_, X), \\+ on(Y, X).", ("bare(X)",)),
        ("none(X, Y) :- \\+ sick(Z), X > Y, person(Z1).", ("none(1, 2)",)),
        ("all(_) :- forall(person(X), sick(X)), person(ann).", ("all(_)",)),
        ("in([X | L], Y) :- \\+ sick(X), in(L, Y).\nin([], _).", ("in([ann], Y)",)),
        ("well(X) :- \\+ sick(X), X @< bob.", ("well(X)",)),
        ("well(X) :- \\+ sick(Y), X = Y, person(X).", ("well(X)",)),
        ("evidence(X, Y) :- seen(X, Y).\nseen(sick(ann), true).", ()),
        ("evident(ann). entry(sick(ann)). q(X) :- quary(X). quary(sick(ann)).", ("q(X)",)),
        ("evidence(sick(ann), false). query(\\+ sick(ann)).", ()),
        ("well(X) :- \\+ sick(X), person(X", ("well(X)",)),
    ],
)
def test_what_may_be_meant_is_not_told(rule, goals):
    assert notes(WORLD + rule, "u.pl", goals, added=True) == []


def test_of_many_notes_the_first_are_told_and_the_rest_counted():
    many = "".join(f"p{i}(X) :- \\+ q(X), r(X). query(p{i}(_)).\n" for i in range(30))
    lines = notes(many, "u.pl")
    assert (len(lines), lines[-1]) == (MOST + 1, "u.pl: and 10 more of such notes")


def test_what_is_nested_too_deeply_is_told_elsewhere():
    assert notes("a :- " + "\\+ (" * 5000 + "b(X), c(X)" + ")" * 5000 + ", d(X).\nquery(a).", "u.pl") == []
