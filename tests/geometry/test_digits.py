"""Numbers of any length in the texts of strangers."""

import pytest

from geometry.digits import start_of_too_long, whole


@pytest.mark.parametrize(
    ("text", "number"),
    [("0", 0), ("007", 7), ("12", 12), ("13", None), ("", None), ("-1", None), ("²", None), ("٣", None), ("1.0", None)],
)
def test_a_whole_number_is_ascii_digits_up_to_the_largest(text, number):
    assert whole(text, 12) == number


def test_no_number_of_digits_is_too_many():
    assert whole("9" * 5000, 12) is None
    assert whole("0" * 5000, 12) == 0
    assert whole("0" * 5000 + "4", 12) == 4


def test_where_a_number_of_too_many_digits_begins():
    assert start_of_too_long(f"# {'9' * 5000}\na: {'9' * 5000}", "#.*") == 5006
    assert start_of_too_long(f"# {'9' * 5000}\na: {'9' * 4000}", "#.*") is None
