"""Rows of operators that ProbLog's parser would take minutes over are refused before it begins; others are not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plogic.base.errors import ProgramError
from plogic.logic.safety.added import idle
from plogic.logic.safety.atoms import Names
from plogic.logic.safety.author import author_rules
from plogic.logic.safety.check import TOO_DEEP, TOO_LONG_ROWS, glanced, parse
from plogic.logic.safety.recursion import endless, surely_endless
from plogic.logic.safety.rows import LONG, MOST, rows_in
from plogic.logic.served.engine import Limits, Text, run

FLOODS = {
    "conjunction": "a :- " + "b, " * 20_000 + "b.",
    "negations": "a :- " + "\\+ " * 20_000 + "b.",
    "negations without spaces": "a :- " + "\\+" * 20_000 + "b.",
    "sum": "a :- X is " + "1 + " * 20_000 + "1.",
    "alternatives": "0.0001::a; " * 20_000 + "0.0001::a.",
    "in brackets": "a(X) :- (" + "b, " * 20_000 + "b).",
    "beside brackets": "a :- " + "b(1, [2, 3]), " * 20_000 + "b.",
    "in an argument": "a(f(" + "1 + " * 20_000 + "1)).",
    "never ended": "a :- " + "b, " * 20_000,
}


@pytest.mark.parametrize("name", FLOODS)
def test_a_flood_is_refused_at_its_place(name):
    with pytest.raises(ProgramError, match="too many operators in a row") as caught:
        parse(f"c.\n{FLOODS[name]}", "x.pl")
    assert TOO_LONG_ROWS in str(caught.value)
    assert str(caught.value).startswith("x.pl:")


@pytest.mark.parametrize("piece", ["(", "[", "a(", "(,"])
def test_what_is_never_closed_is_refused_before_it_is_read_to_its_end(piece):
    with pytest.raises(ProgramError, match=TOO_DEEP) as caught:
        parse("c.\n" + piece * (2**23 // len(piece)), "x.pl")
    assert str(caught.value).startswith("x.pl:2:")


def test_a_row_without_an_end_is_given_up_where_it_is_too_long():
    assert rows_in("b, " * 10**6).work < 2 * MOST


SLOW = {
    "a row": ":- a. b(X) :- b(f(X))" + ", b" * 5000 + ".",
    "a long text": ":- a.\n" + "constraint(x) :- b(f(X)).\n" * 10_000,
    "a text that cannot be read": ":- a. b(X) :- b(f(X)). (",
}


@pytest.mark.parametrize("text", SLOW.values(), ids=SLOW)
def test_what_is_said_beside_an_answer_is_not_said_of_what_takes_long_to_read(text):
    assert glanced(text, "x.pl") is None
    assert (idle(text, "x.pl"), surely_endless(text, "x.pl")) == ([], [])
    assert endless([{"text": text, "file": "x.pl"}], ["b(x)"]) == ""


@pytest.mark.parametrize("count", [2000, 30_000])
def test_a_goal_and_rules_are_refused_that_take_long_to_read(count):
    row = "b" + ", b" * count
    with pytest.raises(ProgramError, match=r"^goal:1:1: too many operators|^goal: longer than 50000"):
        run([Text("b.")], [row], limits=Limits(seconds=50))
    with pytest.raises(ProgramError, match=TOO_LONG_ROWS.split("(")[0]):
        author_rules(f"c :- {row}.", Names({}, {}), frozenset({"b/0"}))


def test_what_is_short_is_read_at_a_glance():
    text = ":- a. b(X) :- b(f(X)). a."
    assert glanced(text, "x.pl") is not None
    assert (len(idle(text, "x.pl")), len(surely_endless(text, "x.pl"))) == (1, 1)
    assert "b/1 calls itself" in endless([{"text": text, "file": "x.pl"}], ["b(x)"])


FINE = {
    "a long list": "a([" + "1, " * 20_000 + "1]).",
    "many arguments": "a(" + "1, " * 20_000 + "1).",
    "many clauses": "a(X) :- b(X), c(X), X > 1 + 2.\n" * 20_000,
    "a comment": "% " + "a, " * 20_000 + "\na.",
    "a quoted name": "'" + "a, \\' " * 20_000 + "'.",
    "a long comment": "/* " + "a, ' " * 20_000 + "*/ a.",
    "a thousand conditions": "a :- " + "b, " * 1000 + "b.",
}


@pytest.mark.parametrize("name", FINE)
def test_what_is_long_in_another_way_is_none(name):
    assert rows_in(FINE[name]).work <= MOST


@given(
    st.lists(
        st.sampled_from(["a", ",", "(", ")", "[", "]", "'", '"', "\\", "+", ".", " ", "\n", "%", "/*", "*/"]),
        max_size=60,
    )
)
def test_any_text_is_looked_through(pieces):
    assert rows_in("".join(pieces)).work == 0  # none of its rows is longer than LONG


@given(st.integers(LONG + 1, 3 * LONG), st.integers(LONG + 1, 3 * LONG))
def test_rows_of_several_clauses_add_up(first, second):
    text = "a :- " + "b, " * (first - 1) + "b.\n" + "c :- " + "d, " * (second - 1) + "d.\n"
    found = rows_in(text)
    assert found.work == first**2 + second**2
    assert found.place == (0 if first >= second else text.index("\n"))
