"""Rows of operators that ProbLog's parser would take minutes over are refused before it begins; others are not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plogic.base.errors import ProgramError
from plogic.logic.safety.check import TOO_LONG_ROWS, parse
from plogic.logic.safety.rows import LONG, MOST, rows_in

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
