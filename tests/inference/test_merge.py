"""Ordered sums of ordered lists, against all sums sorted."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.base.clock import Clock, OutOfTimeError
from plogic.inference.merge import Stream, product, reach, sums

LAW = settings(derandomize=True, deadline=None, max_examples=200)
lists = st.lists(st.lists(st.integers(0, 9), max_size=4).map(sorted), min_size=1, max_size=5)


class Listed(Stream):
    """Solutions that are known beforehand, told one by one; counts how many were asked for."""

    def __init__(self, solutions):
        super().__init__()
        self._rest = list(solutions)

    def advance(self):
        """Tell the next one."""
        if self._rest:
            self.found.append(self._rest.pop(0))
        else:
            self.done = True


def drained(stream):
    while reach(stream, len(stream.found), Clock(None)):
        pass
    return stream.found


@LAW
@given(lists)
def test_sums_are_all_sums_sorted(values):
    expected = sorted(sum(one) for one in itertools.product(*values))
    assert list(sums([Listed(v) for v in values], Clock(None))) == expected


@LAW
@given(lists)
def test_products_are_all_sums_sorted(values):
    expected = sorted(sum(one) for one in itertools.product(*values))
    assert drained(product([Listed(v) for v in values])) == expected


def test_the_sum_of_nothing_is_one_solution_of_no_cost():
    assert list(sums([], Clock(None))) == [0]


def test_the_first_sum_asks_for_the_first_of_each_list():
    streams = [Listed([0, 1, 2]) for _ in range(4)]
    assert next(sums(streams, Clock(None))) == 0
    assert [len(stream.found) for stream in streams] == [1, 1, 1, 1]


def test_no_time_raises():
    with pytest.raises(OutOfTimeError):
        next(sums([Listed([0])], Clock(0.0)))
