"""Rounding by columns is Python's rounding one by one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensing.detectors.detector import rounded

NUMBERS = (
    st.floats(allow_nan=False, allow_infinity=False)
    | st.integers(-(10**7), 10**7).map(lambda n: n / 2.0**5)
    | st.floats(-1000, 1000, width=32)
)


@given(st.lists(NUMBERS), st.integers(0, 6))
def test_each_is_rounded_as_python_rounds_it(numbers, digits):
    assert [repr(x) for x in rounded(np.array(numbers, float), digits).tolist()] == [
        repr(round(x, digits)) for x in numbers
    ]


@pytest.mark.parametrize("digits", [3, 4, 5])
def test_the_middle_between_two_and_its_neighbours(digits):
    middles = (np.arange(-3000, 3000) + 0.5) / 10**digits
    numbers = np.concatenate([middles, np.nextafter(middles, np.inf), np.nextafter(middles, -np.inf)])
    assert rounded(numbers, digits).tolist() == [round(x, digits) for x in numbers.tolist()]


def test_what_is_no_number_stays():
    assert np.array_equal(
        rounded(np.array([np.nan, np.inf, -np.inf, 1.26]), 1), [np.nan, np.inf, -np.inf, 1.3], equal_nan=True
    )
    assert rounded(np.zeros((0, 2)), 4).shape == (0, 2)
